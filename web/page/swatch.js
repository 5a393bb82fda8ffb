// Swatches: a stroke of the product on skin, lit from above, which shows its finish.

const UNDER = [0.5, 0.3, 0.23]; // linear light of the skin below
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

/** A pseudo-random number in [0, 1), always the same for a cell. */
function noise(x, y) {
  let h = (x * 374761393 + y * 668265263) | 0;
  h = Math.imul(h ^ (h >>> 13), 1274126177);
  return ((h ^ (h >>> 16)) >>> 0) / 4294967296;
}

/** Normals (x, y) of a stroke that fills width x height, cached by size. */
function strokeShape(width, height) {
  const key = `${width}x${height}`;
  if (shapes.has(key)) return shapes.get(key);
  const shape = { nx: new Float32Array(width * height), ny: new Float32Array(width * height) };
  for (let y = 0, at = 0; y < height; y++) {
    const v = (2 * (y + 0.5)) / height - 1;
    for (let x = 0; x < width; x++, at++) {
      const u = (2 * (x + 0.5)) / width - 1;
      const bristles =
        0.1 * Math.sin(9 * v + 1.2 * Math.sin(2.4 * u)) + 0.05 * Math.sin(23 * v + 2 * u);
      shape.nx[at] = 0.3 * u ** 5 + 0.06 * Math.sin(5 * u + 2 * v);
      shape.ny[at] = 0.85 * v * Math.abs(v) ** 0.6 + bristles;
    }
  }
  shapes.set(key, shape);
  return shape;
}

/** The part of the optics that depends on the product alone. */
function optics(params) {
  const roughness = 0.08 + 0.5 * params.gloss_roughness;
  return {
    width2: 0.5 * roughness * roughness, // highlights must not wash the colour out
    shine: (0.2 * params.gloss ** 1.3) / (1 + 0.25 * params.gloss) / (0.4 + 2.2 * roughness),
    room: params.reflection,
    soft: 0.06 + 0.5 * params.environment_blur,
    share: 0.13 * params.shimmer,
    cell: Math.max(1, Math.round(1 + 2.5 * params.shimmer_size)),
    tint: params.shimmer_tint,
  };
}

/** Light of one point: [brightness of the colour, white light added, light of a sparkle]. */
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

/** Fill the canvas with a stroke of the product (the 17 parameters of a region). */
export function drawSwatch(canvas, params) {
  const { width, height } = canvas;
  const { nx, ny } = strokeShape(width, height);
  const colour = [params.red, params.green, params.blue].map(toLinear);
  const o = optics(params);
  const context = canvas.getContext("2d");
  const image = context.createImageData(width, height);
  for (let y = 0, at = 0; y < height; y++) {
    for (let x = 0; x < width; x++, at++) {
      const [bright, white, sparkle] = lit(nx[at], ny[at], x, y, o);
      for (let c = 0; c < 3; c++) {
        const body = params.opacity * colour[c] + (1 - params.opacity) * UNDER[c];
        const dust = sparkle * (o.tint * (0.15 + 1.6 * colour[c]) + (1 - o.tint) * 0.8);
        const light = body * bright + white + dust;
        image.data[4 * at + c] = toByte[Math.min(4095, (4095 * light) | 0)];
      }
      image.data[4 * at + 3] = 255;
    }
  }
  context.putImageData(image, 0, 0);
}
