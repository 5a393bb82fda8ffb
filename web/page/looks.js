// Looks as thumbnails on the portrait: kept looks, looks from the last photos, and ready looks.

import { addressOf, ask, NO_ANSWER } from "./ask.js";
import { byId, el, oneAtATime } from "./elements.js";
import { isLook, sameLook } from "./look.js";
import { isObject, isText, listenToOtherPages, listOf, recall, revise } from "./remember.js";
import { moveByKeys, putButtons, stopAt } from "./row.js";

const KEPT = "kept looks";
const RECENT = "recent looks";
const MOST_KEPT = 24;
const MOST_RECENT = 4;
const RETRY_MS = 5000;
const FULL =
  `${MOST_KEPT} looks are kept, the most that there may be: ` +
  "choose one of them and press “Keep look”, which removes it.";

const namedLooks = (value) =>
  listOf(value, (one) => isObject(one) && isText(one.name) && isLook(one.look));

/** The row with a button for each look. */
export class Looks {
  #store;
  #onError;
  #section = byId("ready");
  #row = el("div", { className: "thumbs", role: "group", "aria-label": "Looks" });
  #star = el("span", { "aria-hidden": "true" });
  #keep;
  #mine; // with a camera: the button that shows the looks on the visitor
  #ready = []; // {name, words, look}
  #kept = recall(KEPT, namedLooks);
  #recent = recall(RECENT, namedLooks);
  #shown = []; // {name, look, button, image, isDrawn}
  #session = "";
  #retrying = 0;
  #round = 0; // changes when drawing starts over or pauses, which ends a drawing in progress

