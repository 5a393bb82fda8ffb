// Shades: kept ones, recently used ones, and those of a catalogue; a row in each kind's panel.

import { addressOf, ask, isReadable, NO_ANSWER, unreadable } from "./ask.js";
import { hexOf } from "./colour.js";
import { el } from "./elements.js";
import { layersOf } from "./layers.js";
import {
  isObject,
  isText,
  listenToOtherPages,
  listOf,
  recall,
  remember,
  revise,
} from "./remember.js";
import { moveByKeys, stopAt } from "./row.js";

const KEPT = "kept shades"; // by part: {hex, title}
const RECENT = "recent shades"; // by part: hex
const CATALOGUE = "catalogue"; // {name, shades: [{title, hex, parts}]}
const MOST_RECENT = 10;
const MOST_SHOWN = 120; // shades of a catalogue at once; the visitor finds the others by name
const SETTLED_MS = 1500; // a colour that stays for this time counts as used

const isHex = (value) => isText(value) && /^#[0-9A-F]{6}$/.test(value);
const isShade = (value) => isObject(value) && isHex(value.hex) && isText(value.title);
/** The lists of an object, each with only the entries that pass a test. */
const listsOf = (value, test) =>
  Object.fromEntries(
    Object.entries(isObject(value) ? value : {}).map(([part, list]) => [part, listOf(list, test)]),
  );
const keptShades = (value) => listsOf(value, isShade);
const recentHexes = (value) => listsOf(value, isHex);
const catalogueIn = (value) =>
  isObject(value) && isText(value.name)
    ? {
        name: value.name,
        shades: listOf(value.shades, (one) => isShade(one) && Array.isArray(one.parts)),
      }
    : null;

/** The shades of all kinds. Fires "change". */
export class Shades extends EventTarget {
  #kept;
  #recent;
  catalogue; // {name, shades}, or null
  #timer = 0;

  constructor() {
    super();
    this.#recall();
    listenToOtherPages([KEPT, RECENT, CATALOGUE], () => {
      this.#recall();
      this.dispatchEvent(new Event("change"));
    });
  }

  #recall() {
    this.#kept = recall(KEPT, keptShades);
    this.#recent = recall(RECENT, recentHexes);
    this.catalogue = recall(CATALOGUE, catalogueIn);
  }

  /** Note the colours of the look once they stay for a while; called after every change. */
  note(look, kinds) {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#used(look, kinds), SETTLED_MS);
  }

  /** The shades of a part as {hex, title, isKept}: first the kept ones, then the recent ones. */
  own(part) {
    const kept = this.#kept[part] ?? [];
    const recent = (this.#recent[part] ?? []).filter((hex) => !kept.some((one) => one.hex === hex));
    return [
      ...kept.map((one) => ({ ...one, isKept: true })),
      ...recent.map((hex) => ({ hex, title: this.titleOf(part, hex), isKept: false })),
    ];
  }

  /** The name of a colour in the catalogue; if it has none, its hex digits. */
  titleOf(part, hex) {
    const same = (one) => one.hex === hex && one.parts.includes(part);
    return this.catalogue?.shades.find(same)?.title ?? hex;
  }

  isKept(part, hex) {
    return (this.#kept[part] ?? []).some((one) => one.hex === hex);
  }

  /** Keep a shade, or stop keeping it. */
  toggle(part, hex) {
    const isKept = this.isKept(part, hex);
    this.#kept = revise(KEPT, keptShades, (kept) => {
      const others = (kept[part] ?? []).filter((one) => one.hex !== hex);
      const shade = { hex, title: this.titleOf(part, hex) };
      return { ...kept, [part]: isKept ? others : [shade, ...others] };
    });
    this.dispatchEvent(new Event("change"));
  }

  /** Read a CSV file on the server; returns the reason for a refusal, or "". */
  async open(file, session) {
    if (!(await isReadable(file))) return unreadable(file.name);
    try {
      const headers = { "X-File-Name": encodeURIComponent(file.name) };
      const address = addressOf("/shades", session);
      const response = await ask(address, { method: "POST", body: file, headers });
      const answer = await response.json();
      if (!response.ok) return answer.error;
      this.#setCatalogue(answer);
      return "";
    } catch {
      return `${file.name} could not be sent: ${NO_ANSWER}`;
    }
  }

  close() {
    this.#setCatalogue(null);
  }

  #setCatalogue(catalogue) {
    this.catalogue = catalogue;
    remember(CATALOGUE, catalogue);
    this.dispatchEvent(new Event("change"));
  }

  #used(look, kinds) {
    this.#recent = revise(RECENT, recentHexes, (recent) => {
      const used = kinds.map(({ part, name }) => {
        const hexes = layersOf(look, { name }).map(({ product }) => hexOf(product));
        const all = new Set([...hexes, ...(recent[part] ?? [])]); // each colour once, newest first
        return [part, [...all].slice(0, MOST_RECENT)];
      });
      return { ...recent, ...Object.fromEntries(used) };
    });
    this.dispatchEvent(new Event("change"));
  }
}

