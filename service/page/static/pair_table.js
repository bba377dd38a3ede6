// The table of matched pairs; the pair of a row is highlighted on both shapes.

import { css } from "./colors.js";
import { h, table } from "./dom.js";
import { figure } from "./format.js";

/**
 * @param {Array<Object>} pairs correspondences
 * @param {Array<Array<number>>|null} colors colours of the pairs in the drawing
 * @param {boolean} learned whether the source is a prototype
 * @param {AbortSignal} signal aborted when the table is replaced
 */
export function pairTable(pairs, colors, selection, learned, signal) {
  const rows = pairs.map((pair, at) => row(pair, at, colors?.[at], selection));
  const heads = ["Pair", learned ? "Point of the prototype" : "Source vertex", "Target vertex", "Cost"];
  const show = () => rows.forEach((line, at) => {
    line.classList.toggle("shown", at === selection.shown);
    line.querySelector("button").setAttribute("aria-pressed", String(at === selection.chosen));
  });
  selection.addEventListener("change", show, { signal });
  return table("Matched pairs. Hover over or choose a pair to highlight it on both shapes.", heads, rows, { class: "pairs" });
}

function row(pair, at, color, selection) {
  const swatch = h("span", { class: "swatch" });
  if (color) swatch.style.background = css(color);
  const choose = h("button", {
    type: "button", class: "small", "aria-pressed": "false", "aria-label": `Pair ${at + 1}`,
    onclick: () => selection.choose(at),
    onfocus: () => selection.hover(at),
    onblur: () => selection.hover(null),
  }, swatch, String(at + 1));
  return h("tr", {
    "data-pair": at,
    onmouseenter: () => selection.hover(at),
    onmouseleave: () => selection.hover(null),
  }, h("th", { scope: "row" }, choose), h("td", {}, pair.source), h("td", {}, pair.target),
  h("td", {}, figure(pair.cost)));
}
