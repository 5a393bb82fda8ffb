// One kind of makeup, such as lipstick: its tab, and its panel of controls.

import { colourField, readHex } from "./colour.js";
import { el, fineCanvas, oncePerFrame } from "./elements.js";
import { LayerRow } from "./layer_row.js";
import {
  anotherLayer,
  finishOf,
  firstLayer,
  layersOf,
  putLayers,
  wholeShape,
} from "./layers.js";
import { shapeControls } from "./shape.js";
import { ShadeRow } from "./shades.js";
import { portion, slider } from "./slider.js";
import { drawSwatch } from "./swatch.js";

const SHINE = ["gloss", "gloss_roughness", "reflection"];

/** The tab of a kind, and the panel whose controls change the chosen layer. */
export class KindControls {
  #store;
  #kind;
  #hello;
  #layers; // the layers worn now, or before the kind was taken off, or at first
  #at = 0; // the chosen layer
  #isWorn = false;
  #parts = []; // for each control, the function set(layer) that shows the layer
  #finishes = []; // [canvas, settings]
  #shades;
  #tabSwatch = fineCanvas(88, 30);
  #tabText = el("small");
  #switch = el("input", { type: "checkbox", role: "switch" }); // whether the kind is worn
  #body; // the controls below the switch
  #row = null; // the row of layers, for a kind that may have several
  #drawn = ""; // the products and the layer that the panel's swatches show, as text
  #draw = oncePerFrame(() => this.#drawSwatches());

