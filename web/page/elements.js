// Small helpers that make elements.

/** el("button", {type: "button"}, "text", child): properties, or attributes where there is none. */
export function el(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name in element) element[name] = value;
    else if (value !== null) element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}

/** A canvas of a size in CSS pixels, sharp on the screen that it is on (twice as fine at most). */
export function fineCanvas(width, height) {
  const scale = Math.min(2, Math.max(1, window.devicePixelRatio));
  return el("canvas", {
    width: Math.round(width * scale),
    height: Math.round(height * scale),
    "aria-hidden": "true",
  });
}

let ids = 0;
export const newId = (stem) => `${stem}-${++ids}`;

/** One call with the next refresh of the screen, however often it is asked for. */
export function oncePerFrame(work) {
  let asked = false;
  return () => {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      work();
    });
  };
}
