// The page: connects the server's messages with the parts of the page.

import { showCameras } from "./camera.js";
import { changesSince } from "./changes.js";
import { Compare } from "./compare.js";
import { Connection } from "./connection.js";
import { Controls } from "./controls.js";
import { nameAfter, nameAs, openLook, showError, wireKeep } from "./keep.js";
import { listenToKeys } from "./keys.js";
import { LookStore } from "./look.js";
import { Looks } from "./looks.js";
import { Picture } from "./picture.js";
import { Shades } from "./shades.js";
import { showRecord, wireRecord } from "./record.js";
import { hideFigures, showFigures, showVeil, tellWhyJpeg } from "./status.js";
import { Photos } from "./upload.js";
import { choosePictures, FAILED } from "./video.js";
import { Zoom } from "./zoom.js";

const LOST = "The connection was lost. Reconnecting …";
const STOPPED = "makeup-video was stopped. Start it again to see the picture here.";
const NOT_SENT = "The look could not be opened: the connection is lost.";
const WAITING = "Waiting for the first frame …";

const byId = (id) => document.getElementById(id);
let hello = null;
let controls = null;
let pictureKind = choosePictures(); // until a decoder fails

const store = new LookStore((look, n) => connection.send({ type: "look", look, n }));
const picture = new Picture(
  byId("picture"),
  (pts) => connection.send({ type: "shown", pts_us: pts }),
  (width, height) => byId("stage").style.setProperty("--ratio", width / height),
  () => {
    pictureKind = Promise.resolve({ isVideo: false, why: FAILED });
    tellWhyJpeg(FAILED);
    connection.send({ type: "video", on: false });
  },
);
const compare = new Compare(picture, (on) => connection.send({ type: "compare", on }));
// without a count: the server returns the look with its defaults filled in
const sendFile = (look) => connection.send({ type: "look", look }) || showError(NOT_SENT);
const looks = new Looks(store, {
  onChoose: nameAs,
  nameOfLook: () => byId("name").value.trim() || "look",
  onError: showError,
});
const shades = new Shades();
const openShades = async (file) => showError(await shades.open(file, hello.session));
const photos = new Photos({
  look: (file) => openLook(file, sendFile),
  shades: openShades,
  photo(file, { look }) {
    nameAfter(file);
    looks.used(byId("name").value, look);
  },
  portrait: () => looks.draw(),
});
const zoom = new Zoom((view) => (picture.view = view));

const connection = new Connection({
  hello: welcome,
  look({ look, photo, seen }) {
    store.receive(look, photo?.look, seen);
    if (photo) showPhoto(photo);
  },
  figures: showFigures,
  error: ({ text }) => (hello === null ? showVeil(text) : showError(text)),
  bye() {
    looks.pause();
    showVeil(STOPPED);
  },
  lost(stopped) {
    looks.pause();
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
  const [mine, isUnsent] = [store.look, store.isUnsent];
  if (hello === null && message.photo) nameAfter(message.photo); // a page that is reloaded
  hello = message;
  document.title = `makeup-video ${hello.mode}`;
  document.body.dataset.mode = hello.mode;
  byId("mirror-button").hidden = hello.mode === "demo"; // only of use before a camera
  if (hello.mode === "live") showCameras(hello.session, showRecord, showError);
  store.start(hello.look, forgotten ? store.photoLook : (hello.photo?.look ?? null));
  controls ??= new Controls(hello, store, shades, openShades);
  photos.start(hello);
  looks.start(hello);
  if (hello.photo) showPhoto(hello.photo);
  else if (!forgotten) byId("look-words").hidden = true; // of a photo that the server has no more
  if (forgotten || isUnsent) store.replace(mine);
  compare.askAgain();
  if (hello.has_video) {
    pictureKind.then(({ isVideo, why }) => {
      tellWhyJpeg(why);
      if (isVideo) connection.send({ type: "video", on: true });
    });
  }
  showVeil(picture.isShown ? null : WAITING);
}

/** Show the last photo that was read, here or on another page, and its look in words. */
function showPhoto({ name, words }) {
  byId("read-words").textContent = words;
  byId("look-words").hidden = false;
  photos.show(name);
}

/** Show what has been changed since the photo was read. */
function showChanges() {
  if (hello === null || store.photoLook === null || store.look === null) return;
  const changes = changesSince(store.photoLook, store.look, hello.kinds);
  const line = byId("changed-words");
  line.hidden = changes === "";
  line.lastElementChild.textContent = changes;
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
    zoom: (isIn) => zoom.step(isIn),
    unzoom: () => zoom.reset(),
  });
}

store.addEventListener("change", () => {
  showChanges();
  shades.note(store.look, hello.kinds);
});
wireKeep(store, () => hello?.session ?? "", sendFile);
wireRecord(() => hello?.session ?? "", showError);
wireTools();
