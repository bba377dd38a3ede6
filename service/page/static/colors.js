// Colours of matched points, the same on both shapes, and of the surfaces around them.

import { nearestVertex } from "./geometry.js";

/** Share of the points' colours in the surface's; the rest is light grey. */
const PALE = 0.5;
/** The same of a shape's own colours, which may be black. */
const PALE_OWN = 0.3;
const LIGHT = 235;
/** Rounds of smoothing of the borders between the colours of points. */
const ROUNDS = 24;
/** Least extent of points that counts, as a share of the other: rounding errors have no direction. */
const THINNEST = 1e-6;
/** Grey level of vertices that a dense map leaves out. */
const UNMAPPED = 200;

/**
 * Colours of points: hue by direction from the middle, paler near it, so that neighbours are similar.
 * Offsets are in units of half the extents, so that all hues are used on a tall or broad shape.
 * @param {Array<Array<number>>} points in the coordinates of the view
 * @returns {Array<Array<number>>} red, green and blue, 0..255
 */
export function pointColors(points) {
  if (points.length === 0) return [];
  const ranges = [0, 1].map((k) => {
    const values = points.map((point) => point[k]);
    return [Math.min(...values), Math.max(...values)];
  });
  const middle = ranges.map(([low, high]) => 0.5 * (low + high));
  const half = ranges.map(([low, high]) => 0.5 * (high - low));
  const least = Math.max(THINNEST * Math.max(...half), Number.MIN_VALUE);
  const offsets = points.map((point) => [0, 1].map((k) => (point[k] - middle[k]) / Math.max(half[k], least)));
  const reach = offsets.map(([x, y]) => Math.hypot(x, y));
  const most = Math.max(...reach) || 1;
  return offsets.map(([x, y], i) =>
    fromHsv((Math.atan2(y, x) / (2 * Math.PI) + 1) % 1, 0.55 + (0.4 * reach[i]) / most, 0.84));
}

/** The i-th of a sequence of distinct colours; hues advance by the golden ratio. */
export const distinct = (i) => fromHsv((0.05 + 0.618034 * i) % 1, 0.85, 0.8);

const pale = (value, share) => share * value + (1 - share) * LIGHT;

/** Own colours of a surface, or null; pale where names of points, which are dark, are drawn in front of them. */
export const behindNames = (colors, named) => (named && colors !== null
  ? Float64Array.from(colors, (value) => pale(value, PALE_OWN)) : colors);

export const css = ([red, green, blue]) => `rgb(${red},${green},${blue})`;

/**
 * Colour a surface: each vertex has the colour of the matched point that is the fewest edges away;
 * the borders between colours are smoothed.
 * @param {Object} mesh `positions` and `faces`
 * @param {Array<Array<number>>} points positions of the matched points
 * @param {Array<Array<number>>} colors colours of the matched points
 * @returns {Float64Array} (3 V), 0..255
 */
export function surfaceColors({ positions, faces }, points, colors) {
  const count = positions.length / 3;
  const { first, beside } = neighbours(faces, count);
  const owner = new Int32Array(count).fill(-1);
  let front = points.map((point, i) => {
    const place = nearestVertex(positions, point);
    owner[place] = i;
    return place;
  });
  const fixed = new Set(front);
  while (front.length > 0) {
    const next = [];
    for (const v of front) {
      for (let at = first[v]; at < first[v + 1]; at++) {
        const other = beside[at];
        if (owner[other] >= 0) continue;
        owner[other] = owner[v];
        next.push(other);
      }
    }
    front = next;
  }
  const grey = [200, 203, 208];
  let shades = new Float64Array(3 * count);
  for (let v = 0; v < count; v++) {
    const color = owner[v] < 0 ? grey : colors[owner[v]];
    for (let k = 0; k < 3; k++) shades[3 * v + k] = color[k];
  }
  for (let round = 0; round < ROUNDS; round++) shades = smoothed(shades, first, beside, fixed);
  return shades.map((value) => pale(value, PALE));
}

/**
 * Transfer colours from the target to the source by a dense map.
 * @param {Array<Object>} shapes source and target as they are drawn
 * @param {Object} dense the map, of indices in the users' files
 * @param {ArrayLike<number>} colors (3 V) colours of the drawn vertices of the target
 * @returns {ArrayLike<number>} (3 V) colours of the drawn vertices of the source
 */
export function transferredColors([source, target], dense, colors) {
  const found = new Uint8Array(source.geometry.positions.length).fill(UNMAPPED);
  dense.source.forEach((number, at) => {
    const here = source.place(number);
    const there = target.place(dense.target[at]);
    if (here === undefined || there === undefined) return;
    const drawn = target.mesh.left(there);
    for (let k = 0; k < 3; k++) found[3 * here + k] = colors[3 * drawn + k];
  });
  return source.mesh.reduced(found);
}

function smoothed(shades, first, beside, fixed) {
  const out = shades.slice();
  for (let v = 0; v + 1 < first.length; v++) {
    const degree = first[v + 1] - first[v];
    if (degree === 0 || fixed.has(v)) continue;
    for (let k = 0; k < 3; k++) {
      let sum = 0;
      for (let at = first[v]; at < first[v + 1]; at++) sum += shades[3 * beside[at] + k];
      out[3 * v + k] = 0.5 * shades[3 * v + k] + (0.5 * sum) / degree;
    }
  }
  return out;
}

// The vertices beside v are beside[first[v]], ..., beside[first[v + 1] - 1].
function neighbours(faces, count) {
  const first = new Uint32Array(count + 1);
  for (const v of faces) first[v + 1] += 2;
  for (let v = 0; v < count; v++) first[v + 1] += first[v];
  const place = first.slice();
  const beside = new Uint32Array(2 * faces.length);
  for (let f = 0; f < faces.length; f += 3) {
    for (let k = 0; k < 3; k++) {
      const [v, a, b] = [faces[f + k], faces[f + ((k + 1) % 3)], faces[f + ((k + 2) % 3)]];
      beside[place[v]++] = a;
      beside[place[v]++] = b;
    }
  }
  return { first, beside };
}

function fromHsv(hue, saturation, value) {
  const channel = (n) => {
    const k = (n + 6 * hue) % 6;
    const share = Math.max(0, Math.min(k, 4 - k, 1));
    return Math.round(255 * value * (1 - saturation * share));
  };
  return [channel(5), channel(3), channel(1)];
}
