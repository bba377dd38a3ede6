// Deletion of a shape or a prototype, which is asked about first.

import { button } from "./actions.js";
import { remove } from "./api.js";
import { confirmed } from "./question.js";

/**
 * A button that deletes a record after a question, and returns to the start page.
 * @param {string} path of the record
 * @param {string} consequence what is lost with it
 */
export function deleteButton(path, name, consequence, signal) {
  return button("Delete", async () => {
    if (!(await confirmed(`Delete ${name}?`, consequence, "Delete", "Keep"))) return;
    await remove(path);
    if (!signal.aborted) location.hash = "#/";
  });
}
