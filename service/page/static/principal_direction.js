// The principal directions of points.

const AXES = [0, 1, 2];
/** Rounds of rotations; the method converges quadratically. */
const ROUNDS = 8;

/** The unit vector along which points vary least: an eigenvector of their covariance, by Jacobi's method. */
export function leastDirection(positions) {
  const matrix = covariance(positions);
  const vectors = AXES.map((a) => AXES.map((b) => (a === b ? 1 : 0)));
  for (let round = 0; round < ROUNDS; round++) {
    for (const [p, q] of [[0, 1], [0, 2], [1, 2]]) rotate(matrix, vectors, p, q);
  }
  const least = AXES.reduce((best, k) => (matrix[k][k] < matrix[best][best] ? k : best));
  return AXES.map((k) => vectors[k][least]);
}

function covariance(positions) {
  const count = positions.length / 3;
  const middle = [0, 0, 0];
  for (let at = 0; at < positions.length; at++) middle[at % 3] += positions[at] / count;
  const sums = AXES.map(() => [0, 0, 0]);
  for (let at = 0; at < positions.length; at += 3) {
    for (const a of AXES) {
      for (const b of AXES) sums[a][b] += (positions[at + a] - middle[a]) * (positions[at + b] - middle[b]) / count;
    }
  }
  return sums;
}

// The rotation of coordinates p and q after which their entry off the diagonal is 0.
function rotate(matrix, vectors, p, q) {
  if (matrix[p][q] === 0) return;
  const theta = (matrix[q][q] - matrix[p][p]) / (2 * matrix[p][q]);
  const t = (theta >= 0 ? 1 : -1) / (Math.abs(theta) + Math.sqrt(theta * theta + 1));
  const c = 1 / Math.sqrt(t * t + 1);
  const s = t * c;
  for (const rows of [matrix, vectors]) {
    for (const row of rows) [row[p], row[q]] = [c * row[p] - s * row[q], s * row[p] + c * row[q]];
  }
  [matrix[p], matrix[q]] = [
    AXES.map((k) => c * matrix[p][k] - s * matrix[q][k]), AXES.map((k) => s * matrix[p][k] + c * matrix[q][k]),
  ];
}
