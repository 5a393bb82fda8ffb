// The canvas. Pictures are decoded off the main thread; the newest wins; each is acknowledged.

/** Draws pictures; acknowledge(pts): called once for every picture. */
export class Picture {
  #canvas;
  #context;
  #acknowledge;
  #next = null; // arrived while another one was being decoded
  #decoding = false;
  #shown = null; // {pts, rotation, painted, before}: bitmaps
  #drawAsked = null;
  #onScreen = Promise.resolve(); // resolves when the newest picture is on the screen
  #mirrored = false;
  #split = null; // place of the divider, 0 to 1 from the left; null: no divider
  #held = false;
  #view = { zoom: 1, x: 0.5, y: 0.5 };

  /** onSize(width, height): called when the size of the upright picture changes. */
  constructor(canvas, acknowledge, onSize) {
    this.#canvas = canvas;
    this.#context = canvas.getContext("2d", { alpha: false });
    this.#acknowledge = acknowledge;
    this.onSize = onSize;
  }

  get isShown() {
    return this.#shown !== null;
  }

  set mirrored(on) {
    this.#mirrored = on;
    this.#askToDraw();
  }

  /** The share of the width that shows the picture without makeup; null: none. */
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
    if (this.#next !== null) this.#acknowledge(this.#next.pts); // it will not be shown
    this.#next = picture;
    if (!this.#decoding) this.#decode();
  }

  async #decode() {
    this.#decoding = true;
    while (this.#next !== null) {
      const { pts, rotation, painted, before } = this.#next;
      this.#next = null;
      try {
        const jpegs = [painted, before];
        const bitmaps = await Promise.all(jpegs.map((jpeg) => jpeg && createImageBitmap(jpeg)));
        await this.#onScreen; // the last picture: decoding may overtake it, drawing must not
        this.#put({ pts, rotation, painted: bitmaps[0], before: bitmaps[1] });
      } catch {
        this.#acknowledge(pts); // it cannot be decoded; another one will come
      }
    }
    this.#decoding = false;
  }

  #put(shown) {
    this.#shown?.painted.close();
    this.#shown?.before?.close();
    this.#shown = shown;
    this.#onScreen = this.#askToDraw().then(() => this.#acknowledge(shown.pts));
  }

  /** Draw at the screen's next refresh. A hidden page draws and acknowledges nothing. */
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
    const [width, height] =
      rotation % 180 ? [painted.height, painted.width] : [painted.width, painted.height];
    if (this.#canvas.width !== width || this.#canvas.height !== height) {
      this.#canvas.width = width;
      this.#canvas.height = height;
      this.onSize(width, height);
    }
    this.#drawTurned(this.#held && before ? before : painted, rotation, 0, width);
    if (before && !this.#held && this.#split !== null) {
      this.#drawTurned(before, rotation, 0, Math.round(this.#split * width));
    }
    this.#canvas.dataset.pts = pts;
  }

  /** Draw a bitmap upright, and mirrored if chosen, between two columns of the canvas. */
  #drawTurned(bitmap, rotation, left, right) {
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
    context.rotate((-rotation * Math.PI) / 180); // canvas turns clockwise
    context.drawImage(bitmap, -bitmap.width / 2, -bitmap.height / 2);
    context.restore();
  }
}
