// The state of the run: figures, notices, and the veil over the picture while there is none.

import { byId, el } from "./elements.js";
import { endOfRecording, forgetRecordings, outputs } from "./record.js";

const LATE_MS = 150; // a longer delay between lips and voice is visible
const NOTICE_MS = 10_000;

const figures = byId("figures");
const notice = byId("notice");
const veil = byId("veil");
let lastNotice = ""; // about a slow machine
let showUntil = 0;
let ofRun = ""; // the notice of the run
let told = ""; // by the page itself, which comes first
let telling = 0;
const noticeText = notice.querySelector("span");
const said = byId("said"); // the same text for screen readers
let closed = ""; // the notice of the run that the visitor has closed
let whyJpeg = ""; // where H.264 would spare the network

/** Show the figures below the picture, and over it what needs the visitor's attention. */
export function showFigures(values) {
  const delay = values.screen_ms ?? values.latency_ms;
  const parts = [
    ...outputs(values.sinks),
    [`${Math.round(values.fps)} fps`, ""],
    delay == null ? null : [`${Math.round(delay)} ms latency`, delay > LATE_MS ? "alarming" : ""],
    values.level > 0 ? ["slow machine", "alarming", values.level_notice] : null,
    values.dropped > 0 ? [`${values.dropped} dropped`, "minor"] : null,
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

/** Mention JPEG among the figures, with the reason; "" where it is the better choice. */
export function tellWhyJpeg(why) {
  whyJpeg = why;
}

/** The notice about a slow machine, for a while after it changes; the figures always mention it. */
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

/** Show an error over the picture in full screen, where nothing else of the page is seen. */
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
  closed = ofRun; // another notice is shown
  showNotice();
};

/** Show nothing of the run while there is no connection. */
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
