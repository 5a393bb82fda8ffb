// Saving and opening: the look as a file, the picture as PNG, undo and redo.

import { lookFile } from "./look.js";

const ERROR_MS = 20_000;
const error = document.getElementById("error");
const name = document.getElementById("name");
let clearing = 0;
const button = (id) => document.getElementById(id);

/** Show an error near the buttons for files, for some time; "" clears it. */
export function showError(text) {
  error.textContent = text;
  if (text) error.scrollIntoView({ block: "nearest" }); // on a phone it is far below the picture
  clearTimeout(clearing);
  clearing = setTimeout(() => (error.textContent = ""), ERROR_MS);
}

/** Name the look, and with it the files that are saved. */
export function nameAs(text) {
  name.value = text;
}

/** Name the look after the file that it was read from. */
export function nameAfter(file) {
  const stem = file.name.replace(/\.[^.]*$/, "");
  if (stem) nameAs(stem);
}

function download(blob, ending) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = `${name.value.trim().replace(/[\\/:*?"<>|]/g, "_") || "look"}.${ending}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

async function downloadPicture(session, both = "") {
  showError("");
  try {
    const response = await fetch(`/picture.png?session=${encodeURIComponent(session)}${both}`);
    if (response.ok) download(await response.blob(), "png");
    else showError((await response.json()).error);
  } catch {
    showError("The picture could not be saved: the server does not answer.");
  }
}

/** Read a look file and `send` it; the server returns the complete look, or an error. */
export async function openLook(file, send) {
  showError("");
  try {
    const look = JSON.parse((await file.text()).replace(/^\uFEFF/, ""));
    nameAfter(file);
    send(look);
  } catch {
    showError(`${file.name} is not a look file: choose a JSON file made by “Save look”.`);
  }
}

/** Connect the buttons for files, undo and redo. */
export function wireKeep(store, session, send) {
  button("undo").onclick = () => store.undo();
  button("redo").onclick = () => store.redo();
  button("reset").onclick = () => store.replace(store.photoLook);
  button("save-look").onclick = () =>
    download(new Blob([lookFile(store.look)], { type: "application/json" }), "json");
  button("save-picture").onclick = () => downloadPicture(session());
  button("save-both").onclick = () => downloadPicture(session(), "&both");
  const input = document.querySelector("#open-look input");
  input.addEventListener("change", () => {
    if (input.files.length) openLook(input.files[0], send);
    input.value = "";
  });
  store.addEventListener("change", () => {
    button("undo").disabled = !store.canUndo;
    button("redo").disabled = !store.canRedo;
    button("reset").disabled = store.isPhotoLook;
  });
}
