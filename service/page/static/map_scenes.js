// The map of a pair of a collection, drawn as a match is.

import { request } from "./api.js";
import { h, fill } from "./dom.js";
import { farthestVertices, geometryOf } from "./geometry.js";
import { recordOf } from "./match.js";
import { matchScenes } from "./match_scenes.js";
import { openNpz } from "./npz.js";
import { Selection } from "./selection.js";
import { simplified } from "./vertex_clustering.js";

/** Vertices whose images are marked. */
const MARKED = 32;

/**
 * Prepare drawing the maps of a job.
 * @returns {function(Node, number, Object, number, Object)} draws the map of two shapes, each by its place
 *   and what the result has of it, in place of the one that was drawn before
 */
export function mapScenes(job, signal) {
  let arrays = null;
  let before = new AbortController();
  signal.addEventListener("abort", () => before.abort());
  return async (place, i, source, j, target) => {
    before.abort();
    const own = before = new AbortController();
    fill(place, h("p", { class: "faint" }, "Loading the map."));
    try {
      // All maps of a job are in one file, which is fetched once.
      arrays ??= fetched(job, signal);
      const records = [source, target].map(({ shape, name }) => recordOf("shapes", shape, name, own.signal));
      const [here, there, array] = await Promise.all([...records, arrays]);
      const { data } = await array(`map_${i}_${j}`);
      const result = { source_kind: "shape", refinement: null, ...await resultOf(data, here, own.signal) };
      if (own.signal.aborted) return;
      const drawn = await matchScenes(place, result, here, there, new Selection(), own.signal);
      await drawn?.show({ correspondences: result.correspondences, refined: null, dense: result.dense });
    } catch (error) {
      if (own.signal.aborted) return;
      arrays = null;
      throw error;
    }
  };
}

const fetched = async (job, signal) => openNpz(await (await request(job.links.arrays, { signal })).arrayBuffer());

// The mapped vertices; of those that are drawn as one, the first: there are hundreds of thousands.
function candidates(geometry, images) {
  const { left } = simplified(geometry);
  const first = new Map();
  geometry.numbers.forEach((number, place) => {
    if (images[number] >= 0 && !first.has(left(place))) first.set(left(place), place);
  });
  return [...first.values()];
}

// A map as the result of a match: its dense map, and pairs of vertices that are spread over the source.
async function resultOf(images, { id }, signal) {
  const source = [...images.keys()].filter((vertex) => images[vertex] >= 0);
  const dense = { source, target: source.map((vertex) => images[vertex]) };
  if (id === null) return { dense, correspondences: [] };
  const geometry = await geometryOf(id, signal);
  const { positions, numbers } = geometry;
  const correspondences = farthestVertices(positions, candidates(geometry, images), MARKED)
    .map((place) => ({ source: numbers[place], target: images[numbers[place]] }));
  return { dense, correspondences };
}
