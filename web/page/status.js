// The state of the run: figures, notices, and the veil that hides the picture's place without one.

import { byId, el } from "./elements.js";
import { endOfRecording, forgetRecordings, outputs } from "./record.js";

const LATE_MS = 150; // a longer delay between lips and voice is visible
const NOTICE_MS = 10_000;

const figures = byId("figures");
const notice = byId("notice");
const veil = byId("veil");
let lastNotice = ""; // the last notice about a slow machine
let showUntil = 0;
let ofRun = ""; // the notice of the run
let told = ""; // the notice of the page itself, which comes first
let telling = 0;
const noticeText = notice.querySelector("span");
const said = byId("said"); // the same text for screen readers
let closed = ""; // the notice of the run that the visitor has closed
let whyJpeg = ""; // why the page shows JPEG although H.264 would use less of the network

/** Show the figures below the picture, and notices for the visitor over the picture. */
export function showFigures(values) {
  const delay = values.screen_ms ?? values.latency_ms;
  const parts = [
    ...outputs(values.sinks),
    [`${Math.round(values.fps)} fps`, ""],
    delay == null ? null : [`${Math.round(delay)} ms latency`, delay > LATE_MS ? "alarming" : ""],
    values.level > 0 ? ["slow machine", "alarming", values.level_notice] : null,
    values.dropped > 0 ? [`${values.dropped} dropped`, "minor"] : null,
    values.damaged > 0 ? [`${values.damaged} damaged`, "minor"] : null,
    whyJpeg ? ["JPEG", "", whyJpeg] : null,
    values.viewers > 1 ? [`${values.viewers} viewers`, "minor"] : null,
  ];
  figures.hidden = false;
  figures.replaceChildren(
    ...parts
      .filter((part) => part !== null)
      .map(([textContent, className, title = ""]) => el("span", { textContent, className, title })),
  );
  ofRun = values.notice || recent(values.level > 0 ? values.level_notice : "");
  const end = endOfRecording(values);
  if (end) tell(end);
  else showNotice();
}

/** Mention JPEG among the figures, with the reason for it; "" if JPEG is the better choice. */
export function tellWhyJpeg(why) {
  whyJpeg = why;
}

/** The notice about a slow machine, or "" some time after it changed; figures always show it. */
function recent(text) {
  if (text !== lastNotice) showUntil = performance.now() + NOTICE_MS;
  lastNotice = text;
  return performance.now() < showUntil ? text : "";
}

/** Show a notice over the picture for some time; "" removes it. */
export function tell(text) {
  told = text;
  clearTimeout(telling);
  if (text) telling = setTimeout(() => tell(""), NOTICE_MS);
  showNotice();
}

/** Show an error over the picture if it fills the screen, which hides the rest of the page. */
export function tellInFullScreen(text) {
  if (document.fullscreenElement) tell(text);
}

function showNotice() {
  if (ofRun === "") closed = "";
  const text = told || (ofRun === closed ? "" : ofRun);
  if (noticeText.textContent !== text) noticeText.textContent = text;
  notice.hidden = text === "";
  say(text);
}

function say(text) {
  if (said.textContent !== text) said.textContent = text; // each change would be announced
}

notice.querySelector("button").onclick = () => {
  if (told) return tell("");
  closed = ofRun; // only another notice will be shown
  showNotice();
};

/** Show nothing about the run; called when the connection is lost. */
export function hideFigures() {
  figures.hidden = true;
  ofRun = "";
  showNotice();
  forgetRecordings();
}

/** Show a text over the picture; null removes it. */
export function showVeil(text) {
  veil.hidden = text === null;
  if (text !== null && veil.firstElementChild.textContent !== text)
    veil.firstElementChild.textContent = text;
}
