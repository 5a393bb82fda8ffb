// The outputs of a live run: a button that records, and how long each output has run.

import { addressOf, ask, NO_ANSWER } from "./ask.js";
import { byId } from "./elements.js";

const button = byId("record-button");
let ended = null; // names of recordings that are known to have ended; null: no figures came yet
let ending = ""; // the name of a recording that has just ended, and its number of pictures so far

/** Make the button record. session(): the session's name.  onError(text): shows a refusal. */
export function wireRecord(session, onError) {
  let isBusy = false; // not `disabled`, which would take the focus from the button
  button.onclick = async ({ detail }) => {
    if (isBusy || detail > 1) return; // detail: 2 at the second click of a double click
    const on = button.getAttribute("aria-pressed") !== "true";
    onError("");
    isBusy = true;
    try {
      const address = addressOf("/recording", session(), { on: on ? 1 : 0 });
      const response = await ask(address, { method: "POST" });
      const answer = await response.json();
      if (response.ok) button.setAttribute("aria-pressed", answer.on);
      else onError(answer.error);
    } catch {
      onError(`The recording could not be changed: ${NO_ANSWER}`);
    }
    isBusy = false;
  };
}

/** Show the button only to the user of the camera's machine, since others may not record. */
export function showRecord(isOwner) {
  button.hidden = !isOwner;
}

/** Forget all recordings; called when the connection is lost. */
export function forgetRecordings() {
  button.setAttribute("aria-pressed", "false");
  ended = null;
}

/** A time in seconds as "1:02:03" or "2:03". */
function time(seconds) {
  const [h, m, s] = [seconds / 3600, (seconds / 60) % 60, seconds % 60].map(Math.floor);
  const two = (number) => String(number).padStart(2, "0");
  return h ? `${h}:${two(m)}:${two(s)}` : `${m}:${two(s)}`;
}

/** [text, class, title] for each recording and stream that runs. Updates the record button, too. */
export function outputs(sinks = []) {
  const running = sinks.filter(({ is_over: isOver }) => !isOver);
  button.setAttribute("aria-pressed", running.some(({ by_page: isByPage }) => isByPage));
  return running.flatMap(({ kind, name, seconds }) => {
    if (kind === "recording") return [[`● REC ${time(seconds)}`, "recording", name]];
    if (kind !== "stream") return [];
    const state = seconds > 0 ? `● LIVE ${time(seconds)}` : "○ not connected";
    return [[state, seconds > 0 ? "recording" : "alarming", name]];
  });
}

/** A text about a page's recording that has just ended, such as where it is; otherwise "". */
export function endOfRecording({ sinks = [], notice = "" }) {
  const over = sinks.filter((sink) => sink.is_over && sink.by_page);
  ended ??= new Set(over.map(({ name }) => name));
  const last = over.find(({ name }) => !ended.has(name));
  const before = ending;
  ending = last ? `${last.name} ${last.pictures}` : "";
  if (!last || ending !== before) return ""; // the recording may still write its last pictures
  ended.add(last.name);
  if (notice.includes(last.name)) return ""; // the recording failed, and the notice says why
  if (!last.pictures) return "Nothing was recorded: the camera sent no frames.";
  const what = `${last.name} (${time(last.seconds)})`;
  return `${what} was saved in the folder where makeup-video was started.`;
}
