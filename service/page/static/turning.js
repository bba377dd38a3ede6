// The camera of a drawing, moved by keys.

import { cross } from "./geometry.js";

/** Radians by which a key turns. */
const STEP = Math.PI / 12;
/** Factor by which a key enlarges. */
const GROWTH = 1.25;
const ROUNDING = 1e-9;
const TURNS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const SIZES = { "+": GROWTH, "=": GROWTH, "-": 1 / GROWTH };

export const ABOUT_KEYS = "Arrow keys turn the shape, plus and minus change its size, Home shows it as at first.";

const rows = ({ x, y, z }) => [x, y, z];
const named = ([x, y, z]) => ({ x, y, z });
const unit = (vector) => vector.map((value) => value / Math.hypot(...vector));

/** Whether two views are the same, up to rounding. */
export function isSameView(one, other) {
  const numbers = ({ camera, aspectratio }) =>
    [camera.eye, camera.center, camera.up, aspectratio].flatMap(rows);
  const others = numbers(other);
  return numbers(one).every((value, at) => Math.abs(value - others[at]) < ROUNDING);
}

/**
 * The view after a key.
 * @param {Object} view `camera`, with `eye`, `center` and `up`, and `aspectratio`, as plotly.js has them
 * @param {Object} first the view that Home returns to
 * @returns {Object|null} null if the key does nothing
 */
export function viewAfter(key, { camera, aspectratio }, first) {
  if (key === "Home") return first;
  if (SIZES[key] !== undefined) {
    return { camera, aspectratio: named(rows(aspectratio).map((value) => value * SIZES[key])) };
  }
  if (TURNS[key] === undefined) return null;
  const [across, over] = TURNS[key];
  const eye = rows(camera.eye);
  const right = unit(cross(rows(camera.up), eye));
  const up = unit(cross(eye, right));
  const turned = (vector) => rotated(rotated(vector, up, -across * STEP), right, over * STEP);
  return { camera: { ...camera, eye: named(turned(eye)), up: named(turned(up)) }, aspectratio };
}

// Rodrigues' formula, about a unit vector.
function rotated(vector, axis, angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const along = vector.reduce((sum, value, k) => sum + value * axis[k], 0);
  const side = cross(axis, vector);
  return vector.map((value, k) => c * value + s * side[k] + (1 - c) * along * axis[k]);
}
