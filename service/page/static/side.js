// What is known of a shape that is drawn: its geometry as it came, and as it is seen.

import { Problem, request } from "./api.js";
import { coarsened } from "./coarsen.js";
import { geometryOf, normals, places } from "./geometry.js";
import { readArrays } from "./npz.js";
import { seen } from "./stance.js";

/** Points stand so far out of the surface, in halves of the shape's size. */
const LIFT = 0.012;

/** @param {string} end "source" or "target" */
export async function sideOf(shape, end, signal) {
  const geometry = await geometryOf(shape.id, signal);
  const { positions, faces } = geometry;
  return {
    shape, end, geometry, unturned: geometry, mesh: coarsened(geometry), normals: normals(positions, faces),
    place: places(geometry),
  };
}

/**
 * A prototype, on the shape that its points were chosen on; its points take the place of vertices.
 * @returns {Promise<Object|null>} `points`, their number, as well; null where no such shape is kept
 */
export async function prototypeSide({ id, name, version, reference }, signal) {
  if (id === null || reference === null) return null;
  try {
    const answer = await request(`/v1/prototypes/${encodeURIComponent(id)}/archive`, { signal });
    const [{ vertices }, side] = await Promise.all([
      answer.arrayBuffer().then((archive) => readArrays(archive, ["vertices"])),
      sideOf({ id: reference, name: `${name}, version ${version}`, faces: 0 }, "source", signal),
    ]);
    const shape = { ...side.shape, faces: side.geometry.faces.length / 3 };
    return { ...side, shape, points: vertices.length, place: (point) => side.place(vertices[point]) };
  } catch (error) {
    if (error instanceof Problem && [404, 410].includes(error.status)) return null;
    throw error;
  }
}

/** Turn a side: all places are then as they are seen. */
export function stand(side, rows) {
  side.geometry = { ...side.geometry, positions: seen(rows, side.geometry.positions) };
  side.normals = seen(rows, side.normals);
  side.mesh = { ...side.mesh, positions: seen(rows, side.mesh.positions) };
}

/** Where a point of the surface is drawn: the mean of vertices, by their places, and a little out of it. */
export function lifted(side, vertices, weights) {
  const mean = (values) => [0, 1, 2].map((k) =>
    vertices.reduce((sum, v, at) => sum + weights[at] * values[3 * v + k], 0));
  const place = mean(side.geometry.positions);
  const normal = mean(side.normals);
  const length = Math.hypot(...normal) || 1;
  return place.map((value, k) => value + (LIFT * normal[k]) / length);
}
