// The controls of a layer's shape, made from the dials of its kind.

import { colourField, hexOf, readHex } from "./colour.js";
import { el, newId } from "./elements.js";
import { inWords } from "./layers.js";
import { slider } from "./slider.js";

const FINE = 0.01; // the step of numbers
const WIDE = 20; // numbers with a wider range than this, such as angles, have whole steps

/**
 * edit(change): calls change(shape), which returns the layer's new shape.
 * Returns {choices, others, set(whole, shape)}: the elements of dials with choices, the elements of
 * all other dials, and a function that shows a shape. whole: a value for every dial; shape: only
 * the values that the layer itself has.
 */
export function shapeControls(kind, edit) {
  const toNumbers = () => {
    const [, first] = controls.find(([{ is_map: isMap, choices }]) => !isMap && !choices.length);
    first.element.querySelector("input").focus();
  };
  const controls = kind.dials.map((dial) => [dial, control(kind, dial, edit, toNumbers)]);
  const of = (isChoice) =>
    controls.filter(([{ choices }]) => choices.length > 0 === isChoice).map(([, one]) => one.element);
  const map = kind.dials.find(({ is_map }) => is_map);
  const set = (whole, shape) => {
    for (const [dial, one] of controls) {
      one.set(whole[dial.name], shape);
      // while the layer has a map, numbers would change nothing
      if (map && dial !== map && !dial.choices.length) one.element.hidden = whole[map.name] !== "";
    }
  };
  return { choices: of(true), others: of(false), set };
}

function control(kind, dial, edit, toNumbers) {
  if (dial.choices.length) return choice(kind, dial, edit);
  const put = (value) => edit((shape) => ({ ...shape, [dial.name]: value }));
  if (dial.is_map) return map(dial, edit, toNumbers);
  return dial.is_colour ? colour(dial, put) : number(dial, put);
}

/**
 * The control of a layer that is shaped as in a photo: a button gives the layer the numbers of its
 * slot instead. toNumbers(): moves the focus to the numbers, since the button vanishes.
 */
function map({ name, help }, edit, toNumbers) {
  const button = el("button", { type: "button", title: help }, "Use a plain shape");
  button.addEventListener("click", () => {
    edit(({ [name]: _, ...others }) => others);
    toNumbers();
  });
  const element = el("div", { className: "map" }, el("span", {}, "Shaped as in the photo."), button);
  const set = (text) => {
    element.hidden = text === "";
  };
  return { element, set };
}

function number({ name, title, help, unit, low, high }, put) {
  const step = high - low > WIDE ? 1 : FINE;
  return slider({ name, low, high, step, label: title, help, unit }, put, false);
}

function colour({ title, help }, put) {
  const field = colourField(title, (rgb) => put(hexOf(rgb)));
  const element = el(
    "div",
    { className: "slider", title: help },
    el("span", { "aria-hidden": "true" }, title),
    field.element,
    field.error,
  );
  return { element, set: (hex) => field.set(readHex(hex)) };
}

/**
 * A choice. Choosing a slot resets the whole shape except the other choices, such as the eye, so
 * all numbers become those of the slot.
 */
function choice(kind, { name, title, help, choices }, edit) {
  const isSlot = name === "slot";
  const others = kind.dials.filter((dial) => dial.choices.length && dial.name !== name);
  const isKept = ([key]) => others.some((dial) => dial.name === key);
  const kept = (shape) => (isSlot ? Object.fromEntries(Object.entries(shape).filter(isKept)) : shape);
  const group = newId(name);
  const radios = choices.map((value) => {
    const radio = el("input", { type: "radio", name: group, value });
    // "click" also comes for the slot that is chosen already, and then returns to its numbers
    radio.addEventListener("click", () => edit((shape) => ({ ...kept(shape), [name]: value })));
    return radio;
  });
  const element = el(
    "div",
    { className: "choices", role: "radiogroup", "aria-label": help },
    el("span", { "aria-hidden": "true" }, title),
    ...radios.map((radio) => el("label", {}, radio, el("span", {}, inWords(radio.value)))),
  );
  const set = (value, shape) => {
    for (const radio of radios) radio.checked = radio.value === value;
    const isOther = (entry) => entry[0] !== name && !isKept(entry);
    element.classList.toggle("changed", isSlot && Object.entries(shape).some(isOther));
  };
  return { element, set };
}
