// Colours of the target, carried to the source by a dense map: a vertex has that of its image.

import { coarsened } from "./coarsen.js";

const NOWHERE = 200;

/**
 * @param {Array<Object>} sides source and target
 * @param {Object} dense the map, of the users' vertex numbers
 * @param {Float64Array} shades (3 V) those of the target's vertices
 * @returns {ArrayLike<number>} (3 V) those of the source as it is drawn
 */
export function carried([source, target], dense, shades) {
  const colors = new Uint8Array(source.geometry.positions.length).fill(NOWHERE);
  dense.source.forEach((number, at) => {
    const here = source.place(number);
    const there = target.place(dense.target[at]);
    if (here === undefined || there === undefined) return;
    for (let k = 0; k < 3; k++) colors[3 * here + k] = shades[3 * there + k];
  });
  return source.mesh.share === 1 ? colors : coarsened({ ...source.unturned, colors }).colors;
}
