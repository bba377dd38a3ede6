// Simplification for drawing by vertex clustering: the vertices in one cell of a grid become one.

/** Most triangles to draw, so that turning a shape is smooth on a phone. */
export const MOST = 24000;
/** Most attempts to find the grid size that leaves nearly MOST triangles. */
const ROUNDS = 4;

/**
 * Simplify a mesh of more than `most` triangles.
 * @returns {Object} `positions`, `faces`, `colors`; `share`, the fraction of triangles that is left;
 *   `reduced`, which takes (3 V) values of the vertices to those of the vertices that are left; and
 *   `left`, which takes a vertex to the one that is left of it
 */
export function simplified({ positions, faces, colors }, most = MOST) {
  const count = faces.length / 3;
  if (count <= most) return { positions, faces, colors, share: 1, reduced: (values) => values, left: (v) => v };
  // A surface in a grid of n³ cells meets about n² of them.
  let cells = Math.sqrt(most / 2);
  let owner = owners(positions, cells);
  let kept = survivors(faces, owner.of);
  for (let round = 0; round < ROUNDS; round++) {
    const ratio = most / (kept.length / 3);
    if (ratio >= 1 && ratio < 1.3) break;
    cells *= Math.sqrt(0.9 * ratio);
    owner = owners(positions, cells);
    kept = survivors(faces, owner.of);
  }
  const reduced = (values) => means(values, owner, owner.count, Float32Array);
  return {
    positions: reduced(positions), reduced, left: (v) => owner.of[v], faces: kept, share: kept.length / faces.length,
    colors: colors === null ? null : means(colors, owner, owner.count, Uint8Array),
  };
}

// Loops without closures and small arrays: a mesh of 500,000 triangles must not hold up the page.
function owners(positions, cells) {
  const known = new Map();
  const of = new Uint32Array(positions.length / 3);
  const side = Math.ceil(cells) + 1;
  const half = 0.5 * cells;
  for (let v = 0, at = 0; v < of.length; v++, at += 3) {
    const name = (Math.floor(half + half * positions[at]) * side + Math.floor(half + half * positions[at + 1])) * side
      + Math.floor(half + half * positions[at + 2]);
    let place = known.get(name);
    if (place === undefined) {
      place = known.size;
      known.set(name, place);
    }
    of[v] = place;
  }
  return { of, count: known.size };
}

function means(values, { of }, size, kind) {
  const sums = new Float64Array(3 * size);
  const members = new Uint32Array(size);
  for (let v = 0; v < of.length; v++) {
    const place = of[v];
    members[place]++;
    for (let k = 0; k < 3; k++) sums[3 * place + k] += values[3 * v + k];
  }
  return kind.from(sums, (sum, at) => sum / members[Math.floor(at / 3)]);
}

function survivors(faces, of) {
  const left = new Uint32Array(faces.length);
  let end = 0;
  for (let f = 0; f < faces.length; f += 3) {
    const [a, b, c] = [of[faces[f]], of[faces[f + 1]], of[faces[f + 2]]];
    if (a === b || b === c || c === a) continue;
    left[end++] = a;
    left[end++] = b;
    left[end++] = c;
  }
  return left.slice(0, end);
}
