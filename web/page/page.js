// The page: connects the server's messages with the parts of the page.

import { Compare } from "./compare.js";
import { Connection } from "./connection.js";
import { Controls } from "./controls.js";
import { nameAfter, nameAs, openLook, showError, wireKeep } from "./keep.js";
import { listenToKeys } from "./keys.js";
import { LookStore } from "./look.js";
import { ReadyLooks } from "./looks.js";
import { Picture } from "./picture.js";
import { hideFigures, showFigures, showVeil } from "./status.js";
import { Photos } from "./upload.js";

const LOST = "The connection was lost. Reconnecting …";
const STOPPED = "makeup-video was stopped. Start it again to see the picture here.";
const WAITING = "Waiting for the first picture …";

const byId = (id) => document.getElementById(id);
let hello = null;
let controls = null;

const store = new LookStore((look, n) => connection.send({ type: "look", look, n }));
const picture = new Picture(
  byId("picture"),
  (pts) => connection.send({ type: "shown", pts_us: pts }),
  (width, height) => byId("stage").style.setProperty("--ratio", width / height),
);
const compare = new Compare(picture, (on) => connection.send({ type: "compare", on }));
// without a count: the server returns the look with its defaults filled in
const sendFile = (look) => connection.send({ type: "look", look });
const ready = new ReadyLooks(store, nameAs);
const photos = new Photos({
  look: (file) => openLook(file, sendFile),
  photo: nameAfter,
  portrait: () => ready.draw(),
});

const connection = new Connection({
  hello: welcome,
  look({ look, photo, seen }) {
    store.receive(look, photo?.look, seen);
    if (photo) showPhoto(photo);
  },
  figures: showFigures,
  error: ({ text }) => (hello === null ? showVeil(text) : showError(text)),
  bye: () => showVeil(STOPPED),
  lost(stopped) {
    ready.pause();
    hideFigures();
    showVeil(stopped ? STOPPED : LOST);
  },
  picture(received) {
    showVeil(null);
    picture.show(received);
  },
});

function welcome(message) {
  const forgotten = hello !== null && message.mode === "demo" && message.session !== hello.session;
  const mine = store.look;
  hello = message;
  document.title = `makeup-video ${hello.mode}`;
  document.body.dataset.mode = hello.mode;
  byId("mirror-button").hidden = hello.mode === "demo"; // only of use before a camera
  store.start(hello.look, forgotten ? store.photoLook : (hello.photo?.look ?? null));
  controls ??= new Controls(hello, store);
  photos.start(hello);
  ready.start(hello);
  if (hello.photo) showPhoto(hello.photo);
  if (forgotten) store.replace(mine);
  compare.askAgain();
  showVeil(picture.isShown ? null : WAITING);
}

/** Show the last photo that was read, here or on another page, and its look in words. */
function showPhoto({ name, words }) {
  byId("look-words").textContent = words;
  photos.name("photo", name);
}

/** Make a button switch on and off; returns the switch. */
function toggle(id, change) {
  const button = byId(id);
  return (button.onclick = () => {
    const on = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", on);
    change(on);
  });
}

function wireTools() {
  const toggleCompare = toggle("compare-button", (on) => (compare.isOn = on));
  const toggleMirror = toggle("mirror-button", (on) => (picture.mirrored = on));
  const help = () => byId("help").showModal();
  const full = () =>
    document.fullscreenElement ? document.exitFullscreen() : byId("viewer").requestFullscreen();
  byId("help-button").onclick = help;
  byId("full-button").onclick = full;
  byId("full-button").hidden = !document.fullscreenEnabled; // not on iPhones
  document.addEventListener("fullscreenchange", () =>
    byId("full-button").setAttribute("aria-pressed", document.fullscreenElement !== null),
  );
  listenToKeys({
    compare() {
      toggleCompare();
      compare.focus();
    },
    mirror: () => hello?.mode === "live" && toggleMirror(),
    full,
    help,
    held: (on) => (compare.isHeld = on),
    undo: () => store.undo(),
    redo: () => store.redo(),
  });
}

wireKeep(store, () => hello?.session ?? "", sendFile);
wireTools();
