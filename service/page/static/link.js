// Links to what the page shows, to be given to others.

import { h } from "./dom.js";

const PRAISE = 2000;

/** A button that copies the address of a job; where that is not allowed, the address is shown. */
export function linkButton(id) {
  const address = `${location.origin}${location.pathname}#job=${encodeURIComponent(id)}`;
  const said = h("span", { class: "faint", role: "status" });
  const copy = h("button", { type: "button", onclick: async () => {
    try {
      await navigator.clipboard.writeText(address);
      said.textContent = "Copied.";
      setTimeout(() => { said.textContent = ""; }, PRAISE);
    } catch {
      const field = h("input", { type: "text", readonly: true, value: address, "aria-label": "Address of this result", class: "address" });
      copy.replaceWith(field);
      field.select();
    }
  } }, "Copy link");
  return h("span", {}, copy, " ", said);
}
