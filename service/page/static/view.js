// Views of shapes, as in the service's pictures: the y or z axis up, looking along the thinnest
// direction; a target is rotated about the vertical until its matched points align.

import { cross } from "./geometry.js";

const AXES = [0, 1, 2];

/** Rows of a rotation: the directions to the right, up, and towards the viewer. */
export function sourceView(positions) {
  const extent = AXES.map((axis) => {
    const [low, high] = range(positions, axis);
    return high - low;
  });
  const thin = extent.indexOf(Math.min(...extent));
  const upright = [1, 2].filter((axis) => axis !== thin);
  const up = upright.reduce((best, axis) =>
    support(positions, axis) > support(positions, best) ? axis : best);
  const towards = thin;
  const unit = (axis) => AXES.map((k) => (k === axis ? 1 : 0));
  return [cross(unit(up), unit(towards)), unit(up), unit(towards)];
}

/** The view of a target: that of the source, rotated about the vertical to align matched points. */
export function targetView(rows, sourcePoints, targetPoints) {
  const here = level(rows, sourcePoints);
  const there = level(rows, targetPoints);
  let [real, imaginary] = [0, 0];
  here.forEach(([x, z], i) => {
    const [u, w] = there[i];
    real += u * x + w * z;
    imaginary += u * z - w * x;
  });
  const angle = Math.atan2(imaginary, real);
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const turn = [[c, 0, -s], [0, 1, 0], [s, 0, c]];
  return turn.map((row) => AXES.map((k) => AXES.reduce((sum, j) => sum + row[j] * rows[j][k], 0)));
}

/** (3 V) positions or normals in the coordinates of a view. */
export function rotated(rows, positions) {
  const out = new Float32Array(positions.length);
  for (let at = 0; at < positions.length; at += 3) {
    for (const k of AXES) {
      const row = rows[k];
      out[at + k] = row[0] * positions[at] + row[1] * positions[at + 1] + row[2] * positions[at + 2];
    }
  }
  return out;
}

function level(rows, points) {
  const flat = points.map((point) => {
    const [x, , z] = rotated(rows, point);
    return [x, z];
  });
  const middle = [0, 1].map((k) => flat.reduce((sum, place) => sum + place[k], 0) / flat.length);
  return flat.map((place) => [place[0] - middle[0], place[1] - middle[1]]);
}

function range(positions, axis) {
  let [low, high] = [Infinity, -Infinity];
  for (let at = axis; at < positions.length; at += 3) {
    low = Math.min(low, positions[at]);
    high = Math.max(high, positions[at]);
  }
  return [low, high];
}

// Spread of the lowest vertices when an axis points up: how firmly the shape stands.
function support(positions, up) {
  const [low, high] = range(positions, up);
  const limit = low + 0.1 * (high - low);
  const others = AXES.filter((axis) => axis !== up);
  const sums = others.map(() => [0, 0]);
  let count = 0;
  for (let at = 0; at < positions.length; at += 3) {
    if (positions[at + up] > limit) continue;
    count++;
    others.forEach((axis, i) => {
      sums[i][0] += positions[at + axis];
      sums[i][1] += positions[at + axis] ** 2;
    });
  }
  return sums.reduce((sum, [first, second]) =>
    sum + Math.sqrt(Math.max(0, second / count - (first / count) ** 2)), 0);
}
