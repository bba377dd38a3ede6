// Colours: one for each matched point, the same on both shapes, and surfaces tinted by them.

const PALE = 0.5;
const ROUNDS = 24;

/**
 * Colours of points: hue by direction from the middle, paler near it, so that neighbours are alike.
 * @param {Array<Array<number>>} points as they are seen
 * @returns {Array<Array<number>>} red, green and blue, 0..255
 */
export function pointColors(points) {
  if (points.length === 0) return [];
  const middle = [0, 1].map((k) => {
    const values = points.map((point) => point[k]);
    return 0.5 * (Math.min(...values) + Math.max(...values));
  });
  const offsets = points.map((point) => [point[0] - middle[0], point[1] - middle[1]]);
  const reach = offsets.map(([x, y]) => Math.hypot(x, y));
  const most = Math.max(...reach) || 1;
  return offsets.map(([x, y], i) =>
    fromHsv((Math.atan2(y, x) / (2 * Math.PI) + 1) % 1, 0.55 + (0.4 * reach[i]) / most, 0.84));
}

/** Colours that differ from one another: that of the i-th of any number. */
export const distinct = (i) => fromHsv((0.05 + 0.618034 * i) % 1, 0.85, 0.8);

export const css = ([red, green, blue]) => `rgb(${red},${green},${blue})`;

/**
 * Tint a surface: each vertex has the colour of the matched point that is nearest over edges, and
 * the borders between them are smoothed.
 * @param {Object} mesh `positions` and `faces`
 * @param {Array<Array<number>>} points where the matched points lie
 * @param {Array<Array<number>>} colors theirs
 * @returns {Float64Array} (3 V), 0..255
 */
export function tinted({ positions, faces }, points, colors) {
  const count = positions.length / 3;
  const { first, beside } = neighbours(faces, count);
  const owner = new Int32Array(count).fill(-1);
  let front = points.map((point, i) => {
    const place = nearest(positions, point);
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
  owner.forEach((i, v) => shades.set(i < 0 ? grey : colors[i], 3 * v));
  for (let round = 0; round < ROUNDS; round++) shades = smoothed(shades, first, beside, fixed);
  return shades.map((value) => PALE * value + (1 - PALE) * 235);
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

function nearest(positions, [x, y, z]) {
  let [best, least] = [0, Infinity];
  for (let v = 0; 3 * v < positions.length; v++) {
    const distance = (positions[3 * v] - x) ** 2 + (positions[3 * v + 1] - y) ** 2
      + (positions[3 * v + 2] - z) ** 2;
    if (distance < least) [best, least] = [v, distance];
  }
  return best;
}

function fromHsv(hue, saturation, value) {
  const channel = (n) => {
    const k = (n + 6 * hue) % 6;
    const share = Math.max(0, Math.min(k, 4 - k, 1));
    return Math.round(255 * value * (1 - saturation * share));
  };
  return [channel(5), channel(3), channel(1)];
}
