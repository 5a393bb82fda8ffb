// What the page says of the run: figures, notices, and the veil over the picture while there is none.

import { el } from "./elements.js";

const LATE_MS = 150; // from here on lips and voice drift apart visibly
const TOLD_MS = 10_000;

const figures = document.getElementById("figures");
const notice = document.getElementById("notice");
const veil = document.getElementById("veil");
let level = ""; // what was told last of a slow machine
let tellUntil = 0;

/** A quiet line of figures; what a person should do something about is said over the picture. */
export function showFigures(values) {
  const delay = values.screen_ms ?? values.latency_ms;
  const parts = [
    [`${Math.round(values.fps)} frames/s`, ""],
    delay == null ? null : [`${Math.round(delay)} ms delay`, delay > LATE_MS ? "alarming" : ""],
    values.level > 0 ? ["slow machine", "alarming", values.level_notice] : null,
    values.dropped > 0 ? [`${values.dropped} dropped`, "minor"] : null,
    values.viewers > 1 ? [`${values.viewers} viewers`, "minor"] : null,
  ];
  figures.hidden = false;
  figures.replaceChildren(
    ...parts
      .filter((part) => part !== null)
      .map(([textContent, className, title = ""]) => el("span", { textContent, className, title })),
  );
  showNotice(values.notice || levelNews(values.level > 0 ? values.level_notice : ""));
}

/** What is done about a slow machine is told for a while when it changes; a word of it stays. */
function levelNews(told) {
  if (told !== level) tellUntil = performance.now() + TOLD_MS;
  level = told;
  return performance.now() < tellUntil ? told : "";
}

function showNotice(text) {
  if (notice.textContent !== text) notice.textContent = text;
  notice.hidden = text === "";
}

export function hideFigures() {
  figures.hidden = true;
  notice.hidden = true;
}

/** Over the picture; null takes the veil away. */
export function showVeil(text) {
  veil.hidden = text === null;
  if (text !== null && veil.firstElementChild.textContent !== text)
    veil.firstElementChild.textContent = text;
}
