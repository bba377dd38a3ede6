// Views: rows of rotations, the directions to the right, up, and towards the viewer. A shape has that of its record; a target
// is rotated until its matched points are nearest to those of the source.

const AXES = [0, 1, 2];
/** Factor by which squared distances must fall for a target to be tilted (worker/pictures/view.py). */
const TILT = 2;
/** Squared distances of points that are aligned, as single precision has them. */
const ROUNDING = 1e-6;
/** Squarings, after which only the greatest eigenvalue is left. */
const SQUARINGS = 30;
/** The view of what earlier versions stored. */
export const UPRIGHT = AXES.map((a) => AXES.map((b) => (a === b ? 1 : 0)));

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
 * Horn's quaternion (1987): the eigenvector of the greatest eigenvalue, which is the largest of the shifted matrix. Its
 * power 2^30 is the projection to it, even where eigenvalues are close, as those of elongated shapes are.
 */
function nearestRotation(here, there) {
  const m = AXES.map((a) => AXES.map((b) => here.reduce((sum, point, i) => sum + there[i][a] * point[b], 0)));
  const trace = m[0][0] + m[1][1] + m[2][2];
  const skew = [m[1][2] - m[2][1], m[2][0] - m[0][2], m[0][1] - m[1][0]];
  const horn = [[trace, ...skew], ...AXES.map((a) => [skew[a], ...AXES.map((b) => m[a][b] + m[b][a] - (a === b ? trace : 0))])];
  const shift = Math.max(...horn.map((row) => row.reduce((sum, value) => sum + Math.abs(value), 0))) || 1;
  let power = horn.map((row, a) => row.map((value, b) => value + (a === b ? shift : 0)));
  for (let step = 0; step < SQUARINGS; step++) {
    const size = power.reduce((sum, row, a) => sum + row[a], 0);
    power = power.map((row) => power.map((other) => row.reduce((sum, value, k) => sum + value * other[k], 0) / size ** 2));
  }
  const sizes = power.map((row) => Math.hypot(...row));
  const longest = sizes.indexOf(Math.max(...sizes));
  const q = power[longest].map((value) => value / sizes[longest]);
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
