// Before and after: the divider over the picture, and the key that shows the picture without
// makeup.

import { byId, clamp } from "./elements.js";

const STEP = 0.02; // of the width, for an arrow key
const PAGE = 0.1; // for Page Up and Page Down

/** ask(on): called when pictures without makeup are needed, and when they no longer are. */
export class Compare {
  #picture;
  #ask;
  #split = 0.5;
  #isOn = false;
  #isHeld = false;
  #asked = false;
  #area = byId("compare");
  #divider = byId("divider");
  #heldChip = byId("held");

  constructor(picture, ask) {
    this.#picture = picture;
    this.#ask = ask;
    const frame = byId("frame");
    this.#area.addEventListener("pointerdown", (event) => this.#drag(event, frame));
    this.#divider.addEventListener("keydown", (event) => this.#key(event));
  }

  set isOn(on) {
    const hadFocus = document.activeElement === this.#divider;
    this.#isOn = on;
    this.#area.hidden = !on;
    if (hadFocus && !on) byId("compare-button").focus({ preventScroll: true });
    this.#show();
  }

  /** Focus the divider, so that the arrow keys move it. */
  focus() {
    if (this.#isOn) this.#divider.focus({ preventScroll: true });
  }

  set isHeld(on) {
    if (on === this.#isHeld) return;
    this.#isHeld = on;
    this.#heldChip.hidden = !on;
    this.#picture.held = on;
    this.#show();
  }

  /** Ask again on a new connection, since the server has forgotten the request. */
  askAgain() {
    this.#asked = false;
    this.#show();
  }

  #show() {
    const wanted = this.#isOn || this.#isHeld;
    if (wanted !== this.#asked) this.#ask(wanted);
    this.#asked = wanted;
    this.#picture.split = this.#isOn ? this.#split : null;
    const percent = Math.round(100 * this.#split);
    this.#area.style.setProperty("--split", `${100 * this.#split}%`);
    this.#divider.setAttribute("aria-valuenow", percent);
    this.#divider.setAttribute("aria-valuetext", `${percent}% before`);
  }

  #moveTo(split) {
    this.#split = clamp(split, 0, 1);
    this.#show();
  }

  #drag(down, frame) {
    if (down.button !== 0) return;
    down.preventDefault();
    this.#divider.focus({ preventScroll: true });
    this.#area.setPointerCapture(down.pointerId);
    const follow = (event) => {
      const { left, width } = frame.getBoundingClientRect();
      this.#moveTo((event.clientX - left) / width);
    };
    const end = () => {
      this.#area.removeEventListener("pointermove", follow);
      this.#area.removeEventListener("lostpointercapture", end);
    };
    this.#area.addEventListener("pointermove", follow);
    this.#area.addEventListener("lostpointercapture", end);
    follow(down);
  }

  #key(event) {
    const by = {
      ArrowLeft: -STEP,
      ArrowDown: -STEP,
      ArrowRight: STEP,
      ArrowUp: STEP,
      PageDown: -PAGE,
      PageUp: PAGE,
    }[event.key];
    const to = { Home: 0, End: 1 }[event.key] ?? (by === undefined ? undefined : this.#split + by);
    if (to === undefined) return;
    event.preventDefault();
    this.#moveTo(to);
  }
}
