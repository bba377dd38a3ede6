// Names of shapes and prototypes by their ids.

import { get } from "./api.js";

const PAGE = 200;
const known = new Map();
/** Pages in which ids were searched for that are not in them. */
const searched = new Map();
let asking = Promise.resolve();

/** Names from the newest pages of the lists; older records are shown by the start of their id. */
export async function namesOf(ids, signal, pages = 10) {
  // Calls wait for one another, so that a page is not fetched twice.
  const before = asking;
  asking = before.catch(() => {}).then(() => lookUpAll(ids, signal, pages));
  await asking;
  return ids.map((id) => known.get(id) ?? id.slice(0, 8));
}

/** Names of which some are given; the others, null or missing, are those from the lists. */
export async function completed(given, ids, signal, pages) {
  const lacks = (at) => (given?.[at] ?? null) === null;
  const found = await namesOf(ids.filter((_, at) => lacks(at)), signal, pages);
  return ids.map((_, at) => (lacks(at) ? found.shift() : given[at]));
}

async function lookUpAll(ids, signal, pages) {
  const learned = ids.filter((id) => id.startsWith("p-"));
  const shapes = ids.filter((id) => !id.startsWith("p-"));
  await Promise.all([
    lookUp("/v1/shapes", shapes, ({ name }) => name, signal, pages),
    lookUp("/v1/prototypes", learned, ({ name, version }) => `${name}, version ${version}`, signal, pages),
  ]);
}

async function lookUp(path, ids, called, signal, pages) {
  const wanted = new Set(ids.filter((id) => !known.has(id) && !(searched.get(id) >= pages)));
  let cursor = null;
  for (let page = 0; page < pages && wanted.size > 0; page++) {
    const query = new URLSearchParams({ limit: PAGE, ...(cursor ? { cursor } : {}) });
    const found = await get(`${path}?${query}`, signal);
    for (const item of found.items) {
      known.set(item.id, called(item));
      wanted.delete(item.id);
    }
    cursor = found.next_cursor;
    if (cursor === null) break;
  }
  for (const id of wanted) searched.set(id, cursor === null ? Infinity : pages);
}
