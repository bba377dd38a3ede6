// The highlighted pair of a match: hovered or focused, else the chosen one.

export class Selection extends EventTarget {
  #hovered = null;
  #chosen = null;

  /** Index of the highlighted pair, or null. */
  get shown() {
    return this.#hovered ?? this.#chosen;
  }

  get chosen() {
    return this.#chosen;
  }

  hover(pair) {
    this.#set(() => { this.#hovered = pair; });
  }

  /** Choose a pair, or unchoose it. */
  choose(pair) {
    this.#set(() => {
      this.#chosen = pair === this.#chosen ? null : pair;
      this.#hovered = null;
    });
  }

  clear() {
    this.#set(() => { this.#chosen = this.#hovered = null; });
  }

  #set(change) {
    const before = [this.#chosen, this.shown];
    change();
    if (before[0] !== this.#chosen || before[1] !== this.shown) this.dispatchEvent(new Event("change"));
  }
}
