// Elements of the page, made of text and other elements, never of markup: names cannot inject any.

import { keepFocus } from "./focus.js";

/**
 * Make an element.
 * @param {string} tag
 * @param {Object} attributes a name that begins with "on" is an event; null and false leave one out
 * @param {...(Node|string|number|null|Array)} children null leaves one out
 */
export function h(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? "" : String(value));
  }
  node.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return node;
}

/** Put these, and nothing else, into an element. */
export function fill(node, ...children) {
  keepFocus(node, () => node.replaceChildren(...children.flat(Infinity).filter((child) => child !== null)));
  return node;
}

/** Text of the service as children of an element: what is between backticks is code. */
export const withCode = (text) => text.split(/`([^`]+)`/).map((part, at) => (at % 2 === 1 ? h("code", {}, part) : part));

/** Warnings as a list, or null if there are none. */
export const warningList = (warnings) => (warnings.length === 0 ? null
  : h("ul", { class: "warnings" }, warnings.map((text) => h("li", {}, withCode(text)))));

/** A list of terms and values. */
export const figureList = (entries) => h("dl", { class: "figures" }, entries.map(([term, value, field = null]) =>
  h("div", {}, h("dt", {}, term), h("dd", { "data-field": field }, value))));

/** Rows of a table, or entries of a list, up to which it is shown in full. */
export const MOST_IN_FULL = 20;

/** Columns that are beside one another on a phone, too. */
const MOST_BESIDE = 3;

/** Attributes of an area that has its own scroll bar if it is long, and then can be reached by keyboard. */
export const scrolled = (classes, count, label) => (count > MOST_IN_FULL
  ? { class: `${classes} long`, tabindex: "0", role: "group", "aria-label": label } : { class: classes });

/** A table that scrolls if it is wide or long. On a phone, cells of several columns are below one another, each with its head. */
export function table(caption, heads, rows, attributes = {}) {
  for (const row of rows) {
    for (const cell of row.cells) if (cell.colSpan === 1) cell.dataset.head = heads[cell.cellIndex];
  }
  return h("div", scrolled("scroll", rows.length, [caption].flat().join("")),
    h("table", { class: heads.length > MOST_BESIDE ? "stacked" : null, ...attributes }, h("caption", {}, caption),
      h("thead", {}, h("tr", {}, heads.map((text) => h("th", { scope: "col" }, text)))),
      h("tbody", {}, rows)));
}

/** Text for plotly.js, which takes some tags for markup, but in drawings in space. */
export function plain(text) {
  return text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;");
}
