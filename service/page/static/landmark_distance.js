// Landmarks on a surface: their nearest points, and a remark on those that are far from it.

import { nearestPoint, positionOf } from "./surface_point.js";

/** Distance from the surface, over √area, above which a landmark is reported and left out. */
const FAR = 0.05;
const MOST_NAMED = 5;

/** Position of a point in the coordinates of the shape's file. */
export function inFile({ unrotated }, point) {
  const place = positionOf(unrotated.positions, point);
  return place.map((value, k) => unrotated.origin[k] + unrotated.scale * value);
}

/**
 * The nearest points of a surface.
 * @param {Array<Object>} landmarks with their positions in the coordinates of the shape's file
 * @param {Object} side the shape: see drawn_shape.js
 * @returns {Object} `points`, null where a landmark is missing or far from the surface, and all null if they are in another
 *   coordinate system than the shape; `remark` on those that are far, or null
 */
export function onSurface(landmarks, side) {
  const given = landmarks.map(({ position }) => position);
  const nearest = given.map((position) => (position === null ? null : nearestTo(side, position)));
  const apart = nearest.map((point, i) => (point === null ? 0 : distance(side, point, given[i])));
  const far = FAR * Math.sqrt(side.shape.area);
  const isFar = apart.map((value) => value > far);
  if (!isFar.includes(true)) return { points: nearest, remark: null };
  const present = landmarks.flatMap(({ position }, i) => (position === null ? [] : [i]));
  const negated = present.map((i) => given[i]).map(([x, y, z]) => [-x, -y, z])
    .map((position) => distance(side, nearestTo(side, position), position));
  // As the client does (client/isomatch/_landmarks/remarks.py).
  const nearer = median(negated) < 0.5 * median(present.map((i) => apart[i]));
  const stillFar = negated.filter((value) => value > far).length;
  const wrong = nearer && 2 * stillFar < isFar.filter(Boolean).length;
  const start = remarkOn(landmarks, apart, isFar, present.length);
  if (wrong) {
    return { points: nearest.map(() => null), remark: `${start}, but ${stillFar || "none"} with x and y negated: the landmarks are not in`
      + " the coordinate system of the mesh. Choose the other coordinates of the meshes; in a file that names none, negate x and y." };
  }
  return {
    points: nearest.map((point, i) => (isFar[i] ? null : point)),
    remark: `${start}; ${isFar.filter(Boolean).length === 1 ? "it is" : "they are"} left out. Are these landmarks of this mesh?`
      + (nearer ? " With x and y negated they are nearer: check the coordinates of the meshes." : ""),
  };
}

function nearestTo({ unrotated }, position) {
  const { origin, scale } = unrotated;
  return nearestPoint(unrotated, position.map((value, k) => (value - origin[k]) / scale));
}

const distance = (side, point, position) => Math.hypot(...inFile(side, point).map((value, k) => value - position[k]));

function remarkOn(landmarks, apart, isFar, count) {
  const far = isFar.flatMap((one, i) => (one ? [i] : [])).sort((a, b) => apart[b] - apart[a]);
  const named = far.slice(0, MOST_NAMED).map((i) => `"${landmarks[i].label}" by ${apart[i].toPrecision(4)}`);
  if (far.length > MOST_NAMED) named.push(`and ${far.length - MOST_NAMED} more`);
  return `${far.length} of ${count} landmarks ${far.length === 1 ? "is" : "are"} far from the surface, ${named.join(", ")}`;
}

const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];
