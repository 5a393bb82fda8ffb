// The outputs of a live run: a button that records, and how long each output has run.

const button = document.getElementById("record-button");
const NO_ANSWER = "The recording could not be changed: the server does not answer.";

/** Show the button before a camera. session(): its name.  onError(text): shows a refusal. */
export function wireRecord(session, onError) {
  let isBusy = false; // not `disabled`, which would take the focus from the button
  button.onclick = async () => {
    if (isBusy) return;
    const on = button.getAttribute("aria-pressed") !== "true";
    onError("");
    isBusy = true;
    try {
      const address = `/recording?session=${encodeURIComponent(session())}&on=${on ? 1 : 0}`;
      const response = await fetch(address, { method: "POST" });
      const answer = await response.json();
      if (response.ok) button.setAttribute("aria-pressed", answer.on);
      else onError(answer.error);
    } catch {
      onError(NO_ANSWER);
    }
    isBusy = false;
  };
}

/** Show the button to the user of the camera's machine alone: others may not record. */
export function showRecord(isOwner) {
  button.hidden = !isOwner;
}

/** "1:02:03" or "2:03". */
function time(seconds) {
  const [h, m, s] = [seconds / 3600, (seconds / 60) % 60, seconds % 60].map(Math.floor);
  const two = (number) => String(number).padStart(2, "0");
  return h ? `${h}:${two(m)}:${two(s)}` : `${m}:${two(s)}`;
}

/** [text, class, title] for each recording and stream that runs; presses the button to match. */
export function outputs(sinks = []) {
  const running = sinks.filter(({ is_over: isOver }) => !isOver);
  const isByPage = ({ kind, name }) => kind === "recording" && /^makeup-\d{8}-\d{6}(-\d+)?\.mkv$/.test(name);
  button.setAttribute("aria-pressed", running.some(isByPage));
  return running.flatMap(({ kind, name, seconds }) => {
    if (kind === "recording") return [[`● REC ${time(seconds)}`, "recording", name]];
    if (kind !== "stream") return [];
    const state = seconds > 0 ? `● LIVE ${time(seconds)}` : "○ not connected";
    return [[state, seconds > 0 ? "recording" : "alarming", name]];
  });
}
