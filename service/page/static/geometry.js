// Geometry of shapes, as GET /v1/shapes/{id}/geometry sends it.

import { request } from "./api.js";

const MAGIC = "isogeom1";
const HEADER = 56;

/**
 * Fetch the geometry of a shape.
 * @returns {Promise<Object>} `positions` (3 V, between -1 and 1), `faces` (3 F), `numbers` (V, the
 *   indices in the user's file), `colors` (3 V bytes, or null), `cloud`, whether these are points whose
 *   faces were made of them; `origin` and `scale` of the positions in
 *   the units of that file
 */
export async function geometryOf(shape, signal) {
  const answer = await request(`/v1/shapes/${encodeURIComponent(shape)}/geometry`, { signal });
  return readGeometry(await answer.arrayBuffer());
}

export function readGeometry(buffer) {
  const magic = new TextDecoder("ascii").decode(new Uint8Array(buffer, 0, 8));
  if (magic !== MAGIC) throw new Error("The geometry of this shape has a format that this page does not support; reload the page.");
  const head = new DataView(buffer);
  const [vertices, triangles, colored, cloud] = [8, 12, 16, 20].map((at) => head.getUint32(at, true));
  let at = HEADER;
  const next = (kind, length) => {
    const array = new kind(buffer, at, length);
    at += array.byteLength;
    return array;
  };
  const [x, y, z, scale] = [24, 32, 40, 48].map((place) => head.getFloat64(place, true));
  return {
    origin: [x, y, z], scale, cloud: cloud === 1,
    positions: next(Float32Array, 3 * vertices),
    faces: next(Uint32Array, 3 * triangles),
    numbers: next(Uint32Array, vertices),
    colors: colored ? next(Uint8Array, 3 * vertices) : null,
  };
}

/**
 * Look up vertices by their indices in the user's file.
 * @returns {function(number): number} the index of a vertex in `positions`, or undefined
 */
export function places(geometry) {
  const { numbers } = geometry;
  const found = new Int32Array(numbers.reduce((most, number) => Math.max(most, number), -1) + 1).fill(-1);
  numbers.forEach((number, place) => { found[number] = place; });
  return (number) => (found[number] >= 0 ? found[number] : undefined);
}

export const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];

export const pointAt = (positions, place) => [0, 1, 2].map((k) => positions[3 * place + k]);

/** Index of the vertex nearest to a point. */
export function nearestVertex(positions, [x, y, z]) {
  let [best, least] = [0, Infinity];
  for (let v = 0; 3 * v < positions.length; v++) {
    const distance = (positions[3 * v] - x) ** 2 + (positions[3 * v + 1] - y) ** 2
      + (positions[3 * v + 2] - z) ** 2;
    if (distance < least) [best, least] = [v, distance];
  }
  return best;
}

/** Farthest point sampling among the allowed vertices, in space; the first is the farthest from the origin. */
export function farthestVertices(positions, allowed, count) {
  const distances = allowed.map((v) => Math.hypot(...pointAt(positions, v)));
  const found = [];
  while (found.length < Math.min(count, allowed.length)) {
    const next = allowed[distances.reduce((best, value, at) => (value > distances[best] ? at : best), 0)];
    const point = pointAt(positions, next);
    allowed.forEach((v, at) => {
      const distance = Math.hypot(...pointAt(positions, v).map((value, k) => value - point[k]));
      distances[at] = found.length === 0 ? distance : Math.min(distances[at], distance);
    });
    found.push(next);
  }
  return found;
}

/** (3 V) area-weighted normals of the vertices, not of unit length. */
export function normals(positions, faces) {
  // No small arrays: half a million triangles must not hold up the page.
  const sums = new Float64Array(positions.length);
  for (let f = 0; f < faces.length; f += 3) {
    const a = 3 * faces[f];
    const b = 3 * faces[f + 1];
    const c = 3 * faces[f + 2];
    const ux = positions[b] - positions[a];
    const uy = positions[b + 1] - positions[a + 1];
    const uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a];
    const vy = positions[c + 1] - positions[a + 1];
    const vz = positions[c + 2] - positions[a + 2];
    const x = uy * vz - uz * vy;
    const y = uz * vx - ux * vz;
    const z = ux * vy - uy * vx;
    for (let k = 0; k < 3; k++) {
      const corner = 3 * faces[f + k];
      sums[corner] += x;
      sums[corner + 1] += y;
      sums[corner + 2] += z;
    }
  }
  return sums;
}
