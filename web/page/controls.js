// The controls of a look: a tab for each product, and what holds for all of it.

import { Product } from "./product.js";
import { portion, slider } from "./slider.js";

/** Builds all controls into the page and keeps them as the look is. */
export class Controls {
  #products;
  #set = [];

  constructor(hello, store) {
    this.#products = hello.regions.map((info) => new Product(info, hello, store));
    document.getElementById("products").replaceChildren(...this.#products.map(({ tab }) => tab));
    document.getElementById("regions").replaceChildren(...this.#products.map(({ panel }) => panel));
    this.#products.forEach(({ tab }, at) => {
      tab.addEventListener("click", () => this.#select(at));
      tab.addEventListener("keydown", (event) => this.#selectByKey(event, at));
    });
    const help = "How much of the whole look.";
    const spec = portion("strength", "Strength", help);
    const strength = slider(spec, (value) => store.edit((look) => (look.strength = value)), false);
    document.getElementById("whole").replaceChildren(strength.element);
    this.#set = [(look) => strength.set(look.strength)];
    this.#select(0);
    const show = () => this.#show(store.look);
    store.addEventListener("change", show);
    show();
  }

  #show(look) {
    for (const product of this.#products) product.show(look);
    for (const set of this.#set) set(look);
  }

  #select(at) {
    this.#products.forEach(({ tab, panel }, here) => {
      tab.setAttribute("aria-selected", here === at);
      tab.tabIndex = here === at ? 0 : -1;
      panel.hidden = here !== at;
    });
  }

  #selectByKey(event, at) {
    const count = this.#products.length;
    const to = {
      ArrowRight: (at + 1) % count,
      ArrowLeft: (at + count - 1) % count,
      Home: 0,
      End: count - 1,
    }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    this.#select(to);
    this.#products[to].tab.focus();
  }
}
