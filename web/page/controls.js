// The controls of a look: products as tabs, and for each its colour, finish and parameters.

import { el, fineCanvas, newId, oncePerFrame } from "./elements.js";
import { slider } from "./slider.js";
import { drawSwatch } from "./swatch.js";

const MAIN = ["opacity", "gloss", "gloss_roughness", "reflection"];
const REGIONS = {
  lips: { title: "Lips", product: "Lipstick", red: 180, green: 0, blue: 46 },
  eyes: { title: "Eyes", product: "Eye-shadow", red: 90, green: 58, blue: 46 },
};
const FIRST_FINISH = "satin";
const EXACT = 1e-9;

const hexOf = (params) =>
  "#" + [params.red, params.green, params.blue].map((code) => Math.round(code).toString(16).padStart(2, "0")).join("").toUpperCase();

/** {red, green, blue} of "#B4002E", "b4002e" or "#b03"; null when it is none of these. */
function readHex(text) {
  let digits = text.trim().replace(/^#/, "");
  if (/^[0-9a-f]{3}$/i.test(digits)) digits = digits.replace(/./g, "$&$&");
  if (!/^[0-9a-f]{6}$/i.test(digits)) return null;
  const [red, green, blue] = [0, 2, 4].map((at) => parseInt(digits.slice(at, at + 2), 16));
  return { red, green, blue };
}

function finishOf(params, finishes, region) {
  return Object.keys(finishes).find((name) =>
    Object.entries(finishes[name][region]).every(([key, value]) => Math.abs(params[key] - value) < EXACT),
  );
}

/** One product: its tab, and its panel. */
class Product {
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
    this.body.disabled = params === null;
    for (const set of this.#parts) set(this.#last, look);
    const finish = finishOf(this.#last, this.#hello.finishes, this.#region);
    this.tabText.textContent = params === null ? "bare" : `${hexOf(params)} ${finish ?? "own mix"}`;
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
    return el("button", { type: "button", role: "tab", id: `${this.#region}-tab`, "aria-controls": this.panel.id },
      canvas, el("b", {}, REGIONS[this.#region].title), this.tabText);
  }

  #makePanel() {
    const { product } = REGIONS[this.#region];
    this.switch = el("input", { type: "checkbox", role: "switch" });
    this.switch.addEventListener("change", () =>
      this.#store.edit((look) => (look[this.#region] = this.switch.checked ? structuredClone(this.#last) : null)));
    const rest = this.#hello.parameters.filter(({ name }) => !MAIN.includes(name));
    this.body = el("fieldset", {},
      el("legend", { className: "hidden" }, product),
      this.#makeFinishes(),
      ...MAIN.map((name) => this.#makeSlider(this.#hello.parameters.find((one) => one.name === name), false)),
      ...(this.#region === "eyes" ? [this.#makeZones(), this.#makeIntensity()] : []),
      el("details", {}, el("summary", {}, "More"), ...rest.map((spec) => this.#makeSlider(spec, true))),
    );
    return el("div", { role: "tabpanel", id: `${this.#region}-panel`, "aria-labelledby": `${this.#region}-tab` },
      el("div", { className: "row first" }, el("label", { className: "switch" }, this.switch, product), this.#makeColour()),
      this.body);
  }

  #makeColour() {
    const name = REGIONS[this.#region].product;
    const well = el("input", { type: "color", "aria-label": `Colour of the ${name.toLowerCase()}` });
    const hex = el("input", { className: "hex", maxLength: 7, spellcheck: false, autocomplete: "off", "aria-label": `Colour of the ${name.toLowerCase()}, as hex digits` });
    const put = (rgb) => this.#edit((params) => Object.assign(params, rgb));
    well.addEventListener("input", () => put(readHex(well.value)));
    hex.addEventListener("input", () => {
      const rgb = readHex(hex.value);
      hex.setCustomValidity(rgb === null ? "Six hex digits, such as B4002E" : "");
      if (rgb !== null && hex.value.trim().replace(/^#/, "").length === 6) put(rgb);
    });
    hex.addEventListener("change", () => {
      const rgb = readHex(hex.value);
      if (rgb !== null) put(rgb);
      hex.setCustomValidity("");
      hex.value = hexOf(this.#last);
    });
    this.#parts.push((params) => {
      if (document.activeElement !== well || well.value.toUpperCase() !== hexOf(params)) well.value = hexOf(params).toLowerCase();
      if (document.activeElement !== hex) hex.value = hexOf(params);
    });
    return el("span", { className: "colour" }, well, hex);
  }

  #makeFinishes() {
    const { finishes } = this.#hello;
    const buttons = Object.keys(finishes).map((name) => {
      const canvas = fineCanvas(48, 30);
      const settings = finishes[name][this.#region];
      this.#swatches.push([canvas, (params) => ({ ...params, ...settings })]);
      const onclick = () => this.#edit((params) => Object.assign(params, settings));
      const button = el("button", { type: "button", onclick, "aria-pressed": "false" }, canvas, name);
      this.#parts.push((params) => button.setAttribute("aria-pressed", finishOf(params, finishes, this.#region) === name));
      return button;
    });
    return el("div", { className: "finishes", role: "group", "aria-label": "Finish" }, ...buttons);
  }

  #makeSlider(spec, showHelp) {
    const { element, set } = slider(spec, (value) => this.#edit((params) => (params[spec.name] = value)), showHelp);
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
    return el("div", { className: "zones", role: "radiogroup", "aria-label": "Where the eye-shadow goes" }, el("span", { "aria-hidden": "true" }, "Zone"), ...choices);
  }

  #makeIntensity() {
    const spec = { name: "intensity", low: 0, high: 1, step: 0.01, label: "Intensity", help: "How much of the eye-shadow." };
    const { element, set } = slider(spec, (value) => this.#edit((_, look) => (look.intensity = value)), false);
    this.#parts.push((_, look) => set(look.intensity));
    return element;
  }

  #drawSwatches() {
    for (const [canvas, product] of this.#swatches) drawSwatch(canvas, product(this.#last));
  }
}

/** Builds all controls into the page and keeps them as the look is. */
export class Controls {
  #products;
  #set = [];

  constructor(hello, store) {
    const regions = Object.keys(REGIONS);
    this.#products = regions.map((region) => new Product(region, hello, store));
    document.getElementById("products").replaceChildren(...this.#products.map(({ tab }) => tab));
    document.getElementById("regions").replaceChildren(...this.#products.map(({ panel }) => panel));
    this.#products.forEach(({ tab }, at) => {
      tab.addEventListener("click", () => this.#select(at));
      tab.addEventListener("keydown", (event) => this.#selectByKey(event, at));
    });
    const spec = { name: "strength", low: 0, high: 1, step: 0.01, label: "Whole look", help: "How much of all of it, lips and eyes." };
    const strength = slider(spec, (value) => store.edit((look) => (look.strength = value)), false);
    document.getElementById("whole").replaceChildren(strength.element);
    this.#set = [(look) => strength.set(look.strength)];
    this.#select(0);
    const show = () => this.#show(store.look);
    store.addEventListener("change", show);
    show();
  }

  #show(look) {
    for (const product of this.#products) product.show(look);
    for (const set of this.#set) set(look);
  }

  #select(at) {
    this.#products.forEach(({ tab, panel }, here) => {
      tab.setAttribute("aria-selected", here === at);
      tab.tabIndex = here === at ? 0 : -1;
      panel.hidden = here !== at;
    });
  }

  #selectByKey(event, at) {
    const count = this.#products.length;
    const to = { ArrowRight: (at + 1) % count, ArrowLeft: (at + count - 1) % count, Home: 0, End: count - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    this.#select(to);
    this.#products[to].tab.focus();
  }
}
