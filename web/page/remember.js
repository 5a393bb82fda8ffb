// What this browser remembers of the visitor: shades and looks that were kept or used.

/** The value of a key; `otherwise` when there is none, or when the browser keeps nothing. */
export function recall(key, otherwise) {
  try {
    return JSON.parse(localStorage.getItem(key)) ?? otherwise;
  } catch {
    return otherwise;
  }
}

/** Keep a value. A browser that is full or set to keep nothing keeps it for this visit alone. */
export function remember(key, value) {
  try {
    localStorage.setItem(key, JSON.stringify(value));
  } catch {
    // the page goes on with what it has in memory
  }
}
