// What the browser keeps for the visitor: shades, looks, and the session of a page.
//
// Each value is checked when it is read: another version of the page, or the visitor, may have
// written it. Several pages share the values, so each change begins with what is kept by then.

const unkept = new Map(); // by key: texts that the browser, full or set to keep nothing, refused

/**
 * What is kept under a key. check(value): returns the usable part of a value, whatever that is; it
 * is given null where nothing is kept.
 */
export function recall(key, check, storage = "localStorage") {
  try {
    return check(JSON.parse(unkept.get(key) ?? window[storage].getItem(key)));
  } catch {
    return check(null);
  }
}

/** Keep a value. What the browser refuses is kept for this visit alone. */
export function remember(key, value, storage = "localStorage") {
  const text = JSON.stringify(value);
  try {
    window[storage].setItem(key, text);
    unkept.delete(key);
  } catch {
    unkept.set(key, text);
  }
}

/** Keep change(value) instead of what is kept by now, and return it. */
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
/** The entries of a list that pass a test; none where it is no list. */
export const listOf = (value, test) => (Array.isArray(value) ? value.filter(test) : []);
