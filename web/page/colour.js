// A colour: its hex digits, and the colour well and text field that change the colour.

import { el, newId } from "./elements.js";

/** "#B4002E" of {red, green, blue}. */
export const hexOf = (params) =>
  "#" +
  [params.red, params.green, params.blue]
    .map((code) => Math.round(code).toString(16).padStart(2, "0"))
    .join("")
    .toUpperCase();

/** {red, green, blue} of "#B4002E", "b4002e" or "#b03"; null for any other text. */
export function readHex(text) {
  let digits = text.trim().replace(/^#/, "");
  if (/^[0-9a-f]{3}$/i.test(digits)) digits = digits.replace(/./g, "$&$&");
  if (!/^[0-9a-f]{6}$/i.test(digits)) return null;
  const [red, green, blue] = [0, 2, 4].map((at) => parseInt(digits.slice(at, at + 2), 16));
  return { red, green, blue };
}

/**
 * label: the name of the controls. onInput({red, green, blue}): called when the visitor chooses a colour.
 * Returns {element, set(params), error}; `set` does not change a field while the visitor types in
 * it. error: the element that says why a text is not a colour.
 */
export function colourField(label, onInput) {
  const well = el("input", { type: "color", "aria-label": label });
  const hex = el("input", {
    className: "hex",
    spellcheck: false,
    autocomplete: "off",
    "aria-label": `${label}, as hex digits`,
  });
  const error = el("p", { className: "error", id: newId("hex-error"), role: "alert" });
  hex.setAttribute("aria-describedby", error.id);
  let current = "";
  let before = null; // the colour before a text that is still being typed
  well.addEventListener("input", () => onInput(readHex(well.value)));
  hex.addEventListener("input", () => {
    const rgb = readHex(hex.value);
    hex.setCustomValidity(rgb === null ? "Six hex digits, such as B4002E" : "");
    // three digits may still become six
    if (rgb !== null) error.textContent = "";
    if (rgb === null || hex.value.trim().length < 6) return;
    before ??= current;
    onInput(rgb);
  });
  hex.addEventListener("change", () => {
    const rgb = readHex(hex.value);
    // the first digits of a longer text may have been taken for a colour
    const chosen = rgb ?? (before && readHex(before));
    if (chosen !== null) onInput(chosen);
    error.textContent =
      rgb === null ? `“${hex.value}” is not a colour: give six hex digits, such as B4002E.` : "";
    if (rgb === null) hex.value = current;
    before = null;
    hex.setCustomValidity("");
  });
  hex.addEventListener("blur", () => {
    hex.value = current;
    before = null; // there is no "change" event when the text is the same as at first
  });
  const set = (params) => {
    if (hexOf(params) !== current) error.textContent = ""; // the error is about an older text
    current = hexOf(params);
    if (well.value.toUpperCase() !== current) well.value = current.toLowerCase();
    if (document.activeElement !== hex) hex.value = current;
  };
  return { element: el("span", { className: "colour" }, well, hex), set, error };
}
