// The WebSocket: messages in and out, pictures in, and reconnecting.

import { addressOf } from "./ask.js";
import { isText, recall, remember } from "./remember.js";

const HEADER_BYTES = 20; // <QHHII: pts in us, rotation, flags, bytes painted, bytes before
const IS_VIDEO = 1; // a flag: both parts are H.264, not JPEG
const KEY = 2; // the painted part is a key frame
const KEY_BEFORE = 4; // the part without makeup is a key frame
const FIRST_PAUSE_MS = 400;
const LONGEST_PAUSE_MS = 5000;
// With a camera, figures come twice a second, but wait behind a picture that is being sent. On a
// slow network a picture takes long, so each loss in a row doubles the patience.
const SILENT_S = 5;
const LONGEST_SILENT_S = 40;
const OPENING_S = 10; // patience until the first message
// kept so that a reloaded page finds its portrait and look again
const SESSION = "session";
const SESSION_PLACE = "sessionStorage";

/**
 * Parse a picture: {pts, rotation, isVideo, painted, before}. painted and before are {data, isKey};
 * before may be null.
 */
export function parsePicture(buffer) {
  const header = new DataView(buffer, 0, HEADER_BYTES);
  const flags = header.getUint16(10, true);
  const paintedBytes = header.getUint32(12, true);
  const beforeBytes = header.getUint32(16, true);
  const part = (from, bytes, key) => ({
    data: new Uint8Array(buffer, from, bytes),
    isKey: (flags & key) !== 0,
  });
  return {
    pts: Number(header.getBigUint64(0, true)),
    rotation: header.getUint16(8, true),
    isVideo: (flags & IS_VIDEO) !== 0,
    painted: part(HEADER_BYTES, paintedBytes, KEY),
    before:
      beforeBytes > 0 ? part(HEADER_BYTES + paintedBytes, beforeBytes, KEY_BEFORE) : null,
  };
}

/**
 * A connection that is opened again when it is lost. `on` has a function for each type of message
 * (hello, look, figures, error, bye, ...), `picture` for pictures, and `lost(stopped)`, which is
 * called once whenever the connection is lost.
 */
export class Connection {
  #on;
  #socket = null;
  #pauseMs = FIRST_PAUSE_MS;
  #timer = 0;
  #stopped = false; // whether the server announced that it stops
  #isUp = false;
  #mode = ""; // live or demo
  #silentS = 0; // seconds without a message while the page ran; a laptop's sleep does not count
  #patienceS = SILENT_S; // the silence after which the connection counts as lost
  // the name of our last session, which the server may still have
  #session = recall(SESSION, (name) => (isText(name) ? name : ""), SESSION_PLACE);

  constructor(on) {
    this.#on = on;
    this.#open();
    // reconnect at once when the browser is online or visible again
    window.addEventListener("online", () => this.#hurry());
    document.addEventListener("visibilitychange", () => document.hidden || this.#hurry());
    setInterval(() => this.#watch(), 1000);
  }

  /** Whether the server has said hello on a connection that is not known to be lost. */
  get isUp() {
    return this.#isUp;
  }

  /**
   * Send a message; returns false, and does nothing, while the connection is lost. Until hello
   * arrives, the connection counts as lost: the look in hello would replace a look sent earlier.
   */
  send(message) {
    if (!this.#isUp || this.#socket?.readyState !== WebSocket.OPEN) return false;
    this.#socket.send(JSON.stringify(message));
    return true;
  }

  #open() {
    clearTimeout(this.#timer);
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const address = addressOf("/ws", this.#session);
    const socket = new WebSocket(`${scheme}://${location.host}${address}`);
    socket.binaryType = "arraybuffer";
    socket.onmessage = (event) => this.#receive(event.data);
    socket.onclose = () => this.#closed();
    this.#socket = socket;
    this.#silentS = 0;
  }

  #receive(data) {
    const silentS = this.#silentS;
    this.#silentS = 0;
    if (typeof data !== "string") {
      // a picture came right after another message, so the network is fast enough (again)
      if (silentS === 0) this.#patienceS = SILENT_S;
      this.#on.picture(parsePicture(data));
      return;
    }
    const message = JSON.parse(data);
    if (message.type === "hello") {
      this.#isUp = true;
      this.#session = message.session;
      this.#mode = message.mode;
      remember(SESSION, message.session, SESSION_PLACE);
      this.#stopped = false;
      this.#pauseMs = FIRST_PAUSE_MS;
    }
    if (message.type === "bye") this.#stopped = true;
    this.#on[message.type]?.(message);
  }

  #closed() {
    this.#socket = null;
    if (this.#isUp) this.#on.lost(this.#stopped);
    this.#isUp = false;
    this.#timer = setTimeout(() => this.#open(), this.#pauseMs);
    this.#pauseMs = Math.min(2 * this.#pauseMs, LONGEST_PAUSE_MS);
  }

  /** Give up a connection whose other end was lost without closing it. A demo may be silent. */
  #watch() {
    if (this.#socket === null || (this.#isUp && this.#mode !== "live")) return;
    this.#silentS += 1;
    if (this.#silentS <= (this.#isUp ? this.#patienceS : OPENING_S)) return;
    if (this.#isUp) this.#patienceS = Math.min(2 * this.#patienceS, LONGEST_SILENT_S);
    // the browser would wait for the other end before it calls onclose
    this.#socket.onmessage = this.#socket.onclose = null;
    this.#socket.close();
    this.#closed();
  }

  #hurry() {
    if (this.#socket === null) this.#open();
  }
}
