// The layers of a look: by kind, and with their shapes and finishes.

export const BOTH = "both"; // a value of the dial `eye`

/** The layers of one kind, in the order of painting. */
export const layersOf = (look, kind) => look.layers.filter((layer) => layer.kind === kind.name);

/**
 * Give the look these layers of one kind; an empty list takes the kind off. All layers stay in the
 * order of painting, as on the server. kinds: all kinds, as in hello.
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

/**
 * A layer to add to others of its kind: the product of the layer `like` on the same eyes, in the
 * first slot that is free there.
 */
export function anotherLayer(kind, layers, like) {
  const { eye } = like.shape;
  const beside = layers.filter(({ shape }) => eyesOf(shape).some((one) => eyesOf({ eye }).includes(one)));
  const taken = beside.map((layer) => wholeShape(kind, layer.shape).slot);
  const slot = Object.keys(kind.slots).find((name) => !taken.includes(name));
  const shape = { ...(slot && { slot }), ...(eye && { eye }) };
  return { ...structuredClone(like), strength: 1, shape };
}

/** Whether the eyes that wear this layer may have another layer of its kind. */
export function hasRoom(kind, layers, { shape }) {
  const on = (eye) => layers.filter((layer) => eyesOf(layer.shape).includes(eye)).length;
  return eyesOf(shape).every((eye) => on(eye) < kind.most);
}

function eyesOf({ eye = BOTH }) {
  return eye === BOTH ? ["left", "right"] : [eye];
}

/** A value for each dial of the kind: from the shape, else from its slot, else the default. */
export function wholeShape(kind, shape) {
  const defaults = Object.fromEntries(kind.dials.map((dial) => [dial.name, dial.default]));
  return { ...defaults, ...kind.slots[shape.slot ?? defaults.slot], ...shape };
}

/** The name of a product's finish; undefined when no finish has the product's settings. */
export function finishOf(product, finishes, part) {
  return Object.keys(finishes).find((name) =>
    Object.entries(finishes[name][part]).every(
      ([key, value]) => Math.abs(product[key] - value) < 1e-9,
    ),
  );
}

/** The name of a slot in words. */
export const inWords = (name) => name.replaceAll("_", " ");
