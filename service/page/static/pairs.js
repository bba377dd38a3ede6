// The matched pairs as a table whose rows can be pointed at.

import { h } from "./dom.js";
import { css } from "./tint.js";
import { figure } from "./words.js";

/**
 * @param {Array<Object>} pairs correspondences
 * @param {Array<Array<number>>|null} colors those that they have in the drawing
 * @param {boolean} learned whether the source is a prototype
 */
export function pairTable(pairs, colors, selection, learned) {
  const rows = pairs.map((pair, at) => row(pair, at, colors?.[at], selection));
  const head = ["Pair", learned ? "Point of the prototype" : "Source vertex", "Target vertex", "Cost"];
  const table = h("table", { class: "pairs" },
    h("caption", {}, "Matched pairs. Point at one, or choose it, to find it on both shapes."),
    h("thead", {}, h("tr", {}, head.map((text) => h("th", { scope: "col" }, text)))),
    h("tbody", {}, rows));
  const show = () => rows.forEach((line, at) => {
    line.classList.toggle("shown", at === selection.shown);
    line.querySelector("button").setAttribute("aria-pressed", String(at === selection.chosen));
  });
  selection.addEventListener("change", show);
  return h("div", { class: "scroll" }, table);
}

function row(pair, at, color, selection) {
  const swatch = h("span", { class: "swatch" });
  if (color) swatch.style.background = css(color);
  const choose = h("button", {
    type: "button", class: "small", "aria-pressed": "false",
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
