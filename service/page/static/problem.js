// Problem documents, shown.

import { h, withCode } from "./dom.js";

/** A box with a problem: its title, detail, and the problems of fields that the detail lacks. */
export function problemBox(error) {
  const errors = (error.errors ?? []).filter((field) => !error.message.includes(field.message));
  return h("div", { class: "problem", role: "alert" },
    h("strong", {}, error.title ?? "Something went wrong"),
    h("p", {}, withCode(error.message)),
    errors.length === 0 ? null : h("ul", {}, errors.map((field) =>
      h("li", {}, h("code", {}, fieldName(field.field)), " ", withCode(field.message)))));
}

/** "points" of "body.points". */
export const fieldName = (field) => field.replace(/^body\./, "");

/** A problem in which `shapes.1` or `targets.1` has the name of that shape beside it. */
export function withNames({ title, message, errors }, names) {
  const named = (text) => text.replace(/\b(?:shapes|targets)\.(\d+)\b/g, (place, at) => (names[at] === undefined ? place : `${place} (${names[at]})`));
  return {
    title, message: named(message),
    errors: (errors ?? []).map((error) => ({ field: named(error.field), message: named(error.message) })),
  };
}
