// The ready looks: a row of thumbnails on the portrait that is painted, or on ours before a camera.

import { el } from "./elements.js";
import { sameLook } from "./look.js";
import { moveByKeys, stopAt } from "./row.js";

/** A button for each ready look. onChoose(name): called after a look was put on. */
export class ReadyLooks {
  #store;
  #onChoose;
  #section = document.getElementById("ready");
  #row = el("div", { className: "thumbs", role: "group", "aria-label": "Ready looks" });
  #looks = []; // {name, look, button, image}
  #session = "";
  #round = 0; // counts the portraits, so that thumbnails of an older one are not asked for

  constructor(store, onChoose) {
    this.#store = store;
    this.#onChoose = onChoose;
    moveByKeys(this.#row);
    store.addEventListener("change", () => this.#mark());
  }

  /** Called for each hello: makes the row, or completes its thumbnails. */
  async start({ session }) {
    this.#session = session;
    if (!this.#looks.length) await this.#make();
    this.draw();
  }

  /** Ask for the thumbnails, which change with the portrait, one after the other. */
  async draw() {
    const round = ++this.#round;
    for (const { name, image } of this.#looks) {
      const loaded = new Promise((resolve) => (image.onload = image.onerror = resolve));
      const session = encodeURIComponent(this.#session);
      image.src = `/look-thumbnail/${encodeURIComponent(name)}?session=${session}&portrait=${round}`;
      image.hidden = (await loaded).type === "error"; // rather than the browser's broken picture
      if (round !== this.#round) return;
    }
  }

  /** Ask for no more thumbnails; the next hello goes on. */
  pause() {
    this.#round += 1;
  }

  async #make() {
    let answer;
    try {
      answer = await (await fetch("/looks")).json();
    } catch {
      return; // the connection is lost, and the next hello tries again
    }
    if (this.#looks.length || !answer.length) return;
    this.#looks = answer.map((ready) => this.#makeButton(ready));
    this.#row.replaceChildren(...this.#looks.map(({ button }) => button));
    stopAt(this.#row, this.#row.firstElementChild);
    this.#section.replaceChildren(el("h2", {}, "Ready looks"), this.#row);
    this.#section.hidden = false;
    this.#mark();
  }

  #makeButton({ name, words, look }) {
    const image = el("img", { alt: "", hidden: true, draggable: false });
    const onclick = () => {
      this.#store.replace(look);
      this.#onChoose(name);
    };
    const button = el(
      "button",
      { type: "button", onclick, title: words, "aria-pressed": "false" },
      el("span", { className: "thumb" }, image),
      el("small", {}, name.replaceAll("-", " ")),
    );
    return { name, look, button, image };
  }

  #mark() {
    for (const { look, button } of this.#looks)
      button.setAttribute("aria-pressed", sameLook(look, this.#store.look));
  }
}
