// One product of a look, lipstick or eye-shadow: its tab, and its panel of controls.

import { colourField, hexOf } from "./colour.js";
import { el, fineCanvas, newId, oncePerFrame } from "./elements.js";
import { portion, slider } from "./slider.js";
import { drawSwatch } from "./swatch.js";

const MAIN = ["opacity", "gloss", "gloss_roughness", "reflection"];
export const REGIONS = {
  lips: { title: "Lips", product: "Lipstick", red: 180, green: 0, blue: 46 },
  eyes: { title: "Eyes", product: "Eye-shadow", red: 90, green: 58, blue: 46 },
};
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
  #region;
  #hello;
  #last; // what it was before it was taken off, or what it begins with
  #parts = []; // set(params) of each control
  #swatches = []; // [canvas, params => params]

  constructor(region, hello, store) {
    this.#region = region;
    this.#hello = hello;
    this.#store = store;
    const { red, green, blue } = REGIONS[region];
    this.#last = { red, green, blue, ...hello.finishes[FIRST_FINISH][region] };
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
      el("b", {}, REGIONS[this.#region].title),
      this.tabText,
    );
  }

  #makePanel() {
    const { product } = REGIONS[this.#region];
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
      ...(this.#region === "eyes" ? [this.#makeZones(), this.#makeIntensity()] : []),
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
    const { element, set } = colourField(REGIONS[this.#region].product, (rgb) =>
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

  #makeZones() {
    const group = newId("zone");
    const choices = this.#hello.zones.map((zone) => {
      const radio = el("input", { type: "radio", name: group, value: zone });
      radio.addEventListener("change", () => this.#edit((_, look) => (look.zone = zone)));
      this.#parts.push((_, look) => (radio.checked = look.zone === zone));
      return el("label", {}, radio, el("span", {}, zone));
    });
    return el(
      "div",
      { className: "zones", role: "radiogroup", "aria-label": "Where the eye-shadow goes" },
      el("span", { "aria-hidden": "true" }, "Zone"),
      ...choices,
    );
  }

  #makeIntensity() {
    const spec = portion("intensity", "Intensity", "How much of the eye-shadow.");
    const { element, set } = slider(
      spec,
      (value) => this.#edit((_, look) => (look.intensity = value)),
      false,
    );
    this.#parts.push((_, look) => set(look.intensity));
    return element;
  }

  #drawSwatches() {
    for (const [canvas, product] of this.#swatches) drawSwatch(canvas, product(this.#last));
  }
}
