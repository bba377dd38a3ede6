// Points of a surface: a triangle's corners, as indices of positions, and barycentric coordinates.

import { cross, pointAt } from "./geometry.js";

const AXES = [0, 1, 2];
const minus = (a, b) => AXES.map((k) => a[k] - b[k]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** Position of a point. */
export const positionOf = (positions, { corners, weights }) => AXES.map((k) =>
  corners.reduce((sum, v, at) => sum + weights[at] * positions[3 * v + k], 0));

/** Normal of a point's triangle, not of unit length. */
export function normalAt(positions, { corners }) {
  const [a, b, c] = corners.map((v) => pointAt(positions, v));
  return cross(minus(b, a), minus(c, a));
}

/**
 * The point of a surface nearest to a position; takes time proportional to the number of triangles.
 * @param {Object} mesh `positions` and `faces`
 * @param {Array<number>|null} facing only triangles whose normal is within 90 degrees of this are searched,
 *   so that a point of a thin part stays on its side
 */
export function nearestPoint({ positions, faces }, position, facing = null) {
  let [least, best] = [Infinity, null];
  for (let f = 0; f < faces.length; f += 3) {
    // All of a triangle is within its longer edge of its first corner.
    const [a, b, c] = [3 * faces[f], 3 * faces[f + 1], 3 * faces[f + 2]];
    const away = distance(positions, a, position[0], position[1], position[2]);
    if (away - least > longer(positions, a, b, c)) continue;
    const corners = [faces[f], faces[f + 1], faces[f + 2]];
    if (facing !== null && dot(normalAt(positions, { corners }), facing) <= 0) continue;
    const weights = nearestWeights(...corners.map((v) => pointAt(positions, v)), position);
    const apart = Math.hypot(...minus(positionOf(positions, { corners, weights }), position));
    if (apart < least) [least, best] = [apart, { corners, weights }];
  }
  return best;
}

function distance(positions, at, x, y, z) {
  const [dx, dy, dz] = [positions[at] - x, positions[at + 1] - y, positions[at + 2] - z];
  return Math.sqrt(dx * dx + dy * dy + dz * dz);
}

const longer = (positions, a, b, c) => Math.max(
  distance(positions, b, positions[a], positions[a + 1], positions[a + 2]),
  distance(positions, c, positions[a], positions[a + 1], positions[a + 2]));

/**
 * The point of a surface that is seen on a line of sight: the intersection nearest to the viewer.
 * @param {Object} sight `origin`, and `towards`, the direction to the viewer
 * @returns {Object|null} with `depth`, in units of `towards` from the origin; null if the line misses
 */
export function seenPoint({ positions, faces }, { origin, towards }) {
  let best = null;
  const [across, up] = acrossAndUp(towards);
  // Coordinates of the vertices across the line, which is at 0.
  const plane = new Float64Array((2 * positions.length) / 3);
  for (let v = 0; 3 * v < positions.length; v++) {
    const [x, y, z] = [positions[3 * v] - origin[0], positions[3 * v + 1] - origin[1], positions[3 * v + 2] - origin[2]];
    plane[2 * v] = across[0] * x + across[1] * y + across[2] * z;
    plane[2 * v + 1] = up[0] * x + up[1] * y + up[2] * z;
  }
  const area = (a, b) => plane[2 * a] * plane[2 * b + 1] - plane[2 * a + 1] * plane[2 * b];
  for (let f = 0; f < faces.length; f += 3) {
    const [a, b, c] = [faces[f], faces[f + 1], faces[f + 2]];
    const [first, second, third] = [area(b, c), area(c, a), area(a, b)];
    const total = first + second + third;
    if (total === 0 || first * total < 0 || second * total < 0 || third * total < 0) continue;
    const found = { corners: [a, b, c], weights: [first / total, second / total, third / total] };
    const depth = dot(minus(positionOf(positions, found), origin), towards) / dot(towards, towards);
    if (best === null || depth > best.depth) best = { ...found, depth };
  }
  return best;
}

/** Distance in front of a point, in units of half the shape's size, from which on the surface hides it. */
const BEFORE = 0.04;

/** Whether the surface is in front of a point, for a viewer in direction `towards`, a unit vector. */
export function isHidden(mesh, point, towards) {
  const hit = seenPoint(mesh, { origin: point, towards });
  return hit !== null && hit.depth >= BEFORE;
}

// Two directions at right angles to a direction and to one another.
function acrossAndUp(towards) {
  const least = towards.map(Math.abs).indexOf(Math.min(...towards.map(Math.abs)));
  const across = cross(towards, AXES.map((k) => (k === least ? 1 : 0)));
  return [across, cross(towards, across)];
}

// Barycentric coordinates of the point of a triangle nearest to p, by the region p lies in (Ericson 2005, 5.1.5).
function nearestWeights(a, b, c, p) {
  const [ab, ac, ap, bp, cp] = [minus(b, a), minus(c, a), minus(p, a), minus(p, b), minus(p, c)];
  const [d1, d2] = [dot(ab, ap), dot(ac, ap)];
  if (d1 <= 0 && d2 <= 0) return [1, 0, 0];
  const [d3, d4] = [dot(ab, bp), dot(ac, bp)];
  if (d3 >= 0 && d4 <= d3) return [0, 1, 0];
  const vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return [1 - d1 / (d1 - d3), d1 / (d1 - d3), 0];
  const [d5, d6] = [dot(ab, cp), dot(ac, cp)];
  if (d6 >= 0 && d5 <= d6) return [0, 0, 1];
  const vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return [1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)];
  const va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    const share = (d4 - d3) / (d4 - d3 + (d5 - d6));
    return [0, 1 - share, share];
  }
  const [v, w] = [vb / (va + vb + vc), vc / (va + vb + vc)];
  return [1 - v - w, v, w];
}
