// A prototype: its record, its points, the shapes it was learned from, and its jobs.

import { get } from "./api.js";
import { pointColors, surfaceColors } from "./colors.js";
import { deleteButton } from "./deletion.js";
import { h, fill, figureList, table, warningList } from "./dom.js";
import { download } from "./download.js";
import { drawnPrototype, lifted, rotate } from "./drawn_shape.js";
import { figure, several, time } from "./format.js";
import { jobList } from "./lists.js";
import { namesOf } from "./names.js";
import { canDraw } from "./plotly.js";
import { Scene } from "./scene.js";

export async function prototypeView(place, [id], signal) {
  const path = `/v1/prototypes/${encodeURIComponent(id)}`;
  const prototype = await get(path, signal);
  const forget = deleteButton(path, `${prototype.name}, version ${prototype.version}`,
    "Results of its jobs stay, but it can no longer be matched. Its archive can be downloaded first.", signal);
  await prototypeDetails(place, prototype, signal, [forget]);
  const list = await jobList(signal, id);
  if (!signal.aborted) place.append(h("section", {}, list));
}

/** @param {Array<Node>} actions further links and buttons */
export async function prototypeDetails(place, prototype, signal, actions) {
  const { id, name, version, examples, components, learned_from: learned } = prototype;
  document.title = `${name} – isomatch`;
  const from = h("div");
  const picture = h("div");
  fill(place,
    h("h2", {}, `${name}, version ${version}`),
    h("p", {}, `${several(prototype.points, "point")}, learned from ${several(examples, "shape")}, with up to`
      + ` ${several(components, "Gaussian")} for each distance. Made ${time(prototype.created)}.`),
    warningList(prototype.warnings),
    h("p", { class: "actions" },
      h("a", { href: `#/with/${id}`, class: "button primary" }, "Match it with a shape"), " ",
      download(`/v1/prototypes/${id}/archive`, "Archive (NPZ)", `${id}.npz`), " ", actions),
    figureList(structuresOf(prototype.parameters)),
    picture, from);
  await Promise.all([
    learned === null ? null : exampleTable(prototype, signal).then((table) => fill(from, table)),
    draw(picture, prototype, signal),
  ]);
}

// The points of a prototype on its reference shape, or on a surface it keeps.
async function draw(place, prototype, signal) {
  const side = canDraw() ? await drawnPrototype(prototype, signal) : null;
  if (side === null || signal.aborted) return;
  rotate(side, side.shape.view);
  const points = Array.from({ length: side.points }, (_, point) => lifted(side, [side.place(point)], [1]));
  const colors = pointColors(points);
  const node = h("div", { class: "scene", "aria-label": `The points of ${prototype.name} on a shape` });
  fill(place, h("figure", {}, node, h("figcaption", {}, "Points of the prototype")));
  const scene = new Scene(node, side.mesh, signal);
  await scene.show(surfaceColors(side.mesh, points, colors), {
    points, colors, names: points.map((_, point) => String(point + 1)), numbered: true, ring: null,
  });
  place.dataset.drawn = String(points.length);
}

const structures = (choices) => [choices].flat().map((choice) => (choice.name ?? choice).replaceAll("_", " ")).join(", then ");

const structuresOf = ({ metric, descriptor, normalise }) => [
  ["Metric", structures(metric)],
  ["Descriptor", structures(descriptor)],
  ["Scaled to unit area", normalise ? "yes" : "no"],
];

async function exampleTable({ learned_from: learned, reference }, signal) {
  const names = await namesOf(learned.map((example) => example.shape), signal);
  const matched = learned.some((example) => example.misfit !== 0);
  const rows = learned.map(({ shape, used, misfit, reason }, at) => h("tr", {},
    h("th", { scope: "row" }, h("a", { href: `#/shapes/${shape}` }, names[at])),
    h("td", {}, shape === reference ? "reference: the points were chosen on it" : used ? "used" : `left out: ${reason}`),
    matched ? h("td", {}, figure(misfit)) : null));
  const caption = ["Examples", matched ? "; energy is that of the match with a prototype of all" : ""];
  return table(caption, ["Shape", "Use", ...(matched ? ["Energy"] : [])], rows);
}
