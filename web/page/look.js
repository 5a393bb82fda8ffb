// The current look: changed by hand, by photos and by other pages; sent, undone, saved.

const SETTLED_AFTER_MS = 500; // changes closer together are one step of undo
const STEPS = 100;
const CODE_VALUES = ["red", "green", "blue"]; // whole numbers; all others get a decimal point

/** A text that is equal for equal values, whatever the order of their keys. */
function canonical(value) {
  if (value === null || typeof value !== "object") return JSON.stringify(value);
  const keys = Object.keys(value).sort();
  return `{${keys.map((key) => `${key}:${canonical(value[key])}`).join()}}`;
}

export const sameLook = (one, other) => canonical(one) === canonical(other);

/** The text of a look file, as `Look.save` writes it. */
export function lookFile(look) {
  const text = JSON.stringify(look, null, 2);
  const written = text.replace(/"(\w+)": (-?\d+)(?=[,\n])/g, (whole, key) =>
    key === "version" || CODE_VALUES.includes(key) ? whole : `${whole}.0`,
  );
  return `${written}\n`;
}

/** Fires "change" whenever `look` changes. Its objects are never changed in place. */
export class LookStore extends EventTarget {
  look = null;
  photoLook = null; // the look that was last read from a photo
  #send;
  #sendScheduled = false;
  isUnsent = false; // the last look was not sent, since the connection was lost
  #count = 0; // of our own looks on this connection, with the one about to be sent
  #past = [];
  #future = [];
  #settled = true;
  #settleTimer = 0;

  /** send(look, n): called at most once per refresh of the screen; returns whether it was sent. */
  constructor(send) {
    super();
    this.#send = send;
  }

  get canUndo() {
    return this.#past.length > 0;
  }

  get canRedo() {
    return this.#future.length > 0;
  }

  get isPhotoLook() {
    return this.photoLook === null || sameLook(this.photoLook, this.look);
  }

  /** Take the first look of a connection, and the look that was last read from a photo. */
  start(look, photoLook) {
    this.photoLook = photoLook;
    this.#count = 0;
    this.#sendScheduled = this.isUnsent = false;
    this.#adopt(look);
  }

  /** Change the look by hand: `change` alters a copy. */
  edit(change) {
    const look = structuredClone(this.look);
    change(look);
    if (sameLook(look, this.look)) return;
    if (this.#settled) this.#remember();
    this.#settled = false;
    clearTimeout(this.#settleTimer);
    this.#settleTimer = setTimeout(() => (this.#settled = true), SETTLED_AFTER_MS);
    this.#put(look);
  }

  /** Change the look by hand in one step of undo, however soon after the last one. */
  step(change) {
    const look = structuredClone(this.look);
    change(look);
    this.replace(look);
  }

  /** Replace the look, as one step of undo. */
  replace(look) {
    if (sameLook(look, this.look)) return;
    this.#remember();
    this.#settled = true;
    this.#put(structuredClone(look));
  }

  /**
   * Take a look from the server. photoLook: set when it has just been read from a photo.
   * seen: how many of our looks the server had by then; newer ones win over this look.
   */
  receive(look, photoLook, seen) {
    if (photoLook) this.photoLook = photoLook;
    if (this.#count <= (seen ?? 0)) this.#adopt(look);
  }

  undo() {
    if (this.canUndo) this.#step(this.#past, this.#future);
  }

  redo() {
    if (this.canRedo) this.#step(this.#future, this.#past);
  }

  #step(from, to) {
    to.push(this.look);
    this.#settled = true;
    this.#put(from.pop());
  }

  #remember() {
    this.#past.push(this.look);
    if (this.#past.length > STEPS) this.#past.shift();
    this.#future = [];
  }

  #adopt(look) {
    if (this.look !== null) {
      if (sameLook(look, this.look)) {
        this.dispatchEvent(new Event("change")); // photoLook may have changed
        return;
      }
      if (this.#settled) this.#remember();
    }
    this.#show(look);
  }

  #put(look) {
    this.#show(look);
    if (this.#sendScheduled) return;
    this.#sendScheduled = true;
    this.#count += 1;
    requestAnimationFrame(() => {
      if (!this.#sendScheduled) return; // a new connection has started meanwhile
      this.#sendScheduled = false;
      this.isUnsent = !this.#send(this.look, this.#count);
    });
  }

  #show(look) {
    this.look = look;
    this.dispatchEvent(new Event("change"));
  }
}