  /** onError(text): shows a refusal; "" clears it. */
  constructor(store, onError) {
    this.#store = store;
    this.#onError = onError;
    this.#keep = el("button", { type: "button", id: "keep-look" }, this.#star, "Keep look");
    this.#keep.onclick = () => this.#toggle();
    this.#mine = el("button", { type: "button", id: "on-me", hidden: true }, "On my face");
    this.#mine.title = "Show the looks on whom the camera sees now";
    oneAtATime(this.#mine, () => this.#showOnMe());
    moveByKeys(this.#row);
    store.addEventListener("change", () => this.#mark());
    listenToOtherPages([KEPT, RECENT], () => {
      this.#kept = recall(KEPT, namedLooks);
      this.#recent = recall(RECENT, namedLooks);
      this.#fill();
    });
  }

  /** The name under which the current look is kept; undefined if it is not kept. */
  get keptName() {
    return this.#kept.find(({ look }) => sameLook(look, this.#store.look))?.name;
  }

  /** Make the row, or draw its thumbnails again. Called for each hello. */
  start({ session, mode }) {
    this.#session = session;
    this.#mine.hidden = mode !== "live";
    return this.#load();
  }

  async #load() {
    if (!this.#ready.length) await this.#fetch();
    clearTimeout(this.#retrying);
    if (!this.#ready.length) this.#retrying = setTimeout(() => this.#load(), RETRY_MS);
    this.draw();
  }

  /** Note a look that came from a photo, so that it can be put on again later. */
  used(name, look) {
    this.#recent = revise(RECENT, namedLooks, (recent) =>
      [{ name, look }, ...without(recent, look)].slice(0, MOST_RECENT),
    );
    this.#fill();
  }

  /** Ask for all thumbnails anew, since they change with the portrait. */
  draw() {
    for (const one of this.#shown) one.isDrawn = false;
    return this.#draw();
  }

  /** Stop asking for thumbnails until the next hello. */
  pause() {
    this.#round += 1;
  }

  /** Ask for the missing thumbnails, one after the other. */
  async #draw() {
    const round = ++this.#round;
    for (const one of this.#shown) {
      if (one.isDrawn) continue;
      one.isDrawn = true;
      await this.#drawOne(one);
      if (round !== this.#round) return;
    }
  }

  async #drawOne(one) {
    const address = addressOf("/look-thumbnail", this.#session);
    try {
      const response = await ask(address, { method: "POST", body: JSON.stringify(one.look) });
      if (!response.ok) {
        one.isDrawn = response.status === 400; // a refused look is not asked for again
        return;
      }
      const jpeg = await response.blob();
      if (!this.#shown.includes(one)) return;
      forget(one.image);
      one.image.src = URL.createObjectURL(jpeg);
      one.image.hidden = false;
    } catch {
      one.isDrawn = false; // the connection is lost, and the next hello draws again
    }
  }

  async #fetch() {
    try {
      const response = await ask("/looks");
      const ready = await response.json();
      if (!response.ok || this.#ready.length) return;
      this.#ready = ready;
    } catch {
      return; // the connection is lost
    }
    const head = el("div", { className: "row" }, el("h2", {}, "Looks"), this.#mine, this.#keep);
    this.#section.replaceChildren(head, this.#row);
    this.#section.hidden = false;
    this.#fill();
  }

  /** Make the buttons; buttons that exist already keep their pictures. */
  #fill() {
    const isNew = ({ look }) => !this.#kept.some((one) => sameLook(one.look, look));
    const isKept = ({ name, look }) =>
      this.#kept.some((one) => one.name === name && sameLook(one.look, look));
    const ready = this.#ready.filter((one) => !isKept(one));
    const all = [...this.#kept, ...this.#recent.filter(isNew), ...ready];
    const before = this.#shown;
    this.#shown = all.map(
      (one) =>
        before.find(({ name, look }) => name === one.name && sameLook(look, one.look)) ??
        this.#makeButton(one),
    );
    for (const one of before) if (!this.#shown.includes(one)) forget(one.image);
    const buttons = this.#shown.map(({ button }) => button);
    putButtons(this.#row, buttons);
    const focused = buttons.find((button) => button === document.activeElement);
    if (buttons.length) stopAt(this.#row, focused ?? buttons[0]);
    this.#mark();
    this.#draw();
  }

  #makeButton({ name, words = "", look }) {
    const image = el("img", { alt: "", hidden: true, draggable: false });
    const onclick = () => this.#store.replace(look, name);
    const text = el("small", {}, name.replaceAll("-", " "));
    const button = el(
      "button",
      { type: "button", onclick, title: words || name, "aria-pressed": "false" },
      el("span", { className: "thumb" }, image),
      text,
    );
    return { name, look, button, image, isDrawn: false };
  }

  get #name() {
    return this.#store.name.trim() || "look";
  }

  /** Keep the current look under its name, or stop keeping it. */
  #toggle() {
    const { look } = this.#store;
    const isKept = this.keptName === this.#name;
    const named = { name: this.#name, look };
    let isFull = false;
    this.#onError("");
    this.#kept = revise(KEPT, namedLooks, (kept) => {
      const others = without(kept, look);
      isFull = !isKept && others.length >= MOST_KEPT;
      if (isFull) return kept;
      return isKept ? others : [named, ...others];
    });
    if (isFull) this.#onError(FULL);
    this.#fill();
  }

  async #showOnMe() {
    this.#onError("");
    try {
      const response = await ask(addressOf("/portrait", this.#session), { method: "POST" });
      if (response.ok) this.draw();
      else this.#onError((await response.json()).error);
    } catch {
      this.#onError(`The camera’s picture could not be taken: ${NO_ANSWER}`);
    }
  }

  #mark() {
    if (this.#store.look === null) return;
    for (const { look, button } of this.#shown)
      button.setAttribute("aria-pressed", sameLook(look, this.#store.look));
    const isKept = this.keptName === this.#name;
    this.#star.textContent = isKept ? "★" : "☆";
    this.#keep.setAttribute("aria-pressed", isKept);
  }
}

const without = (looks, look) => looks.filter((one) => !sameLook(one.look, look));

/** Free the picture of a thumbnail. */
function forget(image) {
  if (image.src) URL.revokeObjectURL(image.src);
}
