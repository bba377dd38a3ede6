// Links to files of the service; with an API key, the file is fetched with that key.

import { attempt } from "./actions.js";
import { PATIENCE_FOR_FILES, request } from "./api.js";
import { h } from "./dom.js";
import { key } from "./api_key.js";

/** Milliseconds for which a file that is being saved is kept. */
const KEPT = 60000;

/** Save what the page has as a file. */
export function save(blob, name) {
  const address = URL.createObjectURL(blob);
  h("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), KEPT);
}

/** The name that the service gives a file, which goes before that of a link. */
function nameOf(response) {
  const given = response.headers.get("Content-Disposition") ?? "";
  const encoded = /filename\*=UTF-8''([^;]+)/.exec(given);
  return encoded ? decodeURIComponent(encoded[1]) : /filename="([^"]+)"/.exec(given)?.[1];
}

/** @param {string} name name of the downloaded file where the service gives none */
export function download(path, text, name) {
  const link = h("a", { href: path, download: name }, text);
  link.addEventListener("click", (event) => {
    if (key() === null) return;
    event.preventDefault();
    attempt(link, async () => {
      const response = await request(path, { patience: PATIENCE_FOR_FILES });
      save(await response.blob(), nameOf(response) ?? name);
    });
  });
  return link;
}

/** Links to the arrays of a job's result and to its files in other formats. */
export const exportsOf = (job) =>
  [job.links.arrays, ...job.links.exports]
    .map((path) => [path, path.split(".").pop()])
    .flatMap(([path, ending]) => [" ", download(path, ending.toUpperCase(), `${job.id}.${ending}`)]);
