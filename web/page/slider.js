// A slider and a number field for one parameter.

import { clamp, el, newId } from "./elements.js";

const decimals = (step) => Math.max(0, Math.ceil(-Math.log10(step)));

/** The spec of a slider from 0 to 1. */
export function portion(name, label, help) {
  return { name, low: 0, high: 1, step: 0.01, label, help };
}

const clamped = (spec, value) => clamp(value, spec.low, spec.high);
const rounded = (spec, value) => Number(Number(value).toFixed(decimals(spec.step)));
const written = (spec, value) => rounded(spec, value).toFixed(decimals(spec.step));

/**
 * spec: {name, low, high, step, label, help, unit}; unit may be missing. onInput(value): called
 * while the slider moves. Returns {element, set(value)}; `set` does not disturb a slider being
 * dragged or a number being typed.
 */
export function slider(spec, onInput, showHelp) {
  const id = newId(spec.name);
  const bounds = { min: spec.low, max: spec.high };
  const range = el("input", { type: "range", id, step: "any", ...bounds });
  const help = el("span", { id: `${id}-help`, className: showHelp ? "help" : "hidden" }, spec.help);
  range.setAttribute("aria-describedby", help.id);
  let dragged = false;
  let newest = spec.low; // the value in the look, also while the slider is dragged

  const put = (value) => {
    range.value = value;
    show(value);
    onInput(rounded(spec, value));
  };
  const number = numberField(spec, put);
  const show = (value) => {
    const part = (range.value - spec.low) / (spec.high - spec.low);
    range.style.setProperty("--part", `${100 * part}%`);
    number.show(value);
  };
  const set = (value) => {
    newest = value;
    if (dragged) return;
    range.value = value;
    range.setAttribute("aria-valuetext", `${written(spec, value)} ${spec.unit ?? ""}`.trim());
    show(value);
  };
  range.addEventListener("pointerdown", () => (dragged = true));
  for (const type of ["pointerup", "pointercancel", "blur"])
    range.addEventListener(type, () => {
      if (!dragged) return;
      dragged = false;
      set(newest); // another page may have changed the value meanwhile
    });
  range.addEventListener("keydown", (event) => stepByKey(event, range, spec));
  range.addEventListener("input", () => put(range.value));
  const element = el(
    "div",
    { className: "slider", title: showHelp ? "" : spec.help },
    el("label", { htmlFor: id }, spec.label),
    spec.unit ? el("small", { "aria-hidden": "true" }, spec.unit) : null,
    range,
    number.element,
    help,
  );
  return { element, set };
}

/**
 * The number beside a slider. put(value): called with each number in range that is typed. Returns
 * {element, show(value)}; `show` leaves a number alone while it is typed.
 */
function numberField(spec, put) {
  const { low: min, high: max, step } = spec;
  const element = el("input", { type: "number", inputMode: "decimal", step, min, max });
  element.setAttribute("aria-label", `${spec.label}, as a number`);
  let current = spec.low;
  const show = (value) => {
    current = value;
    if (document.activeElement !== element) element.value = written(spec, value);
  };
  element.addEventListener("input", () => {
    const value = element.valueAsNumber;
    if (value === clamped(spec, value)) put(value); // otherwise it is not a number in range yet
  });
  element.addEventListener("change", () => {
    if (Number.isNaN(element.valueAsNumber)) return;
    const value = clamped(spec, element.valueAsNumber);
    element.value = written(spec, value);
    put(value);
  });
  element.addEventListener("blur", () => (element.value = written(spec, current)));
  return { element, show };
}

/** Let arrow keys move by the step, which step="any" (for smooth dragging) would not do. */
function stepByKey(event, range, spec) {
  const steps = {
    ArrowRight: 1,
    ArrowUp: 1,
    ArrowLeft: -1,
    ArrowDown: -1,
    PageUp: 10,
    PageDown: -10,
  }[event.key];
  if (steps === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  range.value = clamped(spec, Number(range.value) + steps * spec.step);
  range.dispatchEvent(new Event("input"));
}
