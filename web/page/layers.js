// The layers of a look: those of one kind, and what they are worn with.

export const BOTH = "both"; // of the dial `eye`

/** The layers of one kind, in the order of painting. */
export const layersOf = (look, kind) => look.layers.filter((layer) => layer.kind === kind.name);

/**
 * Give the look these layers of one kind; none takes the kind off. The layers stay in the order of
 * painting, as the server has them. kinds: all of them, as in hello.
 */
export function putLayers(look, kind, layers, kinds) {
  const order = Object.fromEntries(kinds.map((one) => [one.name, one.order]));
  const others = look.layers.filter((layer) => layer.kind !== kind.name);
  look.layers = [...others, ...layers].sort((a, b) => order[a.kind] - order[b.kind]);
}

/** The layer that a kind begins with. finishes: as in hello. */
export function firstLayer(kind, finishes) {
  const product = { ...kind.first, ...finishes[kind.first_finish][kind.part] };
  return { kind: kind.name, strength: 1, product, shape: {} };
}

/** A layer to add to others of its kind: the same product in the first place that is free, on the
 * same eyes. */
export function anotherLayer(kind, layers, like) {
  const { eye } = like.shape;
  const beside = layers.filter(({ shape }) => eyesOf(shape).some((one) => eyesOf({ eye }).includes(one)));
  const taken = beside.map((layer) => wholeShape(kind, layer.shape).slot);
  const slot = Object.keys(kind.slots).find((name) => !taken.includes(name));
  const shape = { ...(slot && { slot }), ...(eye && { eye }) };
  return { ...structuredClone(like), strength: 1, shape };
}

/** Whether there may be another layer on the eyes that wear this one. */
export function hasRoom(kind, layers, { shape }) {
  const on = (eye) => layers.filter((layer) => eyesOf(layer.shape).includes(eye)).length;
  return eyesOf(shape).every((eye) => on(eye) < kind.most);
}

function eyesOf({ eye = BOTH }) {
  return eye === BOTH ? ["left", "right"] : [eye];
}

/** A value for each dial of the kind: the shape's own, else that of its slot, else the default. */
export function wholeShape(kind, shape) {
  const defaults = Object.fromEntries(kind.dials.map((dial) => [dial.name, dial.default]));
  return { ...defaults, ...kind.slots[shape.slot ?? defaults.slot], ...shape };
}

/** The name of a product's finish; undefined when its settings are those of none. */
export function finishOf(product, finishes, part) {
  return Object.keys(finishes).find((name) =>
    Object.entries(finishes[name][part]).every(
      ([key, value]) => Math.abs(product[key] - value) < 1e-9,
    ),
  );
}

/** The name of a slot in words. */
export const inWords = (name) => name.replaceAll("_", " ");
