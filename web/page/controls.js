// The controls of a look: a tab for each kind of makeup, and the strength of the whole look.

import { byId } from "./elements.js";
import { KindControls } from "./kind.js";
import { moveByKeys, stopAt } from "./row.js";
import { portion, slider } from "./slider.js";

/** Builds all controls into the page and updates them with the look. */
export class Controls {
  #kinds;
  #tabs = byId("kinds");
  #strength;

  constructor(hello, store, shades, openShades) {
    this.#kinds = hello.kinds.map(
      (kind) => new KindControls(kind, hello, store, shades, openShades),
    );
    this.#tabs.replaceChildren(...this.#kinds.map(({ tab }) => tab));
    byId("kind-panels").replaceChildren(...this.#kinds.map(({ panel }) => panel));
    for (const { tab } of this.#kinds) tab.addEventListener("click", () => this.#select(tab));
    moveByKeys(this.#tabs, (tab) => this.#select(tab));
    const spec = portion("strength", "Strength", "How strong the whole look is.");
    this.#strength = slider(spec, (value) => store.edit((look) => (look.strength = value)), false);
    byId("whole").replaceChildren(this.#strength.element);
    this.#select(this.#kinds[0].tab);
    const show = () => this.#show(store.look);
    store.addEventListener("change", show);
    show();
  }

  #show(look) {
    for (const kind of this.#kinds) kind.show(look);
    this.#strength.set(look.strength);
  }

  #select(chosen) {
    for (const kind of this.#kinds) kind.select(kind.tab === chosen);
    stopAt(this.#tabs, chosen);
  }
}
