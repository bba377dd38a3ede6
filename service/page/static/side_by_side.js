// Both shapes of a match, side by side, and what is done to both at once.

import { coarsened } from "./coarsen.js";
import { h, fill } from "./dom.js";
import { geometryOf, normals, places, pointAt } from "./geometry.js";
import { canDraw } from "./plotly.js";
import { Scene } from "./scene.js";
import { shareDrawn } from "./shape.js";
import { seen, stance, turned } from "./stance.js";
import { pointColors, tinted } from "./tint.js";

const LIFT = 0.012;
/** Points stand so far out of the surface, in halves of the shape's size. */

/**
 * Draw both shapes.
 * @param {Array<Object>} shapes the records of source and target
 * @returns {Promise<Object|null>} `show`, which draws one of the answers and returns the colours of
 *   its pairs; null where nothing can be drawn
 */
export async function pairOfScenes(place, result, shapes, selection, signal) {
  if (!canDraw()) {
    fill(place, h("p", { class: "faint" }, "This browser has no WebGL, which shapes are drawn with."));
    return null;
  }
  if (shapes.some((shape) => shape.id === null)) {
    fill(place, h("p", { class: "faint" }, "A shape is no longer kept: nothing can be drawn."));
    return null;
  }
  const sides = await Promise.all(shapes.map(async (shape) => {
    const geometry = await geometryOf(shape.id, signal);
    return { shape, geometry, mesh: coarsened(geometry), normals: normals(geometry.positions, geometry.faces), place: places(geometry) };
  }));
  turn(sides, result.correspondences);
  const options = { numbered: true, together: true, tinted: true };
  const nodes = sides.map(({ shape }, at) => h("div", {
    class: "scene", role: "img", "data-side": ["source", "target"][at],
    "aria-label": `${shape.name} in three dimensions, with the matched points`,
  }));
  let again = () => {};
  fill(place, h("div", { class: "pair" }, sides.map(({ shape, mesh }, at) => h("figure", {}, nodes[at],
    h("figcaption", {}, shape.name, h("span", { class: "faint" }, " ", shareDrawn(mesh.share, shape.faces)))))),
  h("p", { class: "checks" },
    toggle("Numbers", options, "numbered", () => again()),
    toggle("Turn both together", options, "together", () => {}),
    toggle("Surfaces in the colours of the nearest matched points", options, "tinted", () => again())));
  const scenes = sides.map(({ mesh }, at) => new Scene(nodes[at], mesh, signal));

  const show = async ({ correspondences, refined }) => {
    const points = pointsOf(sides, correspondences, refined);
    const colors = pointColors(points[0]);
    const names = correspondences.map((_, pair) => String(pair + 1));
    again = () => Promise.all(scenes.map((scene, at) => {
      const { mesh } = sides[at];
      const tint = options.tinted && colors.length > 0;
      return scene.show(tint ? tinted(mesh, points[at], colors) : mesh.colors, {
        points: points[at], colors, names, numbered: options.numbered, ring: selection.shown,
      });
    }));
    await again();
    if (signal.aborted) return colors;
    if (place.dataset.drawn === undefined) join(scenes, selection, options);
    place.dataset.drawn = String(correspondences.length);
    return colors;
  };
  return { show };
}

function toggle(text, options, name, changed) {
  return h("label", { class: "check" }, h("input", {
    type: "checkbox", checked: options[name],
    onchange: (event) => {
      options[name] = event.target.checked;
      changed();
    },
  }), " ", text);
}

// Both stand upright, seen from the same side; all places are then as they are seen.
function turn(sides, pairs) {
  const [source, target] = sides;
  const rows = [stance(source.geometry.positions)];
  const matched = pairs.map((pair) => [source.place(pair.source), target.place(pair.target)])
    .filter(([here, there]) => here !== undefined && there !== undefined);
  const at = (side, k) => matched.map((pair) => pointAt(side.geometry.positions, pair[k]));
  rows.push(matched.length >= 3 ? turned(rows[0], at(source, 0), at(target, 1)) : rows[0]);
  sides.forEach((side, k) => {
    side.geometry = { ...side.geometry, positions: seen(rows[k], side.geometry.positions) };
    side.normals = seen(rows[k], side.normals);
    side.mesh = { ...side.mesh, positions: seen(rows[k], side.mesh.positions) };
  });
}

function pointsOf([source, target], pairs, refined) {
  const there = (pair, at) => refined === null
    ? lifted(target, [target.place(pair.target)], [1])
    : lifted(target, refined[at].vertices.map(target.place), refined[at].weights);
  return [pairs.map((pair) => lifted(source, [source.place(pair.source)], [1])), pairs.map(there)];
}

function lifted(side, vertices, weights) {
  const { positions } = side.geometry;
  const mean = (values) => [0, 1, 2].map((k) =>
    vertices.reduce((sum, v, at) => sum + weights[at] * values[3 * v + k], 0));
  const place = mean(positions);
  const normal = mean(side.normals);
  const length = Math.hypot(...normal) || 1;
  return place.map((value, k) => value + (LIFT * normal[k]) / length);
}

function join(scenes, selection, options) {
  let moving = false;
  scenes.forEach((scene, at) => {
    scene.watch((pair) => selection.hover(pair), (pair) => selection.choose(pair));
    scene.follow(async (camera) => {
      if (moving || !options.together) return;
      moving = true;
      await scenes[1 - at].look(camera);
      moving = false;
    });
  });
  selection.addEventListener("change", () => scenes.forEach((scene) => scene.ring(selection.shown)));
}
