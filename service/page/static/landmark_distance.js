// Landmarks on a surface: their nearest points, and a remark on those that are far from it.

import { nearestPoint, positionOf } from "./surface_point.js";

/** Distance from the surface, over √area, above which a landmark is reported and left out. */
const FAR = 0.05;

/** Position of a point in the coordinates of the shape's file. */
export function inFile({ unrotated }, point) {
  const place = positionOf(unrotated.positions, point);
  return place.map((value, k) => unrotated.origin[k] + unrotated.scale * value);
}

/**
 * The nearest points of a surface.
 * @param {Array<Object>} landmarks with their positions in the coordinates of the shape's file
 * @param {Object} side the shape: see drawn_shape.js
 * @returns {Object} `points`, null where a landmark is missing or far from the surface; `remark` on those that are far, or null
 */
export function onSurface(landmarks, side) {
  const given = landmarks.map(({ position }) => position);
  const nearest = given.map((position) => (position === null ? null : nearestTo(side, position)));
  const apart = nearest.map((point, i) => (point === null ? 0 : distance(side, point, given[i])));
  const isFar = apart.map((value) => value > FAR * Math.sqrt(side.shape.area));
  return {
    points: nearest.map((point, i) => (isFar[i] ? null : point)),
    remark: isFar.includes(true) ? remarkOn(landmarks, side, apart, isFar) : null,
  };
}

function nearestTo({ unrotated }, position) {
  const { origin, scale } = unrotated;
  return nearestPoint(unrotated, position.map((value, k) => (value - origin[k]) / scale));
}

const distance = (side, point, position) => Math.hypot(...inFile(side, point).map((value, k) => value - position[k]));

// As the client says it (client/isomatch/_landmarks/remarks.py).
function remarkOn(landmarks, side, apart, isFar) {
  const present = landmarks.flatMap(({ position }, i) => (position === null ? [] : [i]));
  const far = isFar.filter(Boolean).length;
  const worst = apart.indexOf(Math.max(...apart));
  const negated = present.map((i) => landmarks[i].position).map(([x, y, z]) => [-x, -y, z]);
  const turned = negated.map((position) => distance(side, nearestTo(side, position), position));
  const nearer = median(turned) < 0.5 * median(present.map((i) => apart[i]));
  return `${far} of ${present.length} landmarks ${far === 1 ? "is" : "are"} far from the surface, "${landmarks[worst].label}" by `
    + `${apart[worst].toPrecision(4)}; ${far === 1 ? "it is" : "they are"} left out. Are these landmarks of this mesh?`
    + (nearer ? " With x and y negated they are nearer: are the coordinates of the mesh named rightly?" : "");
}

const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];
