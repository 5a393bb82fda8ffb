// What people take home, and bring: the look as a file, the picture as PNG, undo and redo.

import { lookFile } from "./look.js";

const SAID_MS = 20_000;
const said = document.getElementById("said");
const name = document.getElementById("name");
let clearing = 0;
const button = (id) => document.getElementById(id);

/** One line where the files are: what went wrong; "" clears it, as time does. */
export function say(text) {
  said.textContent = text;
  clearTimeout(clearing);
  clearing = setTimeout(() => (said.textContent = ""), SAID_MS);
}

/** The look's name is what it was read from, until somebody names it. */
export function nameAfter(file) {
  const stem = file.name.replace(/\.[^.]*$/, "");
  if (stem) name.value = stem;
}

function download(blob, ending) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = `${name.value.trim().replace(/[\\/:*?"<>|]/g, "_") || "look"}.${ending}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

async function downloadPicture(session) {
  say("");
  try {
    const response = await fetch(`/picture.png?session=${encodeURIComponent(session)}`);
    if (response.ok) download(await response.blob(), "png");
    else say((await response.json()).error);
  } catch {
    say("There is no picture: the server does not answer.");
  }
}

/** `send` what is in a look file; the server tells what it means, or what is wrong with it. */
export async function openLook(file, send) {
  say("");
  try {
    const look = JSON.parse((await file.text()).replace(/^\uFEFF/, ""));
    nameAfter(file);
    send(look);
  } catch {
    say(`${file.name} is no look: a look file is JSON, as “Save look” writes it.`);
  }
}

export function wireKeep(store, session, send) {
  button("undo").onclick = () => store.undo();
  button("redo").onclick = () => store.redo();
  button("reset").onclick = () => store.replace(store.photoLook);
  button("save-look").onclick = () =>
    download(new Blob([lookFile(store.look)], { type: "application/json" }), "json");
  button("save-picture").onclick = () => downloadPicture(session());
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
