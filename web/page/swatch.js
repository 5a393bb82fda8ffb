// Swatches: a product on skin, lit from above. They show the finish and how the product is worn.

import { clamp } from "./elements.js";

const UNDER = [0.5, 0.3, 0.23]; // linear light of the skin below the product: red, green, blue
const LIGHT = unit([-0.35, -0.7, 0.75]);
const HALF = unit([LIGHT[0], LIGHT[1], LIGHT[2] + 1]); // between the light and the eye
const shapes = new Map();
const toByte = Uint8Array.from({ length: 4096 }, (_, i) => {
  const linear = i / 4095;
  return 255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055) + 0.5;
});

function unit(v) {
  const length = Math.hypot(...v);
  return v.map((part) => part / length);
}

function toLinear(code) {
  const encoded = code / 255;
  return encoded <= 0.04045 ? encoded / 12.92 : ((encoded + 0.055) / 1.055) ** 2.4;
}

/** A pseudo-random number in [0, 1), always the same for the same cell. */
function noise(x, y) {
  let h = (x * 374761393 + y * 668265263) | 0;
  h = Math.imul(h ^ (h >>> 13), 1274126177);
  return ((h ^ (h >>> 16)) >>> 0) / 4294967296;
}

const smooth = (x) => {
  const inside = clamp(x, 0, 1);
  return inside * inside * (3 - 2 * inside);
};

// Each form below returns its cover and normal at a place: u to the right, v down, in [-1, 1].

/** A film that fills the canvas, with the marks of a brush. */
function stroke(u, v) {
  const bristles =
    0.1 * Math.sin(9 * v + 1.2 * Math.sin(2.4 * u)) + 0.05 * Math.sin(23 * v + 2 * u);
  return {
    cover: 1,
    nx: 0.3 * u ** 5 + 0.06 * Math.sin(5 * u + 2 * v),
    ny: 0.85 * v * Math.abs(v) ** 0.6 + bristles,
  };
}

/** A swipe of powder: grain, and edges that thin out to the right. */
function powder(u, v, x, y) {
  const edge = 1 - Math.abs(v + 0.06 * Math.sin(4 * u + 1)) ** 2.6;
  const ends = Math.min((u + 1.02) / 0.16, (1.05 - u) / 0.7);
  const grain = noise(x, y) - 0.5;
  return {
    cover: smooth(1.9 * edge + 0.22 * grain) * smooth(ends + 0.3 * grain) * (0.94 + 0.12 * grain),
    nx: 0.34 * grain,
    ny: 0.34 * (noise(y + 31, x) - 0.5),
  };
}

/** A soft round flush that fades in all directions. */
function flush(u, v) {
  const away = Math.hypot(0.9 * u, 0.9 * v);
  return { cover: smooth(1.25 * (1 - away)), nx: 0.45 * u, ny: 0.45 * v };
}

const CORNER = 0.74; // share of the line's length after which it leaves the lashes as a wing

/** A line that grows along the bow of the lashes and ends in a wing. */
function line(u, v, x, y, pixel) {
  const along = (u + 0.84) / 1.68;
  const lashes = Math.min(along, CORNER) / CORNER;
  const wing = Math.max(0, along - CORNER) / (1 - CORNER);
  const middle = 0.62 - 0.78 * Math.sin(Math.PI * (0.1 + 0.66 * lashes)) - 0.72 * wing;
  const half = (0.05 + 0.17 * lashes) * (1 - wing);
  const at = v - middle;
  const isOn = along > 0 && along < 1;
  const cover = isOn ? clamp((half - Math.abs(at)) / pixel + 0.5, 0, 1) : 0;
  return { cover, nx: 0, ny: cover > 0 ? 0.75 * clamp(at / half, -1, 1) : 0 };
}

const FORMS = { stroke, powder, flush, line };

