// H.264 with WebCodecs, for a page on another machine: a tenth to a quarter of the data of JPEG.

// Constrained baseline, up to 1080p30. A stream names its own profile and level.
const ASKED = { codec: "avc1.42C028", optimizeForLatency: true };
const SILENT_MS = 3000; // a decoder that returns nothing for this time has failed
const LOOPBACK = /^(localhost|127(\.\d+){3}|\[::1\])$/;
const JPEG_BECAUSE = "JPEG, which has four times the data of H.264: ";
const NO_HTTPS = `${JPEG_BECAUSE}browsers decode H.264 only in pages over HTTPS (--https)`;
const NO_DECODER = `${JPEG_BECAUSE}this browser cannot decode it for a page`;
export const FAILED = `${JPEG_BECAUSE}this browser's decoder failed`;

/**
 * Whether this page should show H.264: on another machine than the server's, if the browser decodes
 * it. Browsers decode H.264 only in pages over HTTPS and in pages of their own machine.
 * `?video=h264` or `?video=jpeg` in the page's address makes the choice instead. Resolves to
 * {isVideo, why}. why: the reason why H.264, which would be better, is not possible; "" otherwise.
 */
export async function choosePictures() {
  const chosen = new URLSearchParams(location.search).get("video");
  const isHere = LOOPBACK.test(location.hostname);
  if (chosen === "jpeg" || (chosen !== "h264" && isHere)) return { isVideo: false, why: "" };
  if (!window.isSecureContext) return { isVideo: false, why: NO_HTTPS };
  try {
    if ((await VideoDecoder.isConfigSupported(ASKED)).supported) return { isVideo: true, why: "" };
  } catch {
    // there is no WebCodecs, or the decoder refuses the question
  }
  return { isVideo: false, why: NO_DECODER };
}

/** The codec's name for WebCodecs, from the headers at the start of a key frame (Annex B). */
export function codecOf(data) {
  for (let at = 0; at + 6 < data.length; at++) {
    const isStart = data[at] === 0 && data[at + 1] === 0 && data[at + 2] === 1;
    if (!isStart || (data[at + 3] & 31) !== 7) continue; // 7: a sequence parameter set
    const profile = [data[at + 4], data[at + 5], data[at + 6]];
    return "avc1." + profile.map((byte) => byte.toString(16).padStart(2, "0")).join("");
  }
  throw new Error("a key frame without headers");
}

/**
 * Decodes the packets of one stream in order. onFail(error): called once, when decoding has failed.
 * A stream that has failed or was closed refuses all packets that are still on their way.
 */
export class VideoStream {
  #decoder = null;
  #codec = "";
  #waiting = new Map(); // by pts: {resolve, reject}
  #timer = 0;
  #isClosed = false;
  #onFail;

  constructor(onFail) {
    this.#onFail = onFail;
  }

  /** Decode a packet, {data, isKey}; resolves to its VideoFrame. */
  decode({ data, isKey }, pts) {
    return new Promise((resolve, reject) => {
      if (this.#isClosed) throw new Error("closed"); // rejects the promise
      this.#waiting.get(pts)?.reject(new Error("sent again"));
      this.#waiting.set(pts, { resolve, reject });
      try {
        if (isKey) this.#configure(codecOf(data));
        const type = isKey ? "key" : "delta";
        this.#decoder.decode(new EncodedVideoChunk({ type, timestamp: pts, data }));
        this.#timer ||= setTimeout(() => this.#fail(new Error("no picture")), SILENT_MS);
      } catch (error) {
        this.#fail(error);
      }
    });
  }

  close() {
    this.#isClosed = true;
    clearTimeout(this.#timer);
    this.#timer = 0;
    for (const { reject } of this.#waiting.values()) reject(new Error("closed"));
    this.#waiting.clear();
    if (this.#decoder !== null && this.#decoder.state !== "closed") this.#decoder.close();
  }

  #configure(codec) {
    if (codec === this.#codec) return; // the key frame itself tells the decoder a new size
    this.#decoder ??= new VideoDecoder({
      output: (frame) => this.#decoded(frame),
      error: (error) => this.#fail(error),
    });
    this.#decoder.configure({ ...ASKED, codec });
    this.#codec = codec;
  }

  #decoded(frame) {
    clearTimeout(this.#timer);
    this.#timer = 0;
    const one = this.#waiting.get(frame.timestamp);
    this.#waiting.delete(frame.timestamp);
    if (one === undefined) frame.close();
    else one.resolve(frame);
    if (this.#waiting.size > 0) {
      this.#timer = setTimeout(() => this.#fail(new Error("no picture")), SILENT_MS);
    }
  }

  #fail(error) {
    if (this.#isClosed) return;
    this.close();
    this.#onFail(error);
  }
}
