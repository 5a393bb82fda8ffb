// The values that the browser keeps for the visitor: shades, looks, and the session of a page.
//
// Each value is checked when it is read: another version of the page, or the visitor, may have
// written it. Several pages share the values, so each change starts from the value kept at that
// moment.

// by key: texts that the browser refused to keep, since it is full or set to keep nothing
const unkept = new Map();

/**
 * The value kept under a key. check(value): returns the usable part of any value; it gets null if
 * nothing is kept.
 */
export function recall(key, check, storage = "localStorage") {
  try {
    return check(JSON.parse(unkept.get(key) ?? window[storage].getItem(key)));
  } catch {
    return check(null);
  }
}

/** Keep a value. A value that the browser refuses is kept only for this visit. */
export function remember(key, value, storage = "localStorage") {
  const text = JSON.stringify(value);
  try {
    window[storage].setItem(key, text);
    unkept.delete(key);
  } catch {
    unkept.set(key, text);
  }
}

/** Replace the value that is kept now by change(value), and return the new value. */
export function revise(key, check, change) {
  const value = change(recall(key, check));
  remember(key, value);
  return value;
}

/** Call redraw() when another page has changed one of the keys. */
export function listenToOtherPages(keys, redraw) {
  // the key is null when everything was removed
  window.addEventListener("storage", ({ key }) => (key === null || keys.includes(key)) && redraw());
}

export const isText = (value) => typeof value === "string";
export const isObject = (value) =>
  typeof value === "object" && value !== null && !Array.isArray(value);
/** The entries of a list that pass a test; [] if the value is not a list. */
export const listOf = (value, test) => (Array.isArray(value) ? value.filter(test) : []);
