// Zoom and pan of the picture: wheel, two fingers, a drag, keys, and a button.

import { byId, clamp } from "./elements.js";

const MOST = 8;
const BY_BUTTON = 2.5;
const BY_KEY = 1.25;
const PAN = 0.1; // share of the visible part that an arrow key moves
export const WHOLE = { zoom: 1, x: 0.5, y: 0.5 };

const within = (zoom) => clamp(zoom, 1, MOST);

/** onChange({zoom, x, y}): called with the part to show; x, y: its middle, as shares of the picture. */
export class Zoom {
  #frame = byId("frame");
  #button = byId("zoom-button");
  #onChange;
  #view = WHOLE;
  #fingers = new Map(); // by pointer: its place, as shares of the frame

  constructor(onChange) {
    this.#onChange = onChange;
    this.#button.onclick = () => this.toggle();
    const frame = this.#frame;
    frame.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    frame.addEventListener("pointerdown", (event) => this.#down(event), { capture: true });
    frame.addEventListener("pointermove", (event) => this.#move(event), { capture: true });
    // events of the window, since a drag may end outside the picture
    for (const type of ["pointerup", "pointercancel"])
      window.addEventListener(type, (event) => this.#fingers.delete(event.pointerId), {
        capture: true,
      });
    frame.addEventListener("keydown", (event) => this.#key(event));
  }

  toggle() {
    if (this.#view.zoom > 1) this.reset();
    else this.#put({ ...this.#view, zoom: BY_BUTTON });
  }

  /** Zoom by the keys + and -. */
  step(isIn) {
    this.#zoomAt(isIn ? BY_KEY : 1 / BY_KEY, { x: 0.5, y: 0.5 });
  }

  reset() {
    this.#put(WHOLE);
  }

  #put(view) {
    const zoom = within(view.zoom);
    const half = 0.5 / zoom;
    this.#view = { zoom, x: clamp(view.x, half, 1 - half), y: clamp(view.y, half, 1 - half) };
    const isZoomed = zoom > 1;
    this.#frame.classList.toggle("zoomed", isZoomed);
    this.#frame.tabIndex = isZoomed ? 0 : -1;
    this.#button.setAttribute("aria-pressed", isZoomed);
    this.#onChange(this.#view);
  }

  /** Zoom around a place of the frame: the point of the picture that is seen there stays there. */
  #zoomAt(by, { x, y }) {
    const { zoom } = this.#view;
    const next = within(zoom * by);
    const shift = 1 / zoom - 1 / next;
    this.#put({
      zoom: next,
      x: this.#view.x + (x - 0.5) * shift,
      y: this.#view.y + (y - 0.5) * shift,
    });
  }

  #pan(x, y) {
    const { zoom } = this.#view;
    this.#put({ zoom, x: this.#view.x - x / zoom, y: this.#view.y - y / zoom });
  }

  #placeOf(event) {
    const { left, top, width, height } = this.#frame.getBoundingClientRect();
    return { x: (event.clientX - left) / width, y: (event.clientY - top) / height };
  }

  #wheel(event) {
    event.preventDefault();
    this.#zoomAt(Math.exp(-event.deltaY / (event.ctrlKey ? 100 : 400)), this.#placeOf(event));
  }

  #down(event) {
    if (event.button) return; // not the first button of a mouse
    this.#fingers.set(event.pointerId, this.#placeOf(event));
    if (this.#fingers.size > 1) event.stopPropagation(); // two fingers do not move the divider
  }

  #move(event) {
    const before = this.#fingers.get(event.pointerId);
    if (!before) return;
    if (event.pointerType === "mouse" && !event.buttons) {
      this.#fingers.delete(event.pointerId); // released outside the window
      return;
    }
    const now = this.#placeOf(event);
    const other = [...this.#fingers].find(([id]) => id !== event.pointerId)?.[1];
    this.#fingers.set(event.pointerId, now);
    if (other) {
      event.stopPropagation();
      const ratio = distance(now, other) / Math.max(distance(before, other), 0.01);
      this.#zoomAt(ratio, { x: (now.x + other.x) / 2, y: (now.y + other.y) / 2 });
    }
    const isDivider = event.target.closest("#compare");
    if (other || (this.#view.zoom > 1 && !isDivider)) {
      const share = other ? 0.5 : 1;
      this.#pan(share * (now.x - before.x), share * (now.y - before.y));
    }
  }

  #key(event) {
    if (event.target !== this.#frame) return;
    const [x, y] = {
      ArrowLeft: [PAN, 0],
      ArrowRight: [-PAN, 0],
      ArrowUp: [0, PAN],
      ArrowDown: [0, -PAN],
    }[event.key] ?? [0, 0];
    if (!x && !y) return;
    event.preventDefault();
    this.#pan(x, y);
  }
}

const distance = (one, other) => Math.hypot(one.x - other.x, one.y - other.y);
