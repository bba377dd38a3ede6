// Confidence of carried landmarks, as the client computes it (client/isomatch/_landmarks/confidence.py).

import { pointAt } from "./geometry.js";
import { nearestPoint, positionOf } from "./surface_point.js";
import { nearestRotation } from "./view.js";

/** Radius over √area of the part of the surface whose distortion is measured. */
const RADIUS = 0.1;
/** Of the logarithms of round trip and distortion, and what is added to these. */
const [INTERCEPT, WEIGHTS, LEAST] = [-3.35, [-0.326, -2.16], [0.001, 0.01]];
const AXES = [0, 1, 2];
const apart = (a, b) => Math.hypot(...AXES.map((k) => a[k] - b[k]));

/**
 * Probabilities that landmarks are near their right places: that of the match, times one that falls with the distance of a
 * landmark from the image of its image, and with how far the map around it is from a rigid motion.
 * @param {Object} match its result, with a dense map
 * @param {number} end of the shape that the landmarks were given on, 0 for the source
 * @param {Array<Array<Object>>} points on the source and on the target, null where a landmark has none
 * @param {Array<Object>} sides both shapes: see drawn_shape.js
 * @returns {Array<number|null>} null where it is not known
 */
export function landmarkConfidences({ dense, confidence, overlap }, end, points, sides) {
  if (!confidence || !dense.inverse) return points[end].map(() => null);
  const [here, there] = [sides[end], sides[1 - end]];
  const maps = [
    imagesOf(dense.source, dense, sides[0], sides[1]), imagesOf(dense.inverse.target, dense.inverse, sides[1], sides[0]),
  ];
  const unit = unitOf(here);
  // From lengths here to lengths there: shapes are compared at one scale, parts at the scale that they were found at.
  const scale = overlap ? (end === 0 ? overlap.scale : 1 / overlap.scale) * here.geometry.scale / there.geometry.scale : unitOf(there) / unit;
  return points[end].map((point, i) => {
    const returned = point === null ? null : meanOf(maps[1 - end], points[1 - end][i]);
    if (returned === null) return null;
    const { positions } = here.geometry;
    const centre = positionOf(positions, point);
    const trip = apart(positionOf(positions, nearestPoint(here.geometry, returned)), centre) / unit;
    const part = partAround(here.geometry, maps[end], centre, RADIUS * unit);
    const images = part.map((v) => maps[end][v].map((value) => value / scale));
    const change = residual(part.map((v) => pointAt(positions, v)), images) / (RADIUS * unit);
    const logit = INTERCEPT + [trip, change].reduce((sum, value, k) => sum + WEIGHTS[k] * Math.log(value + LEAST[k]), 0);
    return confidence.probability / (1 + Math.exp(-logit));
  });
}

// √area in the units of the geometry.
const unitOf = ({ shape, geometry }) => Math.sqrt(shape.area) / geometry.scale;

// Positions of the images of the vertices; nothing for those that have none.
function imagesOf(numbers, { faces, barycentric }, here, there) {
  const found = new Array(here.geometry.positions.length / 3);
  numbers.forEach((number, row) => {
    const [place, corners] = [here.place(number), faces[row].map(there.place)];
    if (place !== undefined) found[place] = positionOf(there.geometry.positions, { corners, weights: barycentric[row] });
  });
  return found;
}

const meanOf = (images, { corners, weights }) => (corners.some((v) => images[v] === undefined) ? null
  : AXES.map((k) => corners.reduce((sum, v, at) => sum + weights[at] * images[v][k], 0)));

// Vertices with images within a radius of a point that hang together with the nearest one.
function partAround({ positions, faces }, images, centre, radius) {
  const distances = Float64Array.from(images, (image, v) => (image === undefined ? Infinity : apart(pointAt(positions, v), centre)));
  const near = [];
  let nearest = null;
  for (let f = 0; f < faces.length; f += 3) {
    const corners = [faces[f], faces[f + 1], faces[f + 2]];
    if (corners.some((v) => distances[v] === Infinity)) continue;
    for (const v of corners) if (nearest === null || distances[v] < distances[nearest]) nearest = v;
    near.push(corners);
  }
  const reached = new Set(near.filter((corners) => corners.includes(nearest)).flat());
  const inside = near.filter((corners) => corners.some((v) => distances[v] <= radius));
  for (let size = 0; size < reached.size;) {
    size = reached.size;
    for (const corners of inside) {
      if (corners.some((v) => reached.has(v))) for (const v of corners) if (distances[v] <= radius) reached.add(v);
    }
  }
  return [...reached];
}

// Root mean square distance of points after the best rotation and translation.
function residual(here, there) {
  const [a, b] = [here, there].map((points) => {
    const middle = AXES.map((k) => points.reduce((sum, point) => sum + point[k], 0) / points.length);
    return points.map((point) => point.map((value, k) => value - middle[k]));
  });
  const rows = nearestRotation(a, b);
  const squares = b.map((point, i) => apart(rows.map((row) => row.reduce((sum, value, k) => sum + value * point[k], 0)), a[i]) ** 2);
  return Math.sqrt(squares.reduce((sum, value) => sum + value, 0) / squares.length);
}
