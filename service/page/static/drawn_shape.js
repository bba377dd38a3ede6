// A shape as it is drawn: its geometry, simplified for drawing, in the coordinates of a view.

import { get, orNull } from "./api.js";
import { geometryOf, normals, places } from "./geometry.js";
import { simplified } from "./vertex_clustering.js";
import { UPRIGHT, rotated } from "./view.js";

/** Height of points above the surface, in units of half the shape's size. */
const LIFT = 0.012;

/**
 * Fetch a shape.
 * @param {Object} shape its record
 * @param {string} end "source" or "target"
 * @returns {Promise<Object>} `geometry`, as fetched and in the coordinates of the view; `mesh`, what
 *   is drawn of it; `place`, which looks up vertices by their index in the file
 */
export async function drawnShape(shape, end, signal) {
  return drawnWith(shape, end, await geometryOf(shape.id, signal));
}

const drawnWith = (shape, end, geometry) => ({
  shape, end, geometry, unrotated: geometry, mesh: { ...simplified(geometry), cloud: geometry.cloud }, place: places(geometry),
  normals: normals(geometry.positions, geometry.faces),
});

/**
 * Fetch a prototype, drawn on its reference shape, or on a surface of its own if that is not kept.
 * @returns {Promise<Object|null>} as `drawnShape`, with `points`, their number, and `place`, which
 *   looks up points; null if there is no surface
 */
export async function drawnPrototype({ id, name, version, reference, view = UPRIGHT }, signal) {
  if (id === null) return null;
  const shape = { id: reference, name: `${name}, version ${version}`, view };
  const [kept, onReference] = await Promise.all([
    orNull(get(`/v1/prototypes/${encodeURIComponent(id)}/geometry`, signal)),
    reference === null ? null : orNull(drawnShape(shape, "source", signal)),
  ]);
  if (kept === null || (onReference ?? kept.surface) === null) return null;
  const drawn = onReference ?? drawnWith(shape, "source", surfaceGeometry(kept.surface));
  const vertices = onReference === null ? kept.surface.points : kept.vertices;
  return {
    ...drawn, points: vertices.length, place: (point) => drawn.place(vertices[point]),
    shape: { ...shape, faces: drawn.geometry.faces.length / 3 },
  };
}

const surfaceGeometry = ({ positions, faces }) => ({
  positions: Float32Array.from(positions.flat()), faces: Uint32Array.from(faces.flat()), colors: null,
  numbers: Uint32Array.from(positions.keys()),
});

/** Rotate a shape into the coordinates of a view. */
export function rotate(drawn, rows) {
  drawn.geometry = { ...drawn.geometry, positions: rotated(rows, drawn.geometry.positions) };
  drawn.normals = rotated(rows, drawn.normals);
  drawn.mesh = { ...drawn.mesh, positions: rotated(rows, drawn.mesh.positions) };
}

/** Position of a point of the surface, given by vertices and weights, lifted a little above it. */
export function lifted(drawn, vertices, weights, lift = LIFT) {
  const mean = (values) => [0, 1, 2].map((k) =>
    vertices.reduce((sum, v, at) => sum + weights[at] * values[3 * v + k], 0));
  const position = mean(drawn.geometry.positions);
  const normal = mean(drawn.normals);
  const length = Math.hypot(...normal) || 1;
  return position.map((value, k) => value + (lift * normal[k]) / length);
}
