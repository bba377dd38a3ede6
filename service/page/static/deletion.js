// Deletion of a shape or a prototype, which is asked about first.

import { remove } from "./api.js";
import { h, fill, button } from "./dom.js";
import { problemBox } from "./problem.js";

/**
 * A button that deletes a record after a question, and returns to the start page.
 * @param {string} path of the record
 * @param {string} consequence what is lost with it
 */
export function deleteButton(path, name, consequence) {
  const ask = button("Delete", async () => {
    if (!(await confirmed(`Delete ${name}?`, consequence))) return;
    try {
      await remove(path);
      location.hash = "#/";
    } catch (error) {
      ask.after(problemBox(error));
    }
  });
  return ask;
}

function confirmed(question, consequence) {
  return new Promise((resolve) => {
    const dialog = h("dialog", { "aria-labelledby": "question" });
    const close = (answer) => h("button", { type: "button", autofocus: answer === "no", onclick: () => dialog.close(answer) },
      answer === "no" ? "Keep" : "Delete");
    dialog.addEventListener("close", () => {
      dialog.remove();
      resolve(dialog.returnValue === "yes");
    });
    document.body.append(fill(dialog, h("h2", { id: "question" }, question), h("p", {}, consequence),
      h("p", { class: "actions" }, close("yes"), close("no"))));
    dialog.showModal();
  });
}
