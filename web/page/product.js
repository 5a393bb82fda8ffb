// One product of a look, such as lipstick: its tab, and its panel of controls.

import { colourField, hexOf } from "./colour.js";
import { el, fineCanvas, newId, oncePerFrame } from "./elements.js";
import { slider } from "./slider.js";
import { drawSwatch } from "./swatch.js";

const MAIN = ["opacity", "gloss", "gloss_roughness", "reflection"];
const FIRST_FINISH = "satin";
const EXACT = 1e-9;

function finishOf(params, finishes, region) {
  return Object.keys(finishes).find((name) =>
    Object.entries(finishes[name][region]).every(
      ([key, value]) => Math.abs(params[key] - value) < EXACT,
    ),
  );
}

/** One product: its tab, and its panel. */
export class Product {
  #store;
  #info; // of its region: name, title, product, first, dials
  #region; // its name
  #hello;
  #last; // what it was before it was taken off, or what it begins with
  #parts = []; // set(params) of each control
  #swatches = []; // [canvas, params => params]

  constructor(info, hello, store) {
    this.#info = info;
    this.#region = info.name;
    this.#hello = hello;
    this.#store = store;
    this.#last = { ...info.first, ...hello.finishes[FIRST_FINISH][info.name] };
    this.panel = this.#makePanel();
    this.tab = this.#makeTab();
    this.draw = oncePerFrame(() => this.#drawSwatches());
  }

  /** Show the look; called after every change. */
  show(look) {
    const params = look[this.#region];
    if (params !== null) this.#last = params;
    this.switch.checked = params !== null;
    this.body.classList.toggle("off", params === null); // any change puts it on
    for (const set of this.#parts) set(this.#last, look);
    const finish = finishOf(this.#last, this.#hello.finishes, this.#region);
    this.tabText.textContent = params === null ? "bare" : `${hexOf(params)} ${finish ?? "custom"}`;
    this.tab.classList.toggle("bare", params === null);
    this.draw();
  }

  #edit(change) {
    this.#store.edit((look) => {
      look[this.#region] ??= structuredClone(this.#last);
      change(look[this.#region], look);
    });
  }

  #makeTab() {
    const canvas = fineCanvas(160, 40);
    this.#swatches.push([canvas, (params) => params]);
    this.tabText = el("small");
    return el(
      "button",
      { type: "button", role: "tab", id: `${this.#region}-tab`, "aria-controls": this.panel.id },
      canvas,
      el("b", {}, this.#info.title),
      this.tabText,
    );
  }

  #makePanel() {
    const { product } = this.#info;
    this.switch = el("input", { type: "checkbox", role: "switch" });
    this.switch.addEventListener("change", () =>
      this.#store.edit(
        (look) => (look[this.#region] = this.switch.checked ? structuredClone(this.#last) : null),
      ),
    );
    const isMain = ({ name }) => MAIN.includes(name);
    const { parameters } = this.#hello;
    this.body = el(
      "fieldset",
      {},
      el("legend", { className: "hidden" }, product),
      this.#makeFinishes(),
      ...parameters.filter(isMain).map((spec) => this.#makeSlider(spec, false)),
      ...this.#info.dials.map((dial) =>
        dial.choices.length ? this.#makeChoices(dial) : this.#makeDial(dial),
      ),
      el(
        "details",
        {},
        el("summary", {}, "More"),
        ...parameters.filter((one) => !isMain(one)).map((spec) => this.#makeSlider(spec, true)),
      ),
    );
    return el(
      "div",
      { role: "tabpanel", id: `${this.#region}-panel`, "aria-labelledby": `${this.#region}-tab` },
      el(
        "div",
        { className: "row first" },
        el("label", { className: "switch" }, this.switch, product),
        this.#makeColour(),
      ),
      this.body,
    );
  }

  #makeColour() {
    const { element, set } = colourField(this.#info.product, (rgb) =>
      this.#edit((params) => Object.assign(params, rgb)),
    );
    this.#parts.push(set);
    return element;
  }

  #makeFinishes() {
    const { finishes } = this.#hello;
    const buttons = Object.keys(finishes).map((name) => {
      const canvas = fineCanvas(48, 30);
      const settings = finishes[name][this.#region];
      this.#swatches.push([canvas, (params) => ({ ...params, ...settings })]);
      const onclick = () => this.#edit((params) => Object.assign(params, settings));
      const button = el(
        "button",
        { type: "button", onclick, "aria-pressed": "false" },
        canvas,
        name,
      );
      this.#parts.push((params) =>
        button.setAttribute("aria-pressed", finishOf(params, finishes, this.#region) === name),
      );
      return button;
    });
    return el("div", { className: "finishes", role: "group", "aria-label": "Finish" }, ...buttons);
  }

  #makeSlider(spec, showHelp) {
    const { element, set } = slider(
      spec,
      (value) => this.#edit((params) => (params[spec.name] = value)),
      showHelp,
    );
    this.#parts.push((params) => set(params[spec.name]));
    return element;
  }

  #makeChoices({ name, title, help, choices }) {
    const group = newId(name);
    const buttons = choices.map((choice) => {
      const radio = el("input", { type: "radio", name: group, value: choice });
      radio.addEventListener("change", () => this.#edit((_, look) => (look[name] = choice)));
      this.#parts.push((_, look) => (radio.checked = look[name] === choice));
      return el("label", {}, radio, el("span", {}, choice));
    });
    return el(
      "div",
      { className: "zones", role: "radiogroup", "aria-label": help },
      el("span", { "aria-hidden": "true" }, title),
      ...buttons,
    );
  }

  #makeDial({ name, title, help, low, high }) {
    const spec = { name, low, high, step: 0.01, label: title, help };
    const change = (value) => this.#edit((_, look) => (look[name] = value));
    const { element, set } = slider(spec, change, false);
    this.#parts.push((_, look) => set(look[name]));
    return element;
  }

  #drawSwatches() {
    for (const [canvas, product] of this.#swatches) drawSwatch(canvas, product(this.#last));
  }
}
