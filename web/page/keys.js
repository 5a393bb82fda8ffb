// Keys of the whole page. The "?" dialog in index.html lists them, and can switch off the keys that
// work without Ctrl: people who dictate, or touch keys by accident, would trigger them.

import { byId } from "./elements.js";
import { listenToOtherPages, recall, remember } from "./remember.js";

const SINGLE_KEYS = "single keys";

/** A selector for fields in which the visitor types. */
export const TYPED =
  "input:not([type=range], [type=checkbox], [type=radio], [type=file], [type=color]), " +
  "textarea, select";

/** Call actions for keys: {compare, mirror, full, help, undo, redo, held(on), zoom(in), unzoom}. */
export function listenToKeys(actions) {
  const plain = {
    c: actions.compare,
    m: actions.mirror,
    f: actions.full,
    "?": actions.help,
    "+": () => actions.zoom(true),
    "=": () => actions.zoom(true),
    "-": () => actions.zoom(false),
    0: actions.unzoom,
  };
  const single = byId("single-keys");
  const showKept = () => (single.checked = recall(SINGLE_KEYS, (isOn) => isOn !== false));
  showKept();
  listenToOtherPages([SINGLE_KEYS], showKept);
  single.addEventListener("change", () => remember(SINGLE_KEYS, single.checked));
  document.addEventListener("keydown", (event) => {
    if (event.target.closest?.(TYPED) || document.querySelector("dialog[open]")) return;
    const key = event.key.toLowerCase();
    if ((event.ctrlKey || event.metaKey) && !event.altKey) {
      const action = { z: event.shiftKey ? actions.redo : actions.undo, y: actions.redo }[key];
      if (action) {
        event.preventDefault();
        action();
      }
    } else if (single.checked && !event.altKey && !event.repeat) {
      if (key === "b") actions.held(true);
      plain[key]?.();
    }
  });
  document.addEventListener(
    "keyup",
    (event) => event.key.toLowerCase() === "b" && actions.held(false),
  );
  window.addEventListener("blur", () => actions.held(false)); // the key may be released elsewhere
}
