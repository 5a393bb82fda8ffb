// Photos that are chosen, dropped or pasted: uploads them, and shows thumbnails or refusals.

import { addressOf, isReadable, NO_ANSWER, unreadable } from "./ask.js";
import { byId, el } from "./elements.js";
import { chooseFace } from "./faces.js";
import { TYPED } from "./keys.js";
import { tellInFullScreen } from "./status.js";

const SLOTS = {
  photo: {
    title: "Makeup of",
    empty: "Choose a photo",
    hint: "or drop or paste one anywhere",
    reading: "Reading the makeup …",
    aim: "Use the makeup of this photo",
  },
  portrait: {
    title: "Painted on",
    empty: "Another face",
    hint: "",
    reading: "Looking for the face …",
    aim: "Paint on this face",
  },
};
const SHADES = "Show these shades";
const WHOLE = {
  "application/json": "Apply this look",
  "text/csv": SHADES,
  "application/vnd.ms-excel": SHADES, // CSV on Windows
};
// enough for the server's 60 s for an upload, and for reading it; a lost peer may never answer
const PATIENCE_MS = 150_000;
const PHOTOS = "image/*,.heic,.heif,.avif"; // not every browser knows these as pictures
const NO_FACE = "No face was chosen: the look stays as it is.";
const notSent = (file) => `${nameOf(file)} could not be sent: ${NO_ANSWER}`;
const nameOf = (file) => file.name || "the pasted photo";
let loads = 0; // counts thumbnails, so that the browser asks for each and uses no older one

/** A slot for one photo: a button to choose it, a drop target, its thumbnail and state. */
class Slot {
  file = null; // the last photo that was accepted
  #kind;
  #upload;
  // not draggable: a dragged thumbnail would count as a new photo
  #thumb = el("img", { alt: "", hidden: true, draggable: false });
  #hint;
  #text;
  #error = el("p", { className: "error", role: "alert" });
  #request = null;

