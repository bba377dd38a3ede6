// Links to what the service answers; where a key is needed, it is fetched with the key.

import { request } from "./api.js";
import { h } from "./dom.js";
import { key } from "./key.js";
import { problemBox } from "./problem.js";

/** @param {string} name what the file is called */
export function download(path, text, name) {
  const link = h("a", { href: path, download: name }, text);
  link.addEventListener("click", async (event) => {
    if (key() === null) return;
    event.preventDefault();
    try {
      const blob = await (await request(path)).blob();
      const address = URL.createObjectURL(blob);
      h("a", { href: address, download: name }).click();
      setTimeout(() => URL.revokeObjectURL(address), 60000);
    } catch (error) {
      link.after(problemBox(error));
    }
  });
  return link;
}
