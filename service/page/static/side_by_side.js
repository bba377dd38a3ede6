// The shapes of a match, side by side, and what is done to both at once.

import { carried } from "./carry.js";
import { h, fill } from "./dom.js";
import { pointAt } from "./geometry.js";
import { canDraw } from "./plotly.js";
import { Scene } from "./scene.js";
import { shareDrawn } from "./shape.js";
import { lifted, prototypeSide, sideOf, stand } from "./side.js";
import { stance, turned } from "./stance.js";
import { pointColors, tinted } from "./tint.js";

/**
 * Draw the shapes of a match.
 * @param {Object} source its record, or that of the prototype
 * @param {Object} target its record
 * @returns {Promise<Object|null>} `show`, which draws one of the answers and returns the colours of
 *   its pairs; null where nothing can be drawn
 */
export async function pairOfScenes(place, result, source, target, selection, signal) {
  const learned = result.source_kind === "prototype";
  const lacking = whatIsLacking(learned ? [target] : [source, target]);
  if (lacking !== null) {
    fill(place, h("p", { class: "faint" }, lacking));
    return null;
  }
  const sides = (await Promise.all([
    learned ? prototypeSide(source, signal) : sideOf(source, "source", signal), sideOf(target, "target", signal),
  ])).filter((side) => side !== null);
  turn(sides, result.correspondences);
  const options = { numbered: true, together: true, tinted: true };
  let again = () => {};
  const nodes = sides.map(({ shape, end }) => h("div", {
    class: "scene", role: "img", "data-side": end,
    "aria-label": `${shape.name} in three dimensions, with the matched points`,
  }));
  fill(place, h("div", { class: "pair" }, sides.map(caption(nodes))), h("p", { class: "checks" },
    toggle("Numbers", options, "numbered", () => again()),
    sides.length === 1 ? null : toggle("Turn both together", options, "together", () => {}),
    toggle(tintText(result, sides), options, "tinted", () => again())));
  const scenes = sides.map(({ mesh }, at) => new Scene(nodes[at], mesh, signal));

  const show = async ({ correspondences, refined, dense }) => {
    const points = sides.map((side) => pointsOf(side, correspondences, refined));
    const colors = pointColors(points[0]);
    const names = correspondences.map((_, pair) => String(pair + 1));
    const shades = shadesOf(sides, points, colors, dense);
    again = () => Promise.all(scenes.map((scene, at) =>
      scene.show(options.tinted && colors.length > 0 ? shades(at) : sides[at].mesh.colors, {
        points: points[at], colors, names, numbered: options.numbered, ring: selection.shown,
      })));
    await again();
    if (signal.aborted) return colors;
    if (place.dataset.drawn === undefined) join(scenes, selection, options);
    place.dataset.drawn = String(correspondences.length);
    return colors;
  };
  return { show };
}

function whatIsLacking(shapes) {
  if (shapes.some((shape) => shape.id === null)) return "A shape is no longer kept: nothing can be drawn.";
  return canDraw() ? null : "This browser has no WebGL, which shapes are drawn with.";
}

const caption = (nodes) => ({ shape, mesh }, at) => h("figure", {}, nodes[at],
  h("figcaption", {}, shape.name, h("span", { class: "faint" }, " ", shareDrawn(mesh.share, shape.faces))));

const tintText = (result, sides) => (result.dense && sides.length === 2
  ? "Colours of the target, carried to the source by the dense map"
  : "Surfaces in the colours of the nearest matched points");

function toggle(text, options, name, changed) {
  return h("label", { class: "check" }, h("input", {
    type: "checkbox", checked: options[name],
    onchange: (event) => {
      options[name] = event.target.checked;
      changed();
    },
  }), " ", text);
}

// All stand upright, seen from the same side; all places are then as they are seen.
function turn(sides, pairs) {
  const rows = [stance(sides[0].geometry.positions)];
  if (sides.length === 2) rows.push(turnedTarget(rows[0], sides, pairs));
  sides.forEach((side, k) => stand(side, rows[k]));
}

function turnedTarget(rows, sides, pairs) {
  const matched = pairs.map((pair) => sides.map((side) => side.place(pair[side.end])))
    .filter((both) => both.every((place) => place !== undefined));
  const [here, there] = sides.map((side, k) => matched.map((both) => pointAt(side.geometry.positions, both[k])));
  return matched.length >= 3 ? turned(rows, here, there) : rows;
}

function pointsOf(side, pairs, refined) {
  return pairs.map((pair, at) => (side.end === "target" && refined !== null
    ? lifted(side, refined[at].vertices.map(side.place), refined[at].weights)
    : lifted(side, [side.place(pair[side.end])], [1])));
}

// Colours of the surfaces, computed when they are first wanted.
function shadesOf(sides, points, colors, dense) {
  const known = [];
  const make = (at) => (dense !== null && sides.length === 2 && at === 0
    ? carried(sides, dense, tinted(sides[1].geometry, points[1], colors))
    : tinted(sides[at].mesh, points[at], colors));
  return (at) => (known[at] ??= make(at));
}

function join(scenes, selection, options) {
  let moving = false;
  scenes.forEach((scene, at) => {
    scene.watch((pair) => selection.hover(pair), (pair) => selection.choose(pair));
    scene.follow(async (camera) => {
      if (moving || !options.together || scenes.length === 1) return;
      moving = true;
      await scenes[1 - at].look(camera);
      moving = false;
    });
  });
  selection.addEventListener("change", () => scenes.forEach((scene) => scene.ring(selection.shown)));
}
