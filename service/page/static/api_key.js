// The API key: kept in the tab, and asked for when the service needs one.

import { h, fill } from "./dom.js";
import { drop, keep, kept } from "./tab_storage.js";

const NAME = "isomatch-key";
/** Printable Latin-1, as browsers send headers of nothing else. */
const LETTERS = "[\\s\\x21-\\x7e\\xa1-\\xff]*";
let asking = null;

export const key = () => kept(NAME);

export const authorization = () => (key() ? { Authorization: `Bearer ${key()}` } : {});

/**
 * Ask for the key; concurrent calls share one dialog.
 * @param {string} reason detail of the problem
 * @returns {Promise<boolean>} whether one was given
 */
export function askForKey(reason) {
  asking ??= ask(reason).finally(() => {
    asking = null;
  });
  return asking;
}

function ask(reason) {
  return new Promise((resolve) => {
    const input = h("input", {
      id: "key-input", type: "password", autocomplete: "off", spellcheck: "false", pattern: LETTERS,
      title: "A key has Latin letters, digits and punctuation only.",
    });
    const dialog = h("dialog", { "aria-labelledby": "key-title" });
    const form = h("form", {},
      h("h2", { id: "key-title" }, "API key"),
      h("p", {}, reason),
      h("label", { for: "key-input" }, "Key"), input,
      h("p", { class: "faint" }, "It is kept in this tab only, until the tab is closed."),
      h("p", { class: "actions" },
        h("button", { type: "submit", class: "primary" }, "Use this key"),
        h("button", { type: "button", onclick: () => dialog.close() }, "Cancel")));
    let given = false;
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const value = input.value.trim();
      if (value) keep(NAME, value);
      else drop(NAME);
      given = value !== "";
      dialog.close();
    });
    dialog.addEventListener("close", () => {
      dialog.remove();
      resolve(given);
    });
    document.body.append(fill(dialog, form));
    dialog.showModal();
  });
}
