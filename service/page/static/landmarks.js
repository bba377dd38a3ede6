// Landmarks: pairs of vertices known to correspond, clicked on the shapes or typed.

import { button } from "./actions.js";
import { behindNames, css, distinct } from "./colors.js";
import { h, fill } from "./dom.js";
import { drawnShape, lifted, rotate } from "./drawn_shape.js";
import { nearestVertex, pointAt } from "./geometry.js";
import { canDraw } from "./plotly.js";
import { problemBox } from "./problem.js";
import { Scene } from "./scene.js";

const ENDS = ["source", "target"];
const ABOUT = "Click a point on one shape, then the corresponding point on the other; or type their vertex"
  + " indices. A landmark on a hand tells left from right.";

/** Landmarks by the ids of the shapes, for when one comes back to the form. */
const entered = new Map();

/** Landmarks to begin with, for when the form of these two shapes is shown. */
export const enterLandmarks = (ids, pairs) => entered.set(ids.join(), pairs);

/** A form field for landmarks of two shapes; the shapes are drawn when it is opened. */
export function landmarkField(shapes, signal) {
  const key = shapes.map((shape) => shape.id).join();
  const pairs = [...(entered.get(key) ?? [])];
  const pending = [null, null];
  let sides = null;
  let scenes = null;
  const value = h("input", { type: "hidden", name: "landmarks", id: "field-landmarks", "data-json": true });
  const list = h("ol", { class: "list" });
  const said = h("p", { "aria-live": "polite", class: "faint" }, ABOUT);
  const refused = h("p", { id: "error-landmarks", class: "error", role: "alert", hidden: true });
  const pictures = h("div", { class: "pair" });
  const inputs = shapes.map((_, at) => numberInput(ENDS[at], (number) => choose(at, number), () => add()));

  const refuse = (text) => {
    refused.textContent = text ?? "";
    refused.hidden = text === null;
  };
  const choose = (at, number) => {
    pending[at] = number;
    refuse(null);
    show();
  };
  const add = () => {
    const wrong = errorOf(pending, pairs, shapes, sides);
    refuse(wrong);
    if (wrong !== null) return;
    pairs.push([...pending]);
    pending.fill(null);
    inputs.forEach(({ input }) => { input.value = ""; });
    show();
  };
  const pick = (at, number) => {
    inputs[at].input.value = number;
    choose(at, number);
    if (!pending.includes(null)) add();
  };
  const show = () => {
    // A pair that was typed completely counts even if it was not added.
    const all = pending.includes(null) ? pairs : [...pairs, pending];
    value.value = all.length === 0 ? "" : JSON.stringify(all);
    entered.set(key, [...pairs]);
    const wrong = pending.every((number) => number === null) ? null : errorOf(pending, pairs, shapes, sides);
    if (wrong === null) delete value.dataset.unfinished;
    else value.dataset.unfinished = `This landmark cannot be used yet. ${wrong}`;
    said.textContent = instruction(pending, shapes);
    fill(list, pairs.map((pair, i) => line(pair, i, () => {
      pairs.splice(i, 1);
      show();
    })));
    scenes?.forEach((scene, at) => drawMarks(scene, sides[at], [...pairs.map((pair) => pair[at]), pending[at]]));
  };
  const open = async () => {
    if (scenes !== null || sides !== null || !canDraw()) return;
    try {
      sides = await Promise.all(shapes.map((shape, at) => drawnShape(shape, ENDS[at], signal)));
      scenes = await drawn(pictures, sides, pick, signal);
      show();
    } catch (error) {
      if (!signal.aborted) fill(pictures, problemBox(error));
    }
  };
  const box = h("details", { class: "landmarks" },
    h("summary", {}, "Landmarks: points known to correspond"),
    said, pictures,
    h("div", { class: "actions" }, inputs.map(({ node }) => node), button("Add this pair", add)),
    refused, list, value);
  box.addEventListener("toggle", () => box.open && open());
  show();
  box.open = pairs.length > 0;
  return box;
}

function numberInput(end, changed, entered) {
  const input = h("input", { id: `landmark-${end}`, type: "number", min: 0, step: 1, class: "short" });
  input.addEventListener("input", () => changed(input.value === "" && !input.validity.badInput ? null : input.valueAsNumber));
  input.addEventListener("keydown", (event) => {
    if (event.key !== "Enter") return;
    event.preventDefault();
    entered();
  });
  return { input, node: h("span", {}, h("label", { for: input.id }, `Vertex of the ${end} `), input) };
}

function errorOf(pending, pairs, shapes, sides) {
  for (const at of [0, 1]) {
    const number = pending[at];
    if (number === null) return `Give a vertex of the ${ENDS[at]}.`;
    if (!Number.isInteger(number) || number < 0) return `Give a vertex of the ${ENDS[at]} by its index, a whole number from 0.`;
    const count = shapes[at].file_vertices;
    if ((count !== null && number >= count) || (sides !== null && sides[at].place(number) === undefined)) return `${shapes[at].name} has no vertex ${number}.`;
    if (pairs.some((pair) => pair[at] === number)) return `Vertex ${number} of ${shapes[at].name} is a landmark already.`;
  }
  return null;
}

function instruction(pending, shapes) {
  const missing = pending.indexOf(null);
  if (pending[0] === null && pending[1] === null) return ABOUT;
  return missing < 0 ? "Add this pair." : `Now choose the corresponding point on ${shapes[missing].name}.`;
}

function line([source, target], i, remove) {
  const swatch = h("span", { class: "swatch" });
  swatch.style.background = css(distinct(i));
  return h("li", {}, swatch, `vertex ${source} of the source is vertex ${target} of the target `,
    button("Remove", remove, { class: "small", "aria-label": `Remove landmark ${i + 1}` }));
}

async function drawn(place, sides, pick, signal) {
  const nodes = sides.map(({ shape, end }) => h("div", {
    class: "scene picked", "data-side": end, "aria-label": `${shape.name} in three dimensions, to choose landmarks on`,
  }));
  fill(place, sides.map(({ shape, end }, at) => h("figure", {}, nodes[at],
    h("figcaption", {}, h("span", { class: "faint" }, `${end} `), shape.name))));
  sides.forEach((side) => rotate(side, side.shape.view));
  const scenes = sides.map(({ mesh }, at) => new Scene(nodes[at], mesh, signal, { picked: true }));
  await Promise.all(scenes.map((scene, at) => scene.show(behindNames(sides[at].mesh.colors, true))));
  if (signal.aborted) return null;
  scenes.forEach((scene, at) => scene.pick((vertex) => pick(at, numberOf(sides[at], vertex))));
  place.dataset.ready = "true";
  return scenes;
}

// The drawn mesh may be simplified: take the nearest vertex of the file.
function numberOf({ mesh, geometry }, vertex) {
  if (mesh.share === 1) return geometry.numbers[vertex];
  return geometry.numbers[nearestVertex(geometry.positions, pointAt(mesh.positions, vertex))];
}

// The last of the numbers is the landmark being chosen, which has a ring.
function drawMarks(scene, side, numbers) {
  const there = numbers.map((number) => (number === null ? undefined : side.place(number)));
  const shown = there.flatMap((place, i) => (place === undefined ? [] : [i]));
  scene.show(behindNames(side.mesh.colors, true), {
    points: shown.map((i) => lifted(side, [there[i]], [1])),
    colors: shown.map(distinct),
    names: shown.map((i) => String(i + 1)),
    numbered: true,
    ring: there.at(-1) === undefined ? null : shown.length - 1,
  });
}
