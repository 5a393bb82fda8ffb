// A slider and a number field for one parameter.

import { el, newId } from "./elements.js";

const decimals = (step) => Math.max(0, Math.ceil(-Math.log10(step)));

/** The spec of a slider from 0 to 1. */
export function portion(name, label, help) {
  return { name, low: 0, high: 1, step: 0.01, label, help };
}

/**
 * spec: {name, low, high, step, label, help, unit}; unit may be missing. onInput(value): called while the slider moves.
 * Returns {element, set(value)}; `set` does not disturb a slider being dragged or a number being
 * typed.
 */
export function slider(spec, onInput, showHelp) {
  const id = newId(spec.name);
  const bounds = { min: spec.low, max: spec.high };
  const range = el("input", { type: "range", id, step: "any", ...bounds });
  const number = el("input", { type: "number", inputMode: "decimal", step: spec.step, ...bounds });
  number.setAttribute("aria-label", `${spec.label}, as a number`);
  const help = el("span", { id: `${id}-help`, className: showHelp ? "help" : "hidden" }, spec.help);
  range.setAttribute("aria-describedby", help.id);
  let dragged = false;
  let current = spec.low;
  let newest = spec.low; // of the look, also while the slider is dragged

  const rounded = (value) => Number(Number(value).toFixed(decimals(spec.step)));
  const clamped = (value) => Math.min(spec.high, Math.max(spec.low, value));
  const written = (value) => rounded(value).toFixed(decimals(spec.step));
  const show = (value) => {
    current = value;
    range.style.setProperty(
      "--part",
      `${(100 * (range.value - spec.low)) / (spec.high - spec.low)}%`,
    );
    if (document.activeElement !== number) number.value = written(value);
  };
  range.addEventListener("pointerdown", () => (dragged = true));
  for (const type of ["pointerup", "pointercancel", "blur"])
    range.addEventListener(type, () => {
      if (!dragged) return;
      dragged = false;
      set(newest); // another page may have changed it meanwhile
    });
  range.addEventListener("keydown", (event) => stepByKey(event, range, spec));
  range.addEventListener("input", () => {
    show(range.value);
    onInput(rounded(range.value));
  });
  const put = (value) => {
    range.value = value;
    show(value);
    onInput(rounded(value));
  };
  number.addEventListener("input", () => {
    const value = number.valueAsNumber;
    if (value === clamped(value)) put(value); // otherwise it is not a number in range yet
  });
  number.addEventListener("change", () => {
    if (Number.isNaN(number.valueAsNumber)) return;
    const value = clamped(number.valueAsNumber);
    number.value = written(value);
    put(value);
  });
  number.addEventListener("blur", () => (number.value = written(current)));

  const element = el(
    "div",
    { className: "slider", title: showHelp ? "" : spec.help },
    el("label", { htmlFor: id }, spec.label),
    spec.unit ? el("small", { "aria-hidden": "true" }, spec.unit) : null,
    range,
    number,
    help,
  );
  const set = (value) => {
    newest = value;
    if (dragged) return;
    range.value = value;
    range.setAttribute("aria-valuetext", `${written(value)} ${spec.unit ?? ""}`.trim());
    show(value);
  };
  return { element, set };
}

/** Arrow keys move by the step, which step="any" (for smooth dragging) would not do. */
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
  range.value = Math.min(spec.high, Math.max(spec.low, Number(range.value) + steps * spec.step));
  range.dispatchEvent(new Event("input"));
}
