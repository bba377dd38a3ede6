// Problem documents, shown.

import { h } from "./dom.js";

/** A box with a problem: its title, detail, and the problems of fields that the detail lacks. */
export function problemBox(error) {
  const errors = (error.errors ?? []).filter((field) => !error.message.includes(field.message));
  return h("div", { class: "problem", role: "alert" },
    h("strong", {}, error.title ?? "Something went wrong"),
    h("p", {}, error.message),
    errors.length === 0 ? null : h("ul", {}, errors.map((field) =>
      h("li", {}, h("code", {}, fieldName(field.field)), " ", field.message))));
}

/** "points" of "body.points". */
export const fieldName = (field) => field.replace(/^body\./, "");
