// The layers of a kind that may have several: a swatch for each, and buttons to add and remove one.

import { el, fineCanvas } from "./elements.js";
import { BOTH, hasRoom, inWords, wholeShape } from "./layers.js";
import { moveByKeys, putButtons, stopAt } from "./row.js";
import { drawSwatch } from "./swatch.js";

/** on: {choose(at), add(), remove()}, called when the visitor presses a button. */
export class LayerRow {
  #kind;
  #on;
  #layers = [];
  #swatches = []; // {button, canvas, text} of each layer
  #add;
  #remove;
  #row;

  constructor(kind, on) {
    this.#kind = kind;
    this.#on = on;
    this.#add = el(
      "button",
      { type: "button", className: "add", onclick: () => this.#added(), title: "Add a layer" },
      el("b", { "aria-hidden": "true" }, "+"),
      el("span", { className: "hidden" }, "Add a layer"),
    );
    this.#remove = el(
      "button",
      { type: "button", className: "remove", onclick: () => this.#removed() },
      "Remove layer",
    );
    this.#row = el("div", { className: "swatches", role: "group", "aria-label": "Layers" });
    moveByKeys(this.#row);
    this.element = el("div", { className: "layers" }, this.#row, this.#remove);
  }

  /** Show the layers.  at: the index of the chosen one. */
  show(layers, at) {
    this.#layers = layers;
    while (this.#swatches.length < layers.length)
      this.#swatches.push(this.#makeSwatch(this.#swatches.length));
    this.#swatches.length = layers.length;
    const buttons = this.#swatches.map(({ button }) => button);
    putButtons(this.#row, [...buttons, this.#add]);
    layers.forEach((layer, here) => this.#name(layer, here, here === at));
    this.#add.hidden = !hasRoom(this.#kind, layers, layers[at]);
    this.#remove.hidden = layers.length < 2;
    stopAt(this.#row, buttons[at]);
  }

  draw() {
    this.#layers.forEach(({ product }, at) =>
      drawSwatch(this.#swatches[at].canvas, this.#kind.swatch, [product]),
    );
  }

  #name(layer, at, isChosen) {
    const { button, text } = this.#swatches[at];
    const { slot, eye = BOTH } = wholeShape(this.#kind, layer.shape);
    text.textContent = slot ? inWords(slot) : at + 1;
    if (eye !== BOTH) text.textContent += `, ${eye} eye`;
    button.setAttribute("aria-label", `Layer ${at + 1}: ${text.textContent}`);
    button.setAttribute("aria-pressed", isChosen);
  }

  #makeSwatch(at) {
    const canvas = fineCanvas(48, 32);
    const text = el("small");
    const onclick = () => this.#on.choose(at);
    return { canvas, text, button: el("button", { type: "button", onclick }, canvas, text) };
  }

  /** Once no more layers fit, the button vanishes, so the focus moves to the last layer. */
  #added() {
    this.#on.add();
    if (this.#add.hidden) this.#swatches.at(-1).button.focus();
  }

  /** Once only one layer is left, the button vanishes, so the focus moves to this layer. */
  #removed() {
    this.#on.remove();
    if (this.#remove.hidden) this.#swatches[0].button.focus();
  }
}
