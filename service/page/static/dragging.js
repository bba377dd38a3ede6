// Points of a drawing that are dragged with a mouse, a pen or a finger.

import { onScreen, sightAt } from "./camera.js";
import { isHidden } from "./surface_point.js";

/** Pixels from a point within which it is grasped, by a mouse and by a finger. */
const REACH = { mouse: 12, touch: 24 };
/** Pixels that the pointer may move without dragging. */
const STILL = 3;

/**
 * Let points be dragged, instead of turning the shape.
 * @param {Element} node of the drawing
 * @param {Object} mesh the surface that hides points, as it is drawn
 * @param {function(): Array<Array<number>>} points where they are now
 * @param {function(number, Object|null, boolean)} tell called with the index of the point, the line of sight under the
 *   pointer (see camera.js), null if it was not moved, and whether the pointer was released
 */
export function dragPoints(node, mesh, points, tell) {
  let held = null;
  const handle = (name, act) => node.addEventListener(name, act, { capture: true, passive: false });
  const stop = (event) => {
    event.preventDefault();
    event.stopPropagation();
  };
  const follow = (event, released) => {
    if (event.pointerId !== held?.pointer) return;
    stop(event);
    const { point, x, y } = held;
    held.moved ||= Math.hypot(event.clientX - x, event.clientY - y) > STILL;
    const { moved } = held;
    if (released) held = null;
    if (moved || released) tell(point, moved ? sightAt(node, event.clientX, event.clientY) : null, released);
  };
  // plotly.js listens to mouse and touch events; those of a mouse do not follow a pointer event that is stopped.
  handle("pointerdown", (event) => {
    const point = event.button === 0 && held === null ? pointUnder(event, node, mesh, points()) : null;
    if (point === null) return;
    stop(event);
    held = { point, pointer: event.pointerId, x: event.clientX, y: event.clientY, moved: false };
    node.setPointerCapture(event.pointerId);
  });
  handle("touchstart", (event) => held !== null && stop(event));
  handle("pointermove", (event) => follow(event, false));
  handle("pointerup", (event) => follow(event, true));
  handle("pointercancel", (event) => follow(event, true));
}

// The nearest point to the pointer that the surface does not hide, or null.
function pointUnder({ clientX, clientY, pointerType }, node, mesh, points) {
  const places = onScreen(node, points);
  const reach = REACH[pointerType] ?? REACH.mouse;
  const near = places.map(([x, y], i) => ({ i, away: Math.hypot(x - clientX, y - clientY) }))
    .filter(({ away }) => away <= reach).sort((a, b) => a.away - b.away);
  return near.find(({ i }) => !isHidden(mesh, points[i], sightAt(node, ...places[i]).towards))?.i ?? null;
}
