// The shapes of a match side by side, turned together and with matched points in the same colours.

import { attempt } from "./actions.js";
import { behindNames, pointColors, surfaceColors, transferredColors } from "./colors.js";
import { h, fill } from "./dom.js";
import { drawnPrototype, drawnShape, lifted, rotate } from "./drawn_shape.js";
import { pointAt } from "./geometry.js";
import { NO_WEBGL, canDraw } from "./plotly.js";
import { Scene } from "./scene.js";
import { shareDrawn } from "./shape.js";
import { targetView } from "./view.js";

/**
 * Draw the shapes of a match.
 * @param {Object} source its record, or that of the prototype
 * @param {Object} target its record
 * @param {Selection} selection the pair that is pointed at
 * @returns {Promise<Object|null>} `show`, which draws the match or an alternative and returns the
 *   colours of its pairs; null if nothing can be drawn
 */
export async function matchScenes(place, result, source, target, selection, signal) {
  const learned = result.source_kind === "prototype";
  const reason = obstacle(learned ? [target] : [source, target]);
  if (reason !== null) {
    fill(place, h("p", { class: "faint" }, reason));
    return null;
  }
  fill(place, h("div", { class: "pair" }, ["source", "target"].map(() => h("div", { class: "scene-to-come" }))));
  const sides = (await Promise.all([
    learned ? drawnPrototype(source, signal) : drawnShape(source, "source", signal), drawnShape(target, "target", signal),
  ])).filter((side) => side !== null);
  rotateAll(sides, result.correspondences);
  const options = { numbered: true, together: true, colored: true };
  let again = () => {};
  const announced = h("p", { class: "pointed faint", "aria-live": "polite" });
  const nodes = sides.map(({ shape, end }) => h("div", {
    class: "scene", "data-side": end,
    "aria-label": `${shape.name} in three dimensions, with the matched points`,
  }));
  fill(place, h("div", { class: "both" }, h("div", { class: "pair" }, sides.map(caption(nodes))), announced), h("p", { class: "checks" },
    toggle("Numbers", options, "numbered", () => again()),
    sides.length === 1 ? null : toggle("Turn both together", options, "together", () => {}),
    toggle(colorText(result, sides), options, "colored", () => again()),
    result.dense && result.overlap ? h("span", { class: "faint" }, "Grey: not on the other shape.") : null));
  const scenes = sides.map(({ mesh }, at) => new Scene(nodes[at], mesh, signal));

  const show = async ({ correspondences, refined, dense }) => {
    const points = sides.map((side) => pointsOf(side, correspondences, refined));
    const colors = pointColors(points[0]);
    const names = correspondences.map((_, pair) => String(pair + 1));
    const shades = shadesOf(sides, points, colors, dense);
    again = () => Promise.all(scenes.map((scene, at) =>
      scene.show(options.colored && colors.length > 0 ? shades(at) : behindNames(sides[at].mesh.colors, options.numbered), {
        points: points[at], colors, names, numbered: options.numbered, ring: selection.shown,
      })));
    await again();
    if (signal.aborted) return colors;
    if (place.dataset.drawn === undefined) join(scenes, selection, options);
    place.dataset.drawn = String(correspondences.length);
    return colors;
  };
  selection.addEventListener("change", () => {
    const pair = selection.shown;
    const far = pair === null ? [] : sides.flatMap(({ end }, at) => (scenes[at].hides(pair) ? [`the ${end}`] : []));
    announced.textContent = pair === null ? "" : `Pair ${pair + 1}${
      far.length === 0 ? "" : `, on the far side of ${far.join(" and ")}`}`;
  });
  return { show };
}

/** The reason why shapes cannot be drawn, or null. */
export function obstacle(shapes) {
  if (shapes.some((shape) => shape.id === null)) return "A shape is no longer kept, so nothing is drawn.";
  return canDraw() ? null : NO_WEBGL;
}

export const caption = (nodes) => ({ shape, mesh }, at) => h("figure", {}, nodes[at],
  h("figcaption", {}, shape.name, h("span", { class: "faint" }, " ", shareDrawn(mesh.share, shape.faces))));

const colorText = (result, sides) => (result.dense && sides.length === 2
  ? "Colour the source by the dense map to the target"
  : "Colour surfaces by the nearest matched points");

export function toggle(text, options, name, changed) {
  const label = h("label", { class: "check" });
  const box = h("input", {
    type: "checkbox", checked: options[name],
    onchange: () => {
      options[name] = box.checked;
      attempt(label, changed);
    },
  });
  return fill(label, box, " ", text);
}

/** Rotate all shapes upright, and the target to align matched points. */
export function rotateAll(sides, pairs) {
  const rows = [sides[0].shape.view];
  if (sides.length === 2) rows.push(alignedView(rows[0], sides, pairs));
  sides.forEach((side, k) => rotate(side, rows[k]));
}

function alignedView(rows, sides, pairs) {
  const matched = pairs.map((pair) => sides.map((side) => side.place(pair[side.end])))
    .filter((both) => both.every((place) => place !== undefined));
  const [here, there] = sides.map((side, k) => matched.map((both) => pointAt(side.geometry.positions, both[k])));
  return matched.length >= 3 ? targetView(rows, here, there) : rows;
}

function pointsOf(side, pairs, refined) {
  return pairs.map((pair, at) => (side.end === "target" && refined !== null
    ? lifted(side, refined[at].vertices.map(side.place), refined[at].weights)
    : lifted(side, [side.place(pair[side.end])], [1])));
}

// Colours of the surfaces, computed on first use.
function shadesOf(sides, points, colors, dense) {
  const known = [];
  const near = (at) => surfaceColors(sides[at].mesh, points[at], colors);
  const make = (at) => {
    if (dense === null || sides.length === 1) return near(at);
    if (at === 0) return transferredColors(sides, dense, near(1));
    // Vertices without a partner, as of the whole that a part is matched with, are grey on the target, too.
    const mapped = dense.inverse?.target;
    return mapped ? transferredColors([sides[1], sides[1]], { source: mapped, target: mapped }, near(1)) : near(1);
  };
  return (at) => (known[at] ??= make(at));
}

/** Turn shapes together if that is chosen, and highlight the same pair on all. */
export function join(scenes, selection, options) {
  scenes.forEach((scene, at) => {
    scene.watch((pair) => selection.hover(pair), (pair) => selection.choose(pair));
    scene.follow((view) => options.together && scenes[1 - at]?.look(view));
  });
  selection.addEventListener("change", () => scenes.forEach((scene) => scene.ring(selection.shown)));
}
