// Shapes as GET /v1/shapes/{id}/geometry sends them.

import { request } from "./api.js";

const MAGIC = "isogeom1";
const HEADER = 56;

/**
 * Fetch the geometry of a shape.
 * @returns {Promise<Object>} `positions` (3 V, between -1 and 1), `faces` (3 F), `numbers` (V, the
 *   user's), `colors` (3 V bytes, or null)
 */
export async function geometryOf(shape, signal) {
  const answer = await request(`/v1/shapes/${encodeURIComponent(shape)}/geometry`, { signal });
  return readGeometry(await answer.arrayBuffer());
}

export function readGeometry(buffer) {
  const magic = new TextDecoder("ascii").decode(new Uint8Array(buffer, 0, 8));
  if (magic !== MAGIC) throw new Error("This is no geometry that this page can read.");
  const head = new DataView(buffer);
  const [vertices, triangles, colored] = [8, 12, 16].map((at) => head.getUint32(at, true));
  let at = HEADER;
  const next = (kind, length) => {
    const array = new kind(buffer, at, length);
    at += array.byteLength;
    return array;
  };
  return {
    positions: next(Float32Array, 3 * vertices),
    faces: next(Uint32Array, 3 * triangles),
    numbers: next(Uint32Array, vertices),
    colors: colored ? next(Uint8Array, 3 * vertices) : null,
  };
}

/**
 * Look up vertices by the numbers that they have in the user's file.
 * @returns {function(number): number} the place of a vertex, or undefined
 */
export function places(geometry) {
  const found = new Map();
  geometry.numbers.forEach((number, place) => found.set(number, place));
  return (number) => found.get(number);
}

/** Positions between -1 and 1, as those that are fetched are. */
export function centred(positions) {
  const ends = [0, 1, 2].map((k) => {
    let [low, high] = [Infinity, -Infinity];
    for (let at = k; at < positions.length; at += 3) {
      low = Math.min(low, positions[at]);
      high = Math.max(high, positions[at]);
    }
    return [low, high];
  });
  const half = 0.5 * Math.max(...ends.map(([low, high]) => high - low)) || 1;
  return Float32Array.from(positions, (value, at) => (value - 0.5 * (ends[at % 3][0] + ends[at % 3][1])) / half);
}

export const pointAt = (positions, place) => [0, 1, 2].map((k) => positions[3 * place + k]);

/** (3 V) the sum of the normals of the triangles round each vertex, of any length. */
export function normals(positions, faces) {
  const sums = new Float64Array(positions.length);
  for (let f = 0; f < faces.length; f += 3) {
    const [a, b, c] = [3 * faces[f], 3 * faces[f + 1], 3 * faces[f + 2]];
    const [ux, uy, uz] = [0, 1, 2].map((k) => positions[b + k] - positions[a + k]);
    const [vx, vy, vz] = [0, 1, 2].map((k) => positions[c + k] - positions[a + k]);
    const normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    for (const corner of [a, b, c]) {
      for (let k = 0; k < 3; k++) sums[corner + k] += normal[k];
    }
  }
  return sums;
}