  /** upload(kind, file, request): resolves to null, or to the reason for a refusal. */
  constructor(kind, upload) {
    const { title, empty, hint } = SLOTS[kind];
    this.#kind = kind;
    this.#upload = upload;
    this.#hint = el("small", {}, hint);
    this.#text = el("b", {}, empty);
    const input = el("input", {
      type: "file",
      accept: PHOTOS,
      "aria-label": `${title}: choose a photo`,
    });
    input.addEventListener("change", () => {
      if (input.files.length) this.take(input.files[0]);
      input.value = ""; // so that the same file fires "change" again
    });
    this.#thumb.addEventListener("error", () => (this.#thumb.hidden = true));
    this.element = el(
      "div",
      { className: "slot", id: `${kind}-slot` },
      el(
        "label",
        {},
        input,
        el("span", { className: "thumb" }, this.#thumb),
        el("span", { className: "words" }, el("small", {}, title), this.#text, this.#hint),
      ),
      this.#error,
    );
  }

  async take(file) {
    this.#request?.abort(); // the newest photo wins
    const request = (this.#request = new AbortController());
    this.#state("reading", "");
    const refused = await this.#upload(this.#kind, file, request);
    if (request !== this.#request) return;
    this.#request = null;
    this.#state("", refused ?? "");
    if (refused === null) this.#accept(file);
  }

  #state(className, error) {
    this.element.classList.toggle("reading", className === "reading");
    this.element.setAttribute("aria-busy", className === "reading");
    this.#hint.textContent =
      className === "reading" ? SLOTS[this.#kind].reading : SLOTS[this.#kind].hint;
    this.#error.textContent = error;
    tellInFullScreen(error);
  }

  #accept(file) {
    this.file = file;
    this.#text.textContent = nameOf(file);
  }

  /** Show the server's thumbnail of the photo, and its name where it is known. */
  show(session, name = "") {
    if (name) this.#text.textContent = name;
    this.#thumb.src = addressOf(`/${this.#kind}-thumbnail`, session, { load: ++loads });
    this.#thumb.hidden = false;
  }
}

/**
 * on: {look(file): a look file was given; shades(file): a catalogue was given; photo({name, look}):
 * a photo was read; portrait(): a portrait was taken; several(file): several files were dropped, of
 * which this one is used}.
 */
export class Photos {
  #hello = null;
  #slots = {};
  #on;
  #drop = byId("drop");
  #depth = 0; // dragenter and dragleave fire for every nested element

  constructor(on) {
    this.#on = on;
    document.addEventListener("dragenter", (event) => this.#enter(event));
    document.addEventListener("dragover", (event) => this.#over(event));
    document.addEventListener("dragleave", () => this.#leave(this.#depth - 1));
    document.addEventListener("drop", (event) => this.#dropped(event));
    document.addEventListener("paste", (event) => this.#pasted(event));
  }

  /** Called for each hello; keeps the slots and their photos. */
  start(hello) {
    const isNew = this.#hello !== null && this.#hello.session !== hello.session;
    this.#hello = hello;
    for (const kind of hello.mode === "demo" ? ["photo", "portrait"] : ["photo"]) {
      if (this.#slots[kind]) continue; // appending the slot again would take the focus from it
      this.#slots[kind] = new Slot(kind, (...photo) => this.#upload(...photo));
      byId("photos").append(this.#slots[kind].element);
    }
    this.#slots.portrait?.show(hello.session);
    const portrait = this.#slots.portrait?.file;
    // a new session does not have our portrait
    if (isNew && portrait) this.#slots.portrait.take(portrait);
  }

  /** Show the photo that was read last, here or on another page. */
  show(name) {
    this.#slots.photo.show(this.#hello.session, name);
  }

  /** Upload a file; resolves to null, or to the reason for a refusal. request: AbortController. */
  async #upload(kind, file, request, face = "") {
    const limit = this.#hello.photo_bytes_limit;
    if (file.size > limit) {
      const [size, most] = [Math.ceil(file.size / 1e6), Math.floor(limit / 1e6)];
      return `${nameOf(file)} has ${size} MB; a photo may have at most ${most} MB.`;
    }
    if (!(await isReadable(file))) return unreadable(nameOf(file));
    // AbortSignal.any would do the same, but iOS 16 lacks it
    const late = setTimeout(() => request.abort(), PATIENCE_MS);
    try {
      const address = addressOf(`/${kind}`, this.#hello.session, { face });
      const headers = { "X-File-Name": encodeURIComponent(file.name) };
      const { signal } = request;
      const response = await fetch(address, { method: "POST", body: file, headers, signal });
      const answer = await response.json();
      clearTimeout(late); // the visitor may take longer to choose a face
      if (answer.faces) {
        const chosen = await chooseFace(answer, signal);
        return chosen === null ? NO_FACE : this.#upload(kind, file, request, chosen);
      }
      if (!response.ok) return answer.error ?? notSent(file);
      if (kind === "portrait") this.#slots.portrait.show(this.#hello.session);
      this.#on[kind](answer);
      return null;
    } catch {
      return notSent(file);
    }
  }

  #take(file, kind = "photo") {
    if (this.#hello === null) return; // not connected yet
    if (file.type === "application/json" || /\.json$/i.test(file.name)) this.#on.look(file);
    else if (file.type === "text/csv" || /\.csv$/i.test(file.name)) this.#on.shades(file);
    else this.#slots[kind].take(file);
  }

  #isFile(event) {
    return event.dataTransfer?.types.includes("Files");
  }

  #enter(event) {
    if (!this.#isFile(event)) return;
    event.preventDefault();
    if (this.#depth === 0) this.#aim(event);
    this.#depth += 1;
  }

  /** Show what a drop would do. In the demo a photo may be dropped on either of two targets. */
  #aim(event) {
    const whole = WHOLE[event.dataTransfer.items?.[0]?.type];
    const aims = whole
      ? [["photo", whole]]
      : Object.keys(this.#slots).map((kind) => [kind, SLOTS[kind].aim]);
    this.#drop.replaceChildren(
      ...aims.map(([kind, aim]) => {
        const target = el("div", { className: "target" }, el("span", {}, aim));
        target.dataset.kind = kind;
        return target;
      }),
    );
    this.#drop.hidden = false;
  }

  #over(event) {
    if (!this.#isFile(event)) return;
    event.preventDefault();
    event.dataTransfer.dropEffect = "copy";
    const over = event.target.closest?.(".target");
    for (const target of this.#drop.children) target.classList.toggle("over", target === over);
  }

  #leave(depth) {
    this.#depth = Math.max(0, depth);
    if (this.#depth === 0) this.#drop.hidden = true;
  }

  #dropped(event) {
    if (!this.#isFile(event)) return;
    event.preventDefault();
    this.#leave(0);
    const target = event.target.closest?.(".target")?.dataset.kind;
    const slot = event.target.closest?.(".slot")?.id.replace("-slot", "");
    const { files } = event.dataTransfer;
    if (files.length) this.#take(files[0], target ?? slot);
    if (files.length > 1) this.#on.several(files[0]);
  }

  #pasted(event) {
    const file = [...(event.clipboardData?.files ?? [])].find(({ type }) =>
      type.startsWith("image/"),
    );
    if (!file) return;
    // text from an office program comes with a picture of the text
    const isTyped = event.target.closest?.(TYPED) && event.clipboardData.getData("text/plain");
    if (isTyped) return;
    event.preventDefault();
    this.#take(file);
  }
}
