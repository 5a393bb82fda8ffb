// Helpers that make elements.

/**
 * Make an element: el("button", {type: "button"}, "text", child). Sets each property that the
 * element has; any other name becomes an attribute.
 */
export function el(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name in element) element[name] = value;
    else if (value !== null) element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}

export const byId = (id) => document.getElementById(id);

export const clamp = (x, low, high) => Math.min(high, Math.max(low, x));

/** A canvas of a size in CSS pixels, with up to two of its own pixels for each CSS pixel. */
export function fineCanvas(width, height) {
  const scale = clamp(window.devicePixelRatio, 1, 2);
  return el("canvas", {
    width: Math.round(width * scale),
    height: Math.round(height * scale),
    "aria-hidden": "true",
  });
}

/** Call `work` for each click on a button; clicks while its promise is pending do nothing. */
export function oneAtATime(button, work) {
  // does not use `disabled`, which would take the focus from the button
  button.onclick = async () => {
    if (button.getAttribute("aria-busy") === "true") return;
    button.setAttribute("aria-busy", "true");
    await work().finally(() => button.setAttribute("aria-busy", "false"));
  };
}

let ids = 0;
export const newId = (stem) => `${stem}-${++ids}`;

/** A function that calls `work` once at the screen's next refresh, however often it is called. */
export function oncePerFrame(work) {
  let scheduled = false;
  return () => {
    if (scheduled) return;
    scheduled = true;
    requestAnimationFrame(() => {
      scheduled = false;
      work();
    });
  };
}