/** Cover and normals (x, y) of a form that fills width x height, cached. */
function shapeOf(form, width, height) {
  const key = `${form} ${width}x${height}`;
  if (shapes.has(key)) return shapes.get(key);
  const [cover, nx, ny] = [0, 1, 2].map(() => new Float32Array(width * height));
  for (let y = 0, at = 0; y < height; y++) {
    const v = (2 * (y + 0.5)) / height - 1;
    for (let x = 0; x < width; x++, at++) {
      const place = FORMS[form]((2 * (x + 0.5)) / width - 1, v, x, y, 2 / height);
      cover[at] = place.cover;
      nx[at] = place.nx;
      ny[at] = place.ny;
    }
  }
  shapes.set(key, { cover, nx, ny });
  return shapes.get(key);
}

/** The part of the optics that depends only on the product. */
function optics(params) {
  const roughness = 0.08 + 0.5 * params.gloss_roughness;
  return {
    width2: 0.5 * roughness * roughness, // narrow, so that highlights do not wash the colour out
    shine: (0.2 * params.gloss ** 1.3) / (1 + 0.25 * params.gloss) / (0.4 + 2.2 * roughness),
    room: params.reflection,
    soft: 0.06 + 0.5 * params.environment_blur,
    share: 0.13 * params.shimmer,
    cell: Math.max(1, Math.round(1 + 2.5 * params.shimmer_size)),
    tint: params.shimmer_tint,
  };
}

/** The light of one point: [brightness of the colour, added white light, light of a sparkle]. */
function lit(nx, ny, x, y, o) {
  const nz = Math.sqrt(Math.max(0.05, 1 - nx * nx - ny * ny));
  const facing = Math.max(0, nx * LIGHT[0] + ny * LIGHT[1] + nz * LIGHT[2]);
  const offHalf = 1 - Math.min(1, nx * HALF[0] + ny * HALF[1] + nz * HALF[2]);
  const glint = o.shine * Math.exp((-2 * offHalf) / o.width2);
  // the bright upper half of a room
  const mirrored = 1 / (1 + Math.exp((ny + 0.3) / (0.35 * o.soft)));
  let sparkle = 0;
  if (o.share > 0) {
    const cx = Math.floor(x / o.cell);
    const cy = Math.floor(y / o.cell);
    if (noise(cx, cy) < o.share) sparkle = (0.25 + noise(cy, cx + 7)) * (0.35 + facing);
  }
  return [0.45 + 0.65 * facing, glint + 0.12 * o.room * mirrored, sparkle];
}

/** Draw one product into the columns left..right of an image. */
function drawProduct({ data, width, height }, form, product, left, right) {
  const { cover, nx, ny } = shapeOf(form, right - left, height);
  const colour = [product.red, product.green, product.blue].map(toLinear);
  const o = optics(product);
  for (let y = 0, at = 0; y < height; y++) {
    for (let x = left; x < right; x++, at++) {
      const share = cover[at];
      const [bright, white, sparkle] = lit(share * nx[at], share * ny[at], x, y, o);
      const to = 4 * (y * width + x);
      for (let c = 0; c < 3; c++) {
        const body = UNDER[c] + share * product.opacity * (colour[c] - UNDER[c]);
        const dust = sparkle * (o.tint * (0.15 + 1.6 * colour[c]) + (1 - o.tint) * 0.8);
        const light = body * bright + share * (white + dust);
        data[to + c] = toByte[Math.min(4095, (4095 * light) | 0)];
      }
      data[to + 3] = 255;
    }
  }
}

/**
 * Draw products (17 parameters each) side by side on skin.
 * form: how the products are worn: "stroke", "powder", "flush" or "line".
 */
export function drawSwatch(canvas, form, products) {
  const { width, height } = canvas;
  const context = canvas.getContext("2d");
  const image = context.createImageData(width, height);
  products.forEach((product, number) => {
    const [left, right] = [number, number + 1].map((at) =>
      Math.round((at * width) / products.length),
    );
    drawProduct(image, form, product, left, right);
  });
  context.putImageData(image, 0, 0);
}