  /** kind: one of hello.kinds.  shades: for all kinds.  openShades(file): reads a catalogue. */
  constructor(kind, hello, store, shades, openShades) {
    this.#kind = kind;
    this.#hello = hello;
    this.#store = store;
    this.#layers = [firstLayer(kind, hello.finishes)];
    if (kind.most > 1) {
      this.#row = new LayerRow(kind, {
        choose: (at) => this.#choose(at),
        add: () => this.#add(),
        remove: () => this.#remove(),
      });
    }
    this.#shades = new ShadeRow(
      kind,
      shades,
      (hex) => this.#edit((_, layer) => Object.assign(layer.product, readHex(hex))),
      openShades,
    );
    this.#parts.push((layer) => this.#shades.set(layer.product));
    this.panel = this.#makePanel();
    this.tab = this.#makeTab();
  }

  /** Show the look; called after every change. */
  show(look) {
    const layers = layersOf(look, this.#kind);
    this.#isWorn = layers.length > 0;
    if (this.#isWorn) this.#layers = layers;
    this.#at = Math.min(this.#at, this.#layers.length - 1);
    this.#switch.checked = this.#isWorn;
    this.#body.classList.toggle("off", !this.#isWorn); // any change puts the kind on again
    for (const set of this.#parts) set(this.#layers[this.#at]);
    this.#row?.show(this.#layers, this.#at);
    this.#tabText.textContent = this.#words();
    this.tab.classList.toggle("bare", !this.#isWorn);
    this.#draw();
  }

  /** Show the panel, or hide it. */
  select(isChosen) {
    this.tab.setAttribute("aria-selected", isChosen);
    this.panel.hidden = !isChosen;
    this.#shades.draw();
    this.#draw();
  }

  #words() {
    if (!this.#isWorn) return "bare";
    if (this.#layers.length > 1) return `${this.#layers.length} layers`;
    return finishOf(this.#layers[0].product, this.#hello.finishes, this.#kind.part) ?? "custom";
  }

  /** change(layers, layer): alters copies of the layers; layer is the chosen one of them. */
  #edit(change) {
    this.#store.edit((look) => this.#change(look, change));
  }

  #change(look, change) {
    const worn = layersOf(look, this.#kind);
    const layers = worn.length ? worn : structuredClone(this.#layers);
    change(layers, layers[this.#at]);
    putLayers(look, this.#kind, layers, this.#hello.kinds);
  }

  #choose(at) {
    this.#at = at;
    this.show(this.#store.look);
  }

  #add() {
    const add = (layers, layer) => layers.push(anotherLayer(this.#kind, layers, layer));
    this.#store.step((look) => this.#change(look, add));
    this.#choose(this.#layers.length - 1);
  }

  #remove() {
    const at = this.#at;
    this.#at = Math.max(0, at - 1);
    this.#store.step((look) => this.#change(look, (layers) => layers.splice(at, 1)));
  }

  #wear(isWorn) {
    const layers = isWorn ? structuredClone(this.#layers) : [];
    this.#store.step((look) => putLayers(look, this.#kind, layers, this.#hello.kinds));
  }

  #makeTab() {
    const { part, title } = this.#kind;
    return el(
      "button",
      { type: "button", role: "tab", id: `${part}-tab`, "aria-controls": this.panel.id },
      this.#tabSwatch,
      el("b", {}, title),
      this.#tabText,
    );
  }

  #makePanel() {
    const { part, product } = this.#kind;
    this.#switch.addEventListener("change", () => this.#wear(this.#switch.checked));
    this.#body = this.#makeBody();
    const colour = this.#makeColour();
    return el(
      "div",
      { role: "tabpanel", id: `${part}-panel`, "aria-labelledby": `${part}-tab` },
      el(
        "div",
        { className: "row first" },
        el("label", { className: "switch" }, this.#switch, product),
        colour.element,
      ),
      colour.error,
      this.#shades.element,
      this.#body,
    );
  }

  #makeBody() {
    const { parameters } = this.#hello;
    const codes = Object.keys(this.#kind.first); // the colour has controls of its own
    const settings = parameters.filter(({ name }) => !codes.includes(name));
    const sliders = (isHere, showHelp) =>
      settings.filter(({ name }) => isHere(name)).map((spec) => this.#makeSlider(spec, showHelp));
    const shape = shapeControls(this.#kind, (change) =>
      this.#edit((_, layer) => (layer.shape = change(layer.shape))),
    );
    this.#parts.push((layer) => shape.set(wholeShape(this.#kind, layer.shape), layer.shape));
    const isShine = (name) => SHINE.includes(name);
    return el(
      "fieldset",
      {},
      el("legend", { className: "hidden" }, this.#kind.product),
      this.#row?.element ?? null,
      this.#makeFinishes(),
      ...shape.choices,
      ...sliders((name) => name === "opacity", false),
      this.#makeStrength(),
      this.#group("Shape", shape.choices.length === 0, shape.others),
      this.#group("Shine", true, sliders(isShine, false)),
      this.#group(
        "More",
        false,
        sliders((name) => name !== "opacity" && !isShine(name), true),
      ),
    );
  }

  #group(title, open, elements) {
    return elements.length ? el("details", { open }, el("summary", {}, title), ...elements) : null;
  }

  #makeColour() {
    const label = `Colour of the ${this.#kind.product.toLowerCase()}`;
    const field = colourField(label, (rgb) =>
      this.#edit((_, layer) => Object.assign(layer.product, rgb)),
    );
    this.#parts.push((layer) => field.set(layer.product));
    return field;
  }

  #makeFinishes() {
    const { finishes } = this.#hello;
    const { part } = this.#kind;
    const buttons = Object.keys(finishes).map((name) => {
      const canvas = fineCanvas(48, 30);
      const settings = finishes[name][part];
      this.#finishes.push([canvas, settings]);
      const onclick = () => this.#edit((_, layer) => Object.assign(layer.product, settings));
      const button = el(
        "button",
        { type: "button", onclick, "aria-pressed": "false" },
        canvas,
        name,
      );
      this.#parts.push((layer) =>
        button.setAttribute("aria-pressed", finishOf(layer.product, finishes, part) === name),
      );
      return button;
    });
    return el("div", { className: "finishes", role: "group", "aria-label": "Finish" }, ...buttons);
  }

  #makeSlider(spec, showHelp) {
    const { element, set } = slider(
      spec,
      (value) => this.#edit((_, layer) => (layer.product[spec.name] = value)),
      showHelp,
    );
    this.#parts.push((layer) => set(layer.product[spec.name]));
    return element;
  }

  #makeStrength() {
    const spec = portion("strength", "Strength", "How much of this product is worn.");
    const { element, set } = slider(
      spec,
      (value) => this.#edit((_, layer) => (layer.strength = value)),
      false,
    );
    this.#parts.push((layer) => set(layer.strength));
    return element;
  }

  /** Draw only what has changed and is visible: a dragged slider leaves no time for more. */
  #drawSwatches() {
    const { swatch } = this.#kind;
    const products = this.#layers.map((layer) => layer.product);
    const shown = JSON.stringify(products);
    if (this.#tabSwatch.dataset.shown !== shown) drawSwatch(this.#tabSwatch, swatch, products);
    this.#tabSwatch.dataset.shown = shown;
    if (this.panel.hidden || this.#drawn === `${shown} ${this.#at}`) return;
    this.#drawn = `${shown} ${this.#at}`;
    const product = products[this.#at];
    for (const [canvas, settings] of this.#finishes)
      drawSwatch(canvas, swatch, [{ ...product, ...settings }]);
    this.#row?.draw();
  }
}
