// Views of shapes, as in the service's pictures: the y or z axis vertical, looking along the thinnest
// direction; a target is rotated until its matched points are nearest to those of the source.

import { cross } from "./geometry.js";
import { leastDirection } from "./principal_direction.js";

const AXES = [0, 1, 2];
/** Cosine above which an axis is the thin direction, which is not up. */
const THIN = 0.75;
/** Share of the height, from the bottom, whose vertices are the base of a shape. */
const BASE = 0.2;
/** Factor by which squared distances must fall for a target to be tilted (worker/pictures/view.py). */
const TILT = 2;
/** Squared distances of points that are aligned, as single precision has them. */
const ROUNDING = 1e-6;
/** Steps of the power iteration. */
const STEPS = 300;

/** Rows of a rotation of a mesh: the directions to the right, up, and towards the viewer. */
export function sourceView({ positions, faces }) {
  const thin = leastDirection(positions);
  const axis = [1, 2].filter((k) => Math.abs(thin[k]) <= THIN).reduce((best, k) =>
    (support(positions, k) > support(positions, best) ? k : best));
  const vertical = standsOnItsHead(positions, faces, axis) ? -1 : 1;
  const up = AXES.map((k) => (k === axis ? vertical : 0));
  const across = thin.map((value, k) => (k === axis ? 0 : value));
  // Eigenvectors have no sign: face the positive side of the axis that is nearest.
  const nearest = across.reduce((best, value) => (Math.abs(value) > Math.abs(best) ? value : best));
  const length = Math.sign(nearest) * Math.hypot(...across);
  const towards = across.map((value) => value / length);
  return [cross(up, towards), up, towards];
}

/**
 * The view of a target in which its matched points are nearest to those of the source: rotated about the
 * vertical, unless a rotation about another axis brings them much nearer.
 */
export function targetView(rows, sourcePoints, targetPoints) {
  const [here, there] = [sourcePoints, targetPoints].map((points) => ofUnitSpread(rows, points));
  const [c, s] = upright(here, there);
  const turns = [[[c, 0, -s], [0, 1, 0], [s, 0, c]], nearestRotation(here, there)];
  const [vertical, free] = turns.map((turn) => there.reduce((sum, point, i) =>
    sum + times(turn, point).reduce((square, value, k) => square + (value - here[i][k]) ** 2, 0), 0));
  const turn = turns[vertical <= TILT * free + ROUNDING ? 0 : 1];
  return turn.map((row) => AXES.map((k) => AXES.reduce((sum, j) => sum + row[j] * rows[j][k], 0)));
}

const times = (turn, point) => turn.map((row) => row.reduce((sum, value, k) => sum + value * point[k], 0));

function upright(here, there) {
  let [real, imaginary] = [0, 0];
  here.forEach(([x, , z], i) => {
    const [u, , w] = there[i];
    real += u * x + w * z;
    imaginary += u * z - w * x;
  });
  const size = Math.hypot(real, imaginary);
  return size === 0 ? [1, 0] : [real / size, imaginary / size];
}

/**
 * The rotation that brings centred points nearest to others.
 *
 * Horn's quaternion (1987), by power iteration: the matrix is shifted so that its greatest eigenvalue is the largest.
 */
