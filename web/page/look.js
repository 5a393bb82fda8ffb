// The current look: changed by hand, by photos and by other pages; sent, undone, saved.

import { isObject, isText } from "./remember.js";

const SETTLED_AFTER_MS = 500; // changes closer together are one step of undo
const STEPS = 100;
const CODE_VALUES = ["red", "green", "blue"]; // whole numbers; all others get a decimal point

/** A text that is equal for equal values, whatever the order of their keys. */
function canonical(value) {
  if (value === null || typeof value !== "object") return JSON.stringify(value);
  const keys = Object.keys(value).sort();
  return `{${keys.map((key) => `${key}:${canonical(value[key])}`).join()}}`;
}

const texts = new WeakMap(); // by look, and by parts of looks: none is changed in place

function textOf(value) {
  if (!isObject(value)) return canonical(value);
  if (!texts.has(value)) texts.set(value, canonical(value));
  return texts.get(value);
}

export const sameLook = (one, other) => textOf(one) === textOf(other);

/** Whether a value has the parts of a look that the page relies on. */
export function isLook(value) {
  const isLayer = (layer) =>
    isObject(layer) &&
    isText(layer.kind) &&
    Number.isFinite(layer.strength) &&
    isObject(layer.shape) &&
    isObject(layer.product) &&
    CODE_VALUES.every((code) => Number.isFinite(layer.product[code]));
  return (
    isObject(value) &&
    Number.isFinite(value.strength) &&
    Array.isArray(value.layers) &&
    value.layers.every(isLayer)
  );
}

/** What the look of a file is called. */
export const nameAfter = (fileName) => fileName.replace(/\.[^.]*$/, "") || fileName;

/** The text of a look file, as `Look.save` writes it. */
export function lookFile(look) {
  const text = JSON.stringify(look, null, 2);
  const written = text.replace(/"(\w+)": (-?\d+)(?=[,\n])/g, (whole, key) =>
    key === "version" || CODE_VALUES.includes(key) ? whole : `${whole}.0`,
  );
  return `${written}\n`;
}

/** Fires "change" with each `look` or `name`. The objects of `look` are never changed in place. */
export class LookStore extends EventTarget {
  look = null;
  photoLook = null; // the look that was last read from a photo
  #send;
  #sendScheduled = false;
  #count = 0; // of our own looks on this connection, with the one about to be sent
  #seen = 0; // how many of these the server has confirmed
  #name = "look";
  #awaited = null; // {file, look}: of a file, sent to the server, which returns the whole look
  #past = []; // {look, name}; name: null where the change after it left the name alone
  #future = [];
  #settled = true;
  #settleTimer = 0;

  /** send(look, n): called at most once per refresh of the screen. */
  constructor(send) {
    super();
    this.#send = send;
  }

  get name() {
    return this.#name;
  }

  /** Name the look; this is no step of undo. */
  set name(name) {
    this.#name = name;
    this.dispatchEvent(new Event("change"));
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

  /** Whether the server may lack our last look, which may be lost even after it was sent. */
  get isUnconfirmed() {
    return this.#count > this.#seen;
  }

  /** Note how many of our looks the server has. */
  confirm(seen) {
    this.#seen = seen ?? 0;
  }

  /** Take the first look of a connection, and the look that was last read from a photo. */
  start(look, photoLook) {
    this.photoLook = photoLook;
    this.#count = this.#seen = 0;
    this.#sendScheduled = false;
    this.#awaited = null;
    this.#adopt(look, this.#name);
  }

  /** Send our own look to a server that does not have it. */
  sendAgain() {
    this.#put(this.look);
  }

  /** Change the look by hand: `change` alters a copy. */
  edit(change) {
    const look = structuredClone(this.look);
    change(look);
    if (sameLook(look, this.look)) return;
    if (this.#settled) this.#remember(this.#name);
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

  /** Replace the look and its name, as one step of undo. */
  replace(look, name = this.#name) {
    if (sameLook(look, this.look)) {
      this.name = name;
      return;
    }
    this.#remember(name);
    this.#settled = true;
    this.#name = name;
    this.#put(structuredClone(look));
  }

  /** Note that the look of a file was sent: the look that the server returns is named after it. */
  expect(file, look) {
    this.#awaited = { file, look };
  }

  /** Expect no file's look any longer; returns the name of the file, or "". */
  giveUpFile() {
    const file = this.#awaited?.file ?? "";
    this.#awaited = null;
    return file;
  }

  /**
   * Take a look from the server. photo: {name, look}, when it has just been read from a photo.
   * seen: how many of our looks the server had by then; newer ones win over this look.
   */
  receive(look, photo, seen) {
    if (photo) this.photoLook = photo.look;
    this.confirm(seen);
    if (this.isUnconfirmed) {
      if (photo) this.#show(this.look); // the page can now return to the photo's look
      return;
    }
    this.#adopt(look, photo ? nameAfter(photo.name) : this.#nameFor(look));
  }

  /** The name of a look from the server that comes from no photo. */
  #nameFor(look) {
    // with the error about a file, the server sends the look that is worn
    const isWorn = sameLook(look, this.look);
    const { look: sent } = this.#awaited ?? {};
    if (!sent || (isWorn && !sameLook(look, sent))) return this.#name;
    return nameAfter(this.giveUpFile());
  }

  undo() {
    if (this.canUndo) this.#step(this.#past, this.#future);
  }

  redo() {
    if (this.canRedo) this.#step(this.#future, this.#past);
  }

  #step(from, to) {
    const { look, name } = from.pop();
    to.push({ look: this.look, name: name === null ? null : this.#name });
    this.#name = name ?? this.#name;
    this.#settled = true;
    this.#put(look);
  }

  /** Remember the look before a change. name: that of the look after it. */
  #remember(name) {
    this.#past.push({ look: this.look, name: name === this.#name ? null : this.#name });
    if (this.#past.length > STEPS) this.#past.shift();
    this.#future = [];
  }

  #adopt(look, name) {
    const isNew = this.look !== null && !sameLook(look, this.look);
    if (isNew && (this.#settled || name !== this.#name)) this.#remember(name);
    this.#name = name;
    this.#show(look); // even the same one: photoLook may have changed
  }

  #put(look) {
    this.#awaited = null; // the server receives our look after that of the file
    this.#show(look);
    if (this.#sendScheduled) return;
    this.#sendScheduled = true;
    this.#count += 1;
    requestAnimationFrame(() => {
      if (!this.#sendScheduled) return; // a new connection has started meanwhile
      this.#sendScheduled = false;
      this.#send(this.look, this.#count);
    });
  }

  #show(look) {
    this.look = look;
    this.dispatchEvent(new Event("change"));
  }
}