/**
 * The shades of one kind. choose(hex): called when the visitor picks one.  open(file): called when
 * the visitor gives a catalogue.
 */
export class ShadeRow {
  #shades;
  #part;
  #choose;
  #hex = "";
  #catalogue;
  #own = el("div", { className: "shades", role: "group", "aria-label": "Kept and recent shades" });
  #all = el("div", { className: "shades all", role: "group", "aria-label": "Shades" });
  #keep = el("button", {
    type: "button",
    className: "keep-shade",
    title: "Keep this shade",
    "aria-label": "Keep this shade",
  });
  #name = el("span");
  #more = el("small");
  #find = el("input", { type: "search", placeholder: "Find a shade", "aria-label": "Find a shade" });

  constructor(kind, shades, choose, open) {
    this.#part = kind.part;
    this.#shades = shades;
    this.#choose = choose;
    this.#keep.onclick = () => shades.toggle(this.#part, this.#hex);
    this.#find.addEventListener("input", () => this.draw());
    const file = el("input", {
      type: "file",
      accept: ".csv,text/csv",
      "aria-label": "Open a catalogue of shades, a CSV file",
    });
    file.addEventListener("change", () => {
      if (file.files.length) open(file.files[0]);
      file.value = "";
    });
    const opener = el("label", { className: "button open-shades" }, "Shades …", file);
    opener.title = "A CSV file with the columns brand, product, shade, hex";
    const onclick = () => {
      shades.close();
      file.focus(); // the button vanishes
    };
    const close = el(
      "button",
      { type: "button", "aria-label": "Close the catalogue", onclick },
      "×",
    );
    this.#catalogue = el(
      "div",
      { className: "catalogue" },
      el("div", { className: "row" }, this.#name, this.#find, close),
      this.#all,
      this.#more,
    );
    this.element = el(
      "div",
      { className: "shade-rows" },
      el("div", { className: "row" }, this.#own, this.#keep, opener),
      this.#catalogue,
    );
    moveByKeys(this.#own);
    moveByKeys(this.#all);
    shades.addEventListener("change", () => this.draw());
  }

  /** Show which shade is worn. */
  set(product) {
    const hex = hexOf(product);
    if (hex === this.#hex) return;
    this.#hex = hex;
    this.draw();
  }

  /** Draw what has changed. A hidden panel is drawn when it is shown. */
  draw() {
    if (this.element.closest("[hidden]")) return;
    const isKept = this.#shades.isKept(this.#part, this.#hex);
    this.#keep.textContent = isKept ? "★" : "☆";
    this.#keep.setAttribute("aria-pressed", isKept);
    this.#fill(this.#own, this.#shades.own(this.#part));
    this.#drawCatalogue();
    for (const button of this.element.querySelectorAll("[data-hex]"))
      button.setAttribute("aria-pressed", button.dataset.hex === this.#hex);
  }

  #drawCatalogue() {
    const { catalogue } = this.#shades;
    const fitting = (catalogue?.shades ?? []).filter(({ parts }) => parts.includes(this.#part));
    this.#catalogue.hidden = !fitting.length;
    if (!fitting.length) return;
    const words = this.#find.value.toLowerCase().split(/\s+/).filter(Boolean);
    const isWanted = ({ title, hex }) =>
      words.every((word) => `${title} ${hex}`.toLowerCase().includes(word));
    const found = fitting.filter(isWanted);
    this.#name.textContent = catalogue.name;
    this.#more.textContent = found.length
      ? found.length > MOST_SHOWN
        ? `${MOST_SHOWN} of ${found.length} shades: type to find others`
        : ""
      : "No shade has this name.";
    this.#fill(this.#all, found.slice(0, MOST_SHOWN));
  }

  #fill(row, shades) {
    const key = JSON.stringify(shades);
    if (row.dataset.shades === key) return;
    row.dataset.shades = key;
    const focused = row.contains(document.activeElement) && document.activeElement.dataset.hex;
    row.replaceChildren(...shades.map((shade) => this.#makeButton(shade)));
    if (row.firstElementChild) stopAt(row, row.firstElementChild);
    row.hidden = !shades.length;
    if (focused) row.querySelector(`[data-hex="${focused}"]`)?.focus();
  }

  #makeButton({ hex, title, isKept }) {
    const patch = el("span", { className: "patch" }, isKept ? "★" : "");
    patch.style.backgroundColor = hex;
    const name = title === hex ? hex : `${title}, ${hex}`;
    const button = el(
      "button",
      { type: "button", title: name, "aria-label": name, onclick: () => this.#choose(hex) },
      patch,
      el("small", {}, title),
    );
    button.dataset.hex = hex;
    return button;
  }
}
