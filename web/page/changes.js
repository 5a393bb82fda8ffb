// Says in words what has been changed since a look was read from a photo.

import { layersOf } from "./layers.js";
import { sameLook } from "./look.js";

const COLOURS = ["red", "green", "blue"];

/** "lips: colour; blush: taken off; strength", or "" when nothing has been changed. */
export function changesSince(before, now, kinds) {
  const parts = kinds.map((kind) => {
    const words = changesOf(layersOf(before, kind), layersOf(now, kind));
    return words.length ? `${kind.title.toLowerCase()}: ${words.join(", ")}` : "";
  });
  const strength = before.strength === now.strength ? "" : "strength";
  return [...parts, strength].filter(Boolean).join("; ");
}

function changesOf(before, now) {
  if (before.length && !now.length) return ["taken off"];
  if (now.length && !before.length) return ["put on"];
  if (before.length !== now.length) return ["layers"];
  const pairs = before.map((layer, at) => [layer, now[at]]);
  const differs = (part) => pairs.some(([one, other]) => !sameLook(part(one), part(other)));
  return [
    ["colour", (layer) => COLOURS.map((code) => layer.product[code])],
    ["finish", ({ product }) => ({ ...product, red: 0, green: 0, blue: 0 })],
    ["shape", (layer) => layer.shape],
    ["strength", (layer) => layer.strength],
  ]
    .filter(([, part]) => differs(part))
    .map(([word]) => word);
}
