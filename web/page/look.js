// The look that is worn: changed by hand, by photos and by other pages; sent, undone, written out.

const SETTLED_AFTER_MS = 500; // changes closer than this are one step for undo
const STEPS = 100;
const CODE_VALUES = ["red", "green", "blue"]; // whole numbers; all others have a point

/** Equal numbers give equal texts, in whatever order the keys came. */
function canonical(value) {
  if (value === null || typeof value !== "object") return JSON.stringify(value);
  const keys = Object.keys(value).sort();
  return keys.map((key) => `${key}:${canonical(value[key])}`).join();
}

/** The text of a look file, as `Look.save` writes it. */
export function lookFile(look) {
  const text = JSON.stringify(look, null, 2);
  const written = text.replace(/"(\w+)": (-?\d+)(?=[,\n])/g, (whole, key) =>
    key === "version" || CODE_VALUES.includes(key) ? whole : `${whole}.0`,
  );
  return `${written}\n`;
}

/** Fires "change" whenever `look` is another one. Its objects are never changed in place. */
export class LookStore extends EventTarget {
  look = null;
  photoLook = null; // what was last read from a photo
  #send;
  #sendAsked = false;
  #count = 0; // of our own looks on this connection, the one about to be sent included
  #past = [];
  #future = [];
  #settled = true;
  #settleTimer = 0;

  /** send(look, n): called at most once per refresh of the screen. */
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
    return this.photoLook === null || canonical(this.photoLook) === canonical(this.look);
  }

  /** The first look of a connection, and what was last read from a photo. */
  start(look, photoLook) {
    this.photoLook = photoLook;
    this.#count = 0;
    this.#sendAsked = false;
    this.#adopt(look);
  }

  /** A change by hand: `change` gets a copy and alters it. */
  edit(change) {
    const look = structuredClone(this.look);
    change(look);
    if (canonical(look) === canonical(this.look)) return;
    if (this.#settled) this.#remember();
    this.#settled = false;
    clearTimeout(this.#settleTimer);
    this.#settleTimer = setTimeout(() => (this.#settled = true), SETTLED_AFTER_MS);
    this.#put(look);
  }

  /** Another look altogether, one step for undo. */
  replace(look) {
    if (canonical(look) === canonical(this.look)) return;
    this.#remember();
    this.#settled = true;
    this.#put(structuredClone(look));
  }

  /**
   * A look from the server. photoLook: if it has just been read from a photo.
   * seen: how many of ours it had by then; newer ones win over it.
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
      if (canonical(look) === canonical(this.look)) {
        this.dispatchEvent(new Event("change")); // what the photo's look is may have changed
        return;
      }
      if (this.#settled) this.#remember();
    }
    this.#show(look);
  }

  #put(look) {
    this.#show(look);
    if (this.#sendAsked) return;
    this.#sendAsked = true;
    this.#count += 1;
    requestAnimationFrame(() => {
      if (!this.#sendAsked) return; // the connection went meanwhile
      this.#sendAsked = false;
      this.#send(this.look, this.#count);
    });
  }

  #show(look) {
    this.look = look;
    this.dispatchEvent(new Event("change"));
  }
}
