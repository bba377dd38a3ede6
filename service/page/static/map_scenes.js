// The map of a pair of a collection, drawn as a match is.

import { request } from "./api.js";
import { h, fill } from "./dom.js";
import { farthestVertices, geometryOf } from "./geometry.js";
import { recordOf } from "./match.js";
import { matchScenes } from "./match_scenes.js";
import { openNpz } from "./npz.js";
import { Selection } from "./selection.js";

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

// A map as the result of a match: its dense map, and pairs of vertices that are spread over the source.
async function resultOf(images, { id }, signal) {
  const source = [...images.keys()].filter((vertex) => images[vertex] >= 0);
  const dense = { source, target: source.map((vertex) => images[vertex]) };
  if (id === null) return { dense, correspondences: [] };
  const { positions, numbers } = await geometryOf(id, signal);
  const mapped = [...numbers.keys()].filter((place) => images[numbers[place]] >= 0);
  const correspondences = farthestVertices(positions, mapped, MARKED)
    .map((place) => ({ source: numbers[place], target: images[numbers[place]] }));
  return { dense, correspondences };
}
