// What the page says of the run: figures, notices, and the veil over the picture while there is none.

const LATE_MS = 150; // from here on lips and voice drift apart visibly

const figures = document.getElementById("figures");
const notice = document.getElementById("notice");
const veil = document.getElementById("veil");

/** A quiet line of figures; what a person should do something about is said over the picture. */
export function showFigures(values) {
  const delay = values.screen_ms ?? values.latency_ms;
  const parts = [
    [`${Math.round(values.fps)} frames/s`, false],
    delay == null ? null : [`${Math.round(delay)} ms delay`, delay > LATE_MS],
    values.dropped > 0 ? [`${values.dropped} dropped`, false] : null,
    values.viewers > 1 ? [`${values.viewers} viewers`, false] : null,
    values.level > 0 ? [values.level_told, true] : null,
  ];
  figures.hidden = false;
  figures.replaceChildren(...parts.filter((part) => part !== null).map(([text, alarming]) => {
    const span = document.createElement("span");
    span.textContent = text;
    span.classList.toggle("alarming", alarming);
    return span;
  }));
  if (notice.textContent !== (values.notice ?? "")) notice.textContent = values.notice ?? "";
  notice.hidden = !values.notice;
}

export function hideFigures() {
  figures.hidden = true;
  notice.hidden = true;
}

/** Over the picture; null takes the veil away. */
export function showVeil(text) {
  veil.hidden = text === null;
  if (text !== null && veil.firstElementChild.textContent !== text) veil.firstElementChild.textContent = text;
}
