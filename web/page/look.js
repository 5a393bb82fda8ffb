// The current look, which the visitor, photos and other pages change; sending, undo, the file.

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

const texts = new WeakMap(); // by look and by part of a look, which are never changed in place

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

/** The name of a look that comes from a file. */
export const nameAfter = (fileName) => fileName.replace(/\.[^.]*$/, "") || fileName;

/** The text of a look file, as `Look.save` writes it. */
export function lookFile(look) {
  const text = JSON.stringify(look, null, 2);
  const written = text.replace(/"(\w+)": (-?\d+)(?=[,\n])/g, (whole, key) =>
    key === "version" || CODE_VALUES.includes(key) ? whole : `${whole}.0`,
  );
  return `${written}\n`;
}

/** Fires "change" for each new look or name. The objects of `look` are never changed in place. */
export class LookStore extends EventTarget {
  look = null;
  #photo = null; // {name, look}: the photo whose look was last read
  #send;
  #sendScheduled = false;
  #count = 0; // of our own looks on this connection, including the look about to be sent
  #seen = 0; // how many of these looks the server has confirmed
  #name = "look";
  #awaited = null; // {file, look}: the look of a file that was sent; the server will return it
  #past = []; // {look, name}; name is null if the change after this look left the name alone
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

  /** Name the look; undo does not count this as a step. */
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

  get photo() {
    return this.#photo;
  }

  get photoLook() {
    return this.#photo?.look ?? null;
  }

  get isPhotoLook() {
    return this.photoLook === null || sameLook(this.photoLook, this.look);
  }

  /** Whether the server may lack our last look: even a look that was sent may be lost. */
  get isUnconfirmed() {
    return this.#count > this.#seen;
  }

  /** Note how many of our looks the server has. */
  confirm(seen) {
    this.#seen = seen ?? 0;
  }

  /** Take the first look of a connection, and the photo whose look was last read, if any. */
  start(look, photo) {
    this.#photo = photo;
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

  /** Change the look by hand as a step of undo of its own, however soon after the last one. */
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

  /** Wear the photo's look again, under the photo's name. */
  backToPhoto() {
    if (!this.isPhotoLook) this.replace(this.photoLook, nameAfter(this.#photo.name));
  }

  /** Note that the look of a file was sent. The look that the server returns is named after it. */
  expect(file, look) {
    this.#awaited = { file, look };
  }

  /** The look of a file that was sent and not answered yet, as {file, look}, or null. */
  get awaited() {
    return this.#awaited;
  }

  /** Stop waiting for the look of a file; returns the name of the file, or "". */
  giveUpFile() {
    const file = this.#awaited?.file ?? "";
    this.#awaited = null;
    return file;
  }

  /**
   * Take a look from the server. photo: {name, look}, if the look has just been read from a photo.
   * seen: how many of our looks the server had received by then; newer ones win over this look.
   */
  receive(look, photo, seen) {
    if (photo) this.#photo = photo;
    this.confirm(seen);
    if (this.isUnconfirmed) {
      if (photo) this.#show(this.look); // the page can now return to the photo's look
      return;
    }
    this.#adopt(look, photo ? nameAfter(photo.name) : this.#nameFor(look));
  }

  /** The name for a look from the server that was not read from a photo. */
  #nameFor(look) {
    // When the server refuses a file, it sends the look that is worn, too.
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

  /** Remember the look before a change. name: the name of the look after the change. */
  #remember(name) {
    this.#past.push({ look: this.look, name: name === this.#name ? null : this.#name });
    if (this.#past.length > STEPS) this.#past.shift();
    this.#future = [];
  }

  #adopt(look, name) {
    const isNew = this.look !== null && !sameLook(look, this.look);
    if (isNew && (this.#settled || name !== this.#name)) this.#remember(name);
    this.#name = name;
    this.#show(look); // even for the same look, since photoLook may have changed
  }

  #put(look) {
    this.#awaited = null; // the server receives our look after the file's look
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
