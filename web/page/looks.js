// Looks as thumbnails on the portrait: those that the visitor keeps, used last, and the ready ones.

import { el } from "./elements.js";
import { sameLook } from "./look.js";
import { recall, remember } from "./remember.js";
import { moveByKeys, stopAt } from "./row.js";

const MOST_KEPT = 24;
const MOST_RECENT = 4;

/** A button for each look. onChoose(name): called after a look was put on. */
export class Looks {
  #store;
  #onChoose;
  #section = document.getElementById("ready");
  #row = el("div", { className: "thumbs", role: "group", "aria-label": "Looks" });
  #keep = el("button", { type: "button", id: "keep-look", "aria-pressed": "false" });
  #mine; // before a camera: show the looks on the visitor
  #ready = []; // {name, words, look}
  #kept = recall("kept looks", []);
  #recent = recall("recent looks", []);
  #shown = []; // {look, button, image}
  #session = "";
  #round = 0; // counts the portraits, so that thumbnails of an older one are not asked for

  /** nameOfLook(): what the visitor calls the look. onError(text): shows a refusal. */
  constructor(store, { onChoose, nameOfLook, onError }) {
    this.#store = store;
    this.#onChoose = onChoose;
    this.#keep.onclick = () => this.#toggle(nameOfLook());
    this.#mine = el("button", { type: "button", id: "on-me", hidden: true }, "On my face");
    this.#mine.title = "Show the looks on whom the camera sees now";
    this.#mine.onclick = () => this.#showOnMe(onError);
    moveByKeys(this.#row);
    store.addEventListener("change", () => this.#mark());
  }

  /** Called for each hello: makes the row, or completes its thumbnails. */
  async start({ session, mode }) {
    this.#session = session;
    this.#mine.hidden = mode !== "live";
    if (!this.#ready.length) await this.#fetch();
    this.draw();
  }

  /** Note a look that came from a photo or a file; it can be put on again later. */
  used(name, look) {
    const others = this.#recent.filter((one) => !sameLook(one.look, look));
    this.#recent = [{ name, look }, ...others].slice(0, MOST_RECENT);
    remember("recent looks", this.#recent);
    this.#fill();
  }

  /** Ask for all thumbnails, which change with the portrait. */
  draw() {
    for (const one of this.#shown) one.isDrawn = false;
    return this.#draw();
  }

  /** Ask for no more thumbnails; the next hello goes on. */
  pause() {
    this.#round += 1;
  }

  /** Ask for the thumbnails that are missing, one after the other. */
  async #draw() {
    const round = ++this.#round;
    for (const one of this.#shown) {
      if (one.isDrawn) continue;
      one.isDrawn = true;
      await this.#drawOne(one);
      if (round !== this.#round) return;
    }
  }

  async #drawOne({ look, image }) {
    const address = `/look-thumbnail?session=${encodeURIComponent(this.#session)}`;
    try {
      const response = await fetch(address, { method: "POST", body: JSON.stringify(look) });
      if (!response.ok) return;
      if (image.src) URL.revokeObjectURL(image.src);
      image.src = URL.createObjectURL(await response.blob());
      image.hidden = false;
    } catch {
      // the connection is lost, and the next hello draws again
    }
  }

  async #fetch() {
    try {
      const ready = await (await fetch("/looks")).json();
      if (!this.#ready.length) this.#ready = ready;
    } catch {
      return; // the connection is lost, and the next hello tries again
    }
    const head = el("div", { className: "row" }, el("h2", {}, "Looks"), this.#mine, this.#keep);
    this.#section.replaceChildren(head, this.#row);
    this.#section.hidden = false;
    this.#fill();
  }

  /** Make the buttons; those that are there already keep their pictures. */
  #fill() {
    const isNew = ({ look }) => !this.#kept.some((one) => sameLook(one.look, look));
    const all = [...this.#kept, ...this.#recent.filter(isNew), ...this.#ready];
    this.#shown = all.map(
      (one) =>
        this.#shown.find(({ name, look }) => name === one.name && sameLook(look, one.look)) ??
        this.#makeButton(one),
    );
    this.#row.replaceChildren(...this.#shown.map(({ button }) => button));
    if (this.#row.firstElementChild) stopAt(this.#row, this.#row.firstElementChild);
    this.#mark();
    this.#draw();
  }

  #makeButton({ name, words = "", look }) {
    const image = el("img", { alt: "", hidden: true, draggable: false });
    const onclick = () => {
      this.#store.replace(look);
      this.#onChoose(name);
    };
    const text = el("small", {}, name.replaceAll("-", " "));
    const button = el(
      "button",
      { type: "button", onclick, title: words || name, "aria-pressed": "false" },
      el("span", { className: "thumb" }, image),
      text,
    );
    return { name, look, button, image, isDrawn: false };
  }

  get #isKept() {
    return this.#kept.some(({ look }) => sameLook(look, this.#store.look));
  }

  #toggle(name) {
    const { look } = this.#store;
    this.#kept = this.#isKept
      ? this.#kept.filter((one) => !sameLook(one.look, look))
      : [{ name, look }, ...this.#kept].slice(0, MOST_KEPT);
    remember("kept looks", this.#kept);
    this.#fill();
  }

  async #showOnMe(onError) {
    onError("");
    try {
      const address = `/portrait?session=${encodeURIComponent(this.#session)}`;
      const response = await fetch(address, { method: "POST" });
      if (response.ok) this.draw();
      else onError((await response.json()).error);
    } catch {
      onError("The camera’s picture could not be taken: the server does not answer.");
    }
  }

  #mark() {
    if (this.#store.look === null) return;
    for (const { look, button } of this.#shown)
      button.setAttribute("aria-pressed", sameLook(look, this.#store.look));
    this.#keep.textContent = this.#isKept ? "★ Kept" : "☆ Keep look";
    this.#keep.setAttribute("aria-pressed", this.#isKept);
  }
}
