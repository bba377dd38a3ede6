// What is known of a shape that is drawn: its geometry as it came, and as it is seen.

import { Problem, request } from "./api.js";
import { coarsened } from "./coarsen.js";
import { centred, geometryOf, normals, places } from "./geometry.js";
import { readArrays } from "./npz.js";
import { seen } from "./stance.js";

/** Points stand so far out of the surface, in halves of the shape's size. */
const LIFT = 0.012;

/** @param {string} end "source" or "target" */
export async function sideOf(shape, end, signal) {
  return sideWith(shape, end, await geometryOf(shape.id, signal));
}

const sideWith = (shape, end, geometry) => ({
  shape, end, geometry, unturned: geometry, mesh: coarsened(geometry), place: places(geometry),
  normals: normals(geometry.positions, geometry.faces),
});

const KEPT = ["vertices", "surface0_vertices", "surface0_faces", "surface0_points"];

/**
 * A prototype, on the shape that its points were chosen on; its points take the place of vertices.
 * Where that shape is not kept, the first surface of the archive serves.
 * @returns {Promise<Object|null>} `points`, their number, as well; null where there is no surface
 */
export async function prototypeSide({ id, name, version, reference }, signal) {
  if (id === null) return null;
  const shape = { id: reference, name: `${name}, version ${version}` };
  const [arrays, chosenOn] = await Promise.all([
    archiveOf(id, signal),
    reference === null ? null : orNull(sideOf(shape, "source", signal)),
  ]);
  if (arrays === null) return null;
  const side = chosenOn ?? keptSide(shape, arrays);
  if (side === null) return null;
  const vertices = chosenOn === null ? arrays.surface0_points : arrays.vertices;
  return {
    ...side, points: vertices.length, place: (point) => side.place(vertices[point]),
    shape: { ...shape, faces: side.geometry.faces.length / 3 },
  };
}

const archiveOf = (id, signal) => orNull(request(`/v1/prototypes/${encodeURIComponent(id)}/archive`, { signal })
  .then((answer) => answer.arrayBuffer()).then((archive) => readArrays(archive, KEPT)));

function keptSide(shape, { surface0_vertices: vertices, surface0_faces: faces }) {
  if (vertices === undefined) return null;
  const geometry = {
    positions: centred(vertices), faces: Uint32Array.from(faces), colors: null,
    numbers: Uint32Array.from({ length: vertices.length / 3 }, (_, v) => v),
  };
  return sideWith(shape, "source", geometry);
}

// What is no longer kept is nothing.
async function orNull(asked) {
  try {
    return await asked;
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
