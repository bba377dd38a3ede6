// What shapes are called, by their ids.

import { get } from "./api.js";

const PAGES = 10;

// Names by the list's pages, which are few; what is older is called by its id.
export async function namesOf(ids, signal) {
  const names = new Map();
  const wanted = new Set(ids);
  let cursor = null;
  for (let page = 0; page < PAGES && wanted.size > 0; page++) {
    const query = new URLSearchParams({ limit: 200, ...(cursor ? { cursor } : {}) });
    const shapes = await get(`/v1/shapes?${query}`, signal);
    for (const shape of shapes.items) {
      if (wanted.delete(shape.id)) names.set(shape.id, shape.name);
    }
    cursor = shapes.next_cursor;
    if (cursor === null) break;
  }
  return ids.map((id) => names.get(id) ?? id.slice(0, 8));
}
