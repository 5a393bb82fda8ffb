// Saves and opens looks as files, saves the picture as PNG, and connects undo and redo.

import { addressOf, isReadable, NO_ANSWER, unreadable } from "./ask.js";
import { byId, oneAtATime } from "./elements.js";
import { lookFile } from "./look.js";
import { tellInFullScreen } from "./status.js";

const ERROR_MS = 20_000;
const PICTURE_MS = 120_000; // until the answer begins: a PNG waits for the PNGs of other pages
const MOST_BYTES = 64_000; // of a look file: a page that sends more than 65,536 is cut off
const error = byId("error");
const name = byId("name");
let clearing = 0;

/** Show an error near the buttons for files, for some time; "" clears it. */
export function showError(text) {
  error.textContent = text;
  if (text) error.scrollIntoView({ block: "nearest" }); // on a phone it is far below the picture
  clearTimeout(clearing);
  clearing = setTimeout(() => (error.textContent = ""), ERROR_MS);
  tellInFullScreen(text);
}

function download(blob, ending) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = `${name.value.trim().replace(/[\\/:*?"<>|]/g, "_") || "look"}.${ending}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

/** Download the picture. more: {both: ""} for before and after side by side. */
async function downloadPicture(session, more = {}) {
  showError("");
  try {
    const request = new AbortController();
    const late = setTimeout(() => request.abort(), PICTURE_MS);
    const address = addressOf("/picture.png", session, more);
    const response = await fetch(address, { signal: request.signal });
    clearTimeout(late); // a large picture may take longer on a slow network
    if (response.ok) download(await response.blob(), "png");
    else showError((await response.json()).error);
  } catch {
    showError(`The picture could not be saved: ${NO_ANSWER}`);
  }
}

/** Read a look file and call send(look, file). The server returns the complete look or an error. */
export async function openLook(file, send) {
  showError("");
  const choose = "choose a JSON file made by “Save look”.";
  if (!(await isReadable(file))) return showError(unreadable(file.name));
  if (file.size > MOST_BYTES) {
    const [size, most] = [Math.ceil(file.size / 1000), MOST_BYTES / 1000];
    return showError(`${file.name} has ${size} kB, a look file ${most} kB at most: ${choose}`);
  }
  try {
    const look = JSON.parse((await file.text()).replace(/^\uFEFF/, ""));
    send(look, file);
  } catch {
    showError(`${file.name} is not a look file: ${choose}`);
  }
}

/** Connect the buttons for files, undo and redo. */
export function wireKeep(store, session, send) {
  byId("undo").onclick = () => store.undo();
  byId("redo").onclick = () => store.redo();
  byId("reset").onclick = () => store.backToPhoto();
  byId("save-look").onclick = () => {
    if (store.look === null) return; // not connected yet
    download(new Blob([lookFile(store.look)], { type: "application/json" }), "json");
  };
  oneAtATime(byId("save-picture"), () => downloadPicture(session()));
  oneAtATime(byId("save-both"), () => downloadPicture(session(), { both: "" }));
  const input = document.querySelector("#open-look input");
  input.addEventListener("change", () => {
    if (input.files.length) openLook(input.files[0], send);
    input.value = "";
  });
  name.addEventListener("input", () => (store.name = name.value));
  // does not use `disabled`, which would take the focus from the button
  const enable = (id, can) => byId(id).setAttribute("aria-disabled", !can);
  store.addEventListener("change", () => {
    if (name.value !== store.name) name.value = store.name;
    enable("undo", store.canUndo);
    enable("redo", store.canRedo);
    enable("reset", !store.isPhotoLook);
  });
}
