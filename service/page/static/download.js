// Links to files of the service; with an API key, the file is fetched with that key.

import { request } from "./api.js";
import { h } from "./dom.js";
import { key } from "./api_key.js";
import { problemBox } from "./problem.js";

/** Milliseconds for which a file that is being saved is kept. */
const KEPT = 60000;

/** Save what the page has as a file. */
export function save(blob, name) {
  const address = URL.createObjectURL(blob);
  h("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), KEPT);
}

/** @param {string} name name of the downloaded file */
export function download(path, text, name) {
  const link = h("a", { href: path, download: name }, text);
  link.addEventListener("click", async (event) => {
    if (key() === null) return;
    event.preventDefault();
    try {
      save(await (await request(path)).blob(), name);
    } catch (error) {
      link.after(problemBox(error));
    }
  });
  return link;
}

/** Links to the arrays of a job's result and to its files in other formats. */
export const exportsOf = (job) =>
  [job.links.arrays, ...job.links.exports]
    .map((path) => [path, path.split(".").pop()])
    .flatMap(([path, ending]) => [" ", download(path, ending.toUpperCase(), `${job.id}.${ending}`)]);
