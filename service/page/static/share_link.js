// Links to results, for sharing.

import { h } from "./dom.js";

/** Milliseconds for which the page says that a link was copied. */
const SHOWN = 2000;

/**
 * A button that copies the address of a job, or shows it where copying is not allowed.
 * @param {string} id
 * @param {function(): string} part what the address has after the id
 */
export function linkButton(id, part = () => "") {
  const said = h("span", { class: "faint", role: "status" });
  const copy = h("button", { type: "button", onclick: async () => {
    const address = `${location.origin}${location.pathname}#job=${encodeURIComponent(id)}${part()}`;
    try {
      await navigator.clipboard.writeText(address);
      said.textContent = "Copied.";
      setTimeout(() => { said.textContent = ""; }, SHOWN);
    } catch {
      const field = h("input", { type: "text", readonly: true, value: address, "aria-label": "Address of this result", class: "address" });
      copy.replaceWith(field);
      field.focus();
      field.select();
    }
  } }, "Copy link");
  return h("span", {}, copy, " ", said);
}
