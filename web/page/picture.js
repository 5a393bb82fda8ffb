// The canvas. Pictures are decoded off the main thread. Only the newest is drawn, but each one is
// acknowledged.

import { VideoStream } from "./video.js";
import { WHOLE } from "./zoom.js";

const widthOf = (image) => image.displayWidth ?? image.width; // a VideoFrame or an ImageBitmap
const heightOf = (image) => image.displayHeight ?? image.height;

/** Decode the JPEGs of a picture: [painted, before] as bitmaps; before may be null. */
function decodeJpegs({ painted, before }) {
  const bitmap = ({ data }) => createImageBitmap(new Blob([data], { type: "image/jpeg" }));
  return Promise.all([bitmap(painted), before && bitmap(before)]);
}

/**
 * Draws pictures. acknowledge(pts): called once for every picture. The canvas has the attribute
 * `data-before` while its picture has also come without makeup.
 */
export class Picture {
  #canvas;
  #context;
  #acknowledge;
  #next = null; // the picture that arrived while another one was being decoded
  #decoding = false;
  #shown = null; // {pts, rotation, painted, before}: bitmaps, or frames of a video
  #drawAsked = null;
  #onScreen = Promise.resolve(); // resolves when the newest picture is on the screen
  #mirrored = false;
  #split = null; // place of the divider, 0 to 1 from the left; null: no divider
  #held = false;
  #view = WHOLE;

  #onSize;
  #painted; // streams of H.264
  #before;

  /**
   * onSize(width, height): called when the size of the upright picture changes.
   * onVideoFail(): called when H.264 cannot be decoded any longer.
   */
  constructor(canvas, acknowledge, onSize, onVideoFail) {
    this.#canvas = canvas;
    this.#context = canvas.getContext("2d", { alpha: false });
    this.#acknowledge = acknowledge;
    this.#onSize = onSize;
    const fail = () => {
      this.#painted.close();
      this.#before.close();
      onVideoFail();
    };
    this.#painted = new VideoStream(fail);
    this.#before = new VideoStream(fail);
  }

  get isShown() {
    return this.#shown !== null;
  }

  set mirrored(on) {
    this.#mirrored = on;
    this.#askToDraw();
  }

  /** The share of the width, from the left, that shows the picture without makeup; null: none. */
  set split(part) {
    this.#split = part;
    this.#askToDraw();
  }

  /** Show only the picture without makeup, while a key is held. */
  set held(on) {
    this.#held = on;
    this.#askToDraw();
  }

  /** The part to show: {zoom, x, y}, where x and y are its middle, as shares of the picture. */
  set view(view) {
    this.#view = view;
    this.#askToDraw();
  }

  show(picture) {
    if (this.#next !== null) this.#leaveOut(this.#next);
    this.#next = picture;
    // every packet must be decoded, even one whose picture is not shown
    if (picture.isVideo) picture.images = this.#decodeVideo(picture);
    if (!this.#decoding) this.#decode();
  }

  #leaveOut({ pts, images }) {
    // not before the newest is on the screen: else a hidden page would be sent every picture
    this.#onScreen.then(() => this.#acknowledge(pts));
    images?.then((made) => made.forEach((image) => image?.close()));
  }

  /** Returns [painted, before], each a VideoFrame or null; [] when they cannot be decoded. */
  async #decodeVideo({ pts, painted, before }) {
    const streams = [this.#painted.decode(painted, pts)];
    if (before !== null) streams.push(this.#before.decode(before, pts));
    const done = await Promise.allSettled(streams);
    if (done.every(({ status }) => status === "fulfilled")) return done.map(({ value }) => value);
    done.forEach(({ value }) => value?.close());
    return [];
  }

  async #decode() {
    this.#decoding = true;
    while (this.#next !== null) {
      const next = this.#next;
      this.#next = null;
      const [painted, before = null] = await (next.images ?? decodeJpegs(next).catch(() => []));
      if (painted === undefined) {
        this.#acknowledge(next.pts); // the picture cannot be decoded, but another one will come
        continue;
      }
      await this.#onScreen; // decoding may overtake the last picture, but drawing must not
      this.#canvas.dataset.codec = next.isVideo ? "h264" : "jpeg";
      this.#put({ pts: next.pts, rotation: next.rotation, painted, before });
    }
    this.#decoding = false;
  }

  #put(shown) {
    this.#shown?.painted.close();
    this.#shown?.before?.close();
    this.#shown = shown;
    this.#onScreen = this.#askToDraw().then(() => this.#acknowledge(shown.pts));
  }

  /** Draw at the screen's next refresh. A hidden page draws nothing, so it acknowledges nothing. */
  #askToDraw() {
    this.#drawAsked ||= new Promise((resolve) =>
      requestAnimationFrame(() => {
        this.#drawAsked = null;
        if (this.#shown !== null) this.#draw();
        resolve();
      }),
    );
    return this.#drawAsked;
  }

  #draw() {
    const { pts, rotation, painted, before } = this.#shown;
    const size = [widthOf(painted), heightOf(painted)];
    const [width, height] = rotation % 180 ? size.reverse() : size;
    if (this.#canvas.width !== width || this.#canvas.height !== height) {
      this.#canvas.width = width;
      this.#canvas.height = height;
      this.#onSize(width, height);
    }
    this.#drawTurned(this.#held && before ? before : painted, rotation, 0, width);
    if (before && !this.#held && this.#split !== null) {
      this.#drawTurned(before, rotation, 0, Math.round(this.#split * width));
    }
    this.#canvas.toggleAttribute("data-before", before !== null);
    this.#canvas.dataset.pts = pts;
  }

  /** Draw an image upright, and mirrored if chosen, between two columns of the canvas. */
  #drawTurned(image, rotation, left, right) {
    const { width, height } = this.#canvas;
    const context = this.#context;
    context.save();
    context.beginPath();
    context.rect(left, 0, right - left, height);
    context.clip();
    context.translate(width / 2, height / 2);
    context.scale(this.#view.zoom, this.#view.zoom);
    context.translate((0.5 - this.#view.x) * width, (0.5 - this.#view.y) * height);
    if (this.#mirrored) context.scale(-1, 1);
    context.rotate((-rotation * Math.PI) / 180); // a canvas turns clockwise
    context.drawImage(image, -widthOf(image) / 2, -heightOf(image) / 2);
    context.restore();
  }
}
