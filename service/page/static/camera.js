// The camera of a drawing: where points are on the screen, and lines of sight. The projection is orthographic.

import { cross } from "./geometry.js";

const AXES = [0, 1, 2];
const dot = (a, b) => AXES.reduce((sum, k) => sum + a[k] * b[k], 0);

/**
 * The rows of the map from points to screen coordinates, u to the right and v up, both from -1 to 1, and depth.
 *
 * plotly.js has no call for it, so its matrices are taken; `camera` of the layout gives them only after
 * the scalings of axes and of the window.
 */
function projection(node) {
  const { glplot, dataScale } = node._fullLayout.scene._scene;
  const { model, view, projection: flat } = glplot.cameraParams;
  const times = (a, b) => a.map((_, at) => [0, 1, 2, 3].reduce((sum, k) => sum + a[4 * k + (at % 4)] * b[4 * Math.floor(at / 4) + k], 0));
  const whole = times(Array.from(flat), times(Array.from(view), Array.from(model)));
  return AXES.map((r) => ({ row: AXES.map((k) => whole[4 * k + r] * dataScale[k]), shift: whole[12 + r] }));
}

/** Positions of points in the window, in pixels. */
export function onScreen(node, points) {
  const [across, up] = projection(node);
  const box = node.getBoundingClientRect();
  return points.map((point) => [
    box.x + 0.5 * box.width * (1 + dot(across.row, point) + across.shift),
    box.y + 0.5 * box.height * (1 - dot(up.row, point) - up.shift),
  ]);
}

/**
 * The line of sight through a pixel of the window.
 * @returns {Object} `origin`, a point of it, and `towards`, the unit vector to the viewer
 */
export function sightAt(node, x, y) {
  const [across, up, depth] = projection(node);
  const box = node.getBoundingClientRect();
  const u = (2 * (x - box.x)) / box.width - 1 - across.shift;
  const v = 1 - (2 * (y - box.y)) / box.height - up.shift;
  const along = cross(across.row, up.row);
  const [first, second] = [cross(up.row, along), cross(along, across.row)];
  const square = dot(along, along);
  // Depth grows away from the viewer.
  const sign = dot(along, depth.row) > 0 ? -1 : 1;
  return {
    origin: AXES.map((k) => (u * first[k] + v * second[k]) / square),
    towards: along.map((value) => (sign * value) / Math.sqrt(square)),
  };
}

/** Unit vectors to the right and up on the screen. */
export const screenAxes = (node) => projection(node).slice(0, 2).map(({ row }) =>
  row.map((value) => value / Math.hypot(...row)));
