// A question before something is lost.

import { h, fill } from "./dom.js";

/**
 * Ask; the answer that loses nothing has the focus, and is that of Escape.
 * @param {string} consequence what is lost
 * @param {string} yes text of the button that goes on
 * @param {string} no text of the other
 */
export function confirmed(question, consequence, yes, no) {
  return new Promise((resolve) => {
    const dialog = h("dialog", { "aria-labelledby": "question" });
    const close = (answer, text) => h("button", { type: "button", autofocus: answer === "no", onclick: () => dialog.close(answer) }, text);
    dialog.addEventListener("close", () => {
      dialog.remove();
      resolve(dialog.returnValue === "yes");
    });
    document.body.append(fill(dialog, h("h2", { id: "question" }, question), h("p", {}, consequence),
      h("p", { class: "actions" }, close("yes", yes), close("no", no))));
    dialog.showModal();
  });
}