export function nearestRotation(here, there) {
  const m = AXES.map((a) => AXES.map((b) => here.reduce((sum, point, i) => sum + there[i][a] * point[b], 0)));
  const trace = m[0][0] + m[1][1] + m[2][2];
  const skew = [m[1][2] - m[2][1], m[2][0] - m[0][2], m[0][1] - m[1][0]];
  const horn = [[trace, ...skew], ...AXES.map((a) => [skew[a], ...AXES.map((b) => m[a][b] + m[b][a] - (a === b ? trace : 0))])];
  const shift = Math.max(...horn.map((row) => row.reduce((sum, value) => sum + Math.abs(value), 0))) || 1;
  let q = [1, 0.1, 0.1, 0.1];
  for (let step = 0; step < STEPS; step++) {
    const next = horn.map((row, a) => row.reduce((sum, value, b) => sum + value * q[b], shift * q[a]));
    const size = Math.hypot(...next);
    q = next.map((value) => value / size);
  }
  const [w, x, y, z] = q;
  return [
    [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
    [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
    [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
  ];
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

/** (3 V) positions about the middle of their bounding box. */
export function centred(positions) {
  const middle = AXES.map((k) => {
    const [low, high] = range(positions, k);
    return 0.5 * (low + high);
  });
  return positions.map((value, at) => value - middle[at % 3]);
}

// Points in the coordinates of a view, about their centroid and of unit spread.
function ofUnitSpread(rows, points) {
  const seen = points.map((point) => [...rotated(rows, point)]);
  const middle = AXES.map((k) => seen.reduce((sum, point) => sum + point[k], 0) / seen.length);
  const moved = seen.map((point) => point.map((value, k) => value - middle[k]));
  const spread = Math.sqrt(moved.flat().reduce((sum, value) => sum + value * value, 0) / (3 * moved.length)) || 1;
  return moved.map((point) => point.map((value) => value / spread));
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
  const { a, b } = spread(positions, up, (value) => value <= low + 0.1 * (high - low));
  return Math.sqrt(a) + Math.sqrt(b);
}

// Variances `a` and `b` of the other two coordinates of vertices, chosen by one, and their covariance `ab`.
function spread(positions, axis, isChosen) {
  const [i, j] = AXES.filter((k) => k !== axis);
  let [count, x, y] = [0, 0, 0];
  const chosen = [];
  for (let at = 0; at < positions.length; at += 3) {
    if (!isChosen(positions[at + axis])) continue;
    chosen.push(at);
    count++;
    x += positions[at + i];
    y += positions[at + j];
  }
  let [a, b, ab] = [0, 0, 0];
  for (const at of chosen) {
    const [u, v] = [positions[at + i] - x / count, positions[at + j] - y / count];
    a += u * u / count;
    b += v * v / count;
    ab += u * v / count;
  }
  return { a, b, ab };
}

// Whether a shape stands better upside down, by all that bodies on their feet have in common: their weight is high, their
// base is broad, and limbs hang from them.
function standsOnItsHead(positions, faces, axis) {
  const [low, high] = range(positions, axis);
  const span = high - low;
  const up = Float64Array.from({ length: positions.length / 3 }, (_, v) => (positions[3 * v + axis] - low) / span);
  if (up.reduce((sum, height) => sum + height, 0) >= 0.5 * up.length) return false;
  const [foot, head] = [(value) => value <= low + BASE * span, (value) => value >= high - BASE * span]
    .map((isLowest) => spread(positions, axis, isLowest)).map(({ a, b, ab }) => a * b - ab * ab);
  return head > foot && limbs(up.map((height) => 1 - height), faces) > limbs(up, faces);
}

// How far limbs hang: the total persistence of components of sublevel sets, but for a constant. A component begins at a
// vertex, and ends at an edge of the minimum spanning tree by the heights of upper ends.
function limbs(heights, faces) {
  const next = (at) => faces[at % 3 === 2 ? at - 2 : at + 1];
  const upper = Float64Array.from(faces, (v, at) => Math.max(heights[v], heights[next(at)]));
  const parents = Int32Array.from(heights.keys());
  const rootOf = (v) => {
    let root = v;
    while (parents[root] !== root) root = parents[root] = parents[parents[root]];
    return root;
  };
  let sum = 0;
  for (const at of Uint32Array.from(faces.keys()).sort((one, other) => upper[one] - upper[other])) {
    const [one, other] = [rootOf(faces[at]), rootOf(next(at))];
    if (one === other) continue;
    parents[one] = other;
    sum += upper[at];
  }
  for (const v of new Set(faces)) sum -= heights[v];
  return sum;
}
