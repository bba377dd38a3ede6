// Actions of buttons and fields. Why one failed is shown beside it until the next.

import { h } from "./dom.js";
import { occupied } from "./focus.js";
import { problemBox } from "./problem.js";

/** Boxes with the problem of the last action, by the element that they follow. */
const boxes = new WeakMap();

/** Run an action; a box with its problem follows an element, in place of the one before. */
export async function attempt(node, action) {
  boxes.get(node)?.remove();
  try {
    await action();
  } catch (error) {
    if (error.name === "AbortError") return;
    const box = problemBox(error);
    boxes.set(node, box);
    node.after(box);
  }
}

/** A button that does nothing else while its action runs. */
export function button(text, action, attributes = {}) {
  const node = h("button", { type: "button", ...attributes }, text);
  node.addEventListener("click", () => occupied(node, () => attempt(node, action)));
  return node;
}
