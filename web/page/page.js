// Connects the server's messages with the parts of the page.

import { showCameras } from "./camera.js";
import { changesSince } from "./changes.js";
import { Compare } from "./compare.js";
import { Connection } from "./connection.js";
import { Controls } from "./controls.js";
import { byId } from "./elements.js";
import { openLook, showError, wireKeep } from "./keep.js";
import { listenToKeys } from "./keys.js";
import { LookStore, nameAfter } from "./look.js";
import { Looks } from "./looks.js";
import { Picture } from "./picture.js";
import { Shades } from "./shades.js";
import { showRecord, wireRecord } from "./record.js";
import { hideFigures, showFigures, showVeil, tell, tellWhyJpeg } from "./status.js";
import { Photos } from "./upload.js";
import { choosePictures, FAILED } from "./video.js";
import { Zoom } from "./zoom.js";

const LOST = "The connection was lost. Reconnecting …";
const STOPPED = "makeup-video was stopped. Start it again to see the picture here.";
const NOT_SENT = "the connection is lost. Open the look again when the picture is back.";
const WAITING = "Waiting for the first frame …";

let hello = null;
let controls = null;
let pictureKind = choosePictures(); // holds until a decoder fails

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
// sent without a count `n`, so the server returns the look with its defaults filled in
const sendFile = (look, file) => {
  if (connection.send({ type: "look", look })) store.expect(file.name, look);
  else showError(`${file.name} could not be opened: ${NOT_SENT}`);
};
const looks = new Looks(store, showError);
const shades = new Shades();
const openShades = async (file) => showError(await shades.open(file, hello.session));
const photos = new Photos({
  look: (file) => openLook(file, sendFile),
  shades: openShades,
  photo: ({ name, look }) => looks.used(nameAfter(name), look),
  portrait: () => looks.draw(),
  several: (file) => tell(`Several files were dropped: only ${file.name} is used.`),
});
const zoom = new Zoom((view) => (picture.view = view));

const connection = new Connection({
  hello: welcome,
  look({ look, photo, seen }) {
    store.receive(look, photo, seen);
    if (photo) showPhoto(photo);
  },
  camera: askForCameras,
  seen: ({ seen }) => store.confirm(seen),
  figures: showFigures,
  error({ text }) {
    const file = store.giveUpFile();
    // A page that is refused when it connects is not up. It tries again every few seconds.
    if (!connection.isUp) showVeil(text);
    else showError(file ? `${file}: ${text}` : text);
  },
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
  const isFirst = hello === null;
  if (!isFirst && message.mode !== hello.mode) {
    location.reload(); // another command has taken the port, and most of its page differs
    return;
  }
  const forgotten = !isFirst && message.mode === "demo" && message.session !== hello.session;
  const isMine = forgotten || store.isUnconfirmed; // our own look stays
  const { awaited } = store; // may have been lost with the last connection
  hello = message;
  document.title = `makeup-video ${hello.mode}`;
  document.body.dataset.mode = hello.mode;
  byId("mirror-button").hidden = hello.mode === "demo"; // only useful with a camera
  if (hello.mode === "live") askForCameras();
  const photo = forgotten ? store.photo : (hello.photo ?? null);
  store.start(isMine ? store.look : hello.look, photo);
  if (isFirst) nameFirst();
  controls ??= new Controls(hello, store, shades, openShades);
  photos.start(hello);
  looks.start(hello);
  if (!forgotten) {
    if (hello.photo) showPhoto(hello.photo);
    else byId("look-words").hidden = true; // the server no longer has the photo
  }
  if (isMine) store.sendAgain();
  if (awaited) sendFile(awaited.look, { name: awaited.file });
  compare.askAgain();
  if (hello.has_video) {
    pictureKind.then(({ isVideo, why }) => {
      tellWhyJpeg(why);
      if (isVideo) connection.send({ type: "video", on: true });
    });
  }
  showVeil(picture.isShown ? null : WAITING);
}

function askForCameras() {
  showCameras(hello.session, showRecord, showError);
}

/** Name the look of a reloaded page: by the name under which it is kept, or after its photo. */
function nameFirst() {
  const name = looks.keptName ?? (hello.photo && nameAfter(hello.photo.name));
  if (name) store.name = name;
}

/** Show the last photo that was read, here or on another page, and its look in words. */
function showPhoto({ name, words }) {
  byId("read-words").textContent = words;
  byId("look-words").hidden = false;
  photos.show(name);
}

/** Show what has been changed since the photo was read. */
function showChanges() {
  if (store.photoLook === null) return;
  const changes = changesSince(store.photoLook, store.look, hello.kinds);
  const line = byId("changed-words");
  line.hidden = changes === "";
  line.lastElementChild.textContent = changes;
}

/** Make a button switch something on and off; returns the function that switches. */
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
  const full = () => {
    if (document.fullscreenElement) document.exitFullscreen();
    else byId("viewer").requestFullscreen?.(); // iPhones lack this method
  };
  byId("help-button").onclick = help;
  byId("full-button").onclick = full;
  byId("full-button").hidden = !document.fullscreenEnabled;
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
  if (store.look === null) return; // only the name changed, before the first look came
  showChanges();
  shades.note(store.look, hello.kinds);
});
wireKeep(store, () => hello?.session ?? "", sendFile);
wireRecord(() => hello?.session ?? "", showError);
wireTools();
