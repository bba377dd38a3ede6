// A prototype: what is known of it, what it was learned from, and what can be done with it.

import { get, remove } from "./api.js";
import { h, fill, button } from "./dom.js";
import { download } from "./download.js";
import { jobList } from "./lists.js";
import { namesOf } from "./names.js";
import { canDraw } from "./plotly.js";
import { problemBox } from "./problem.js";
import { Scene } from "./scene.js";
import { lifted, prototypeSide, stand } from "./side.js";
import { stance } from "./stance.js";
import { pointColors, tinted } from "./tint.js";
import { figure, several, time } from "./words.js";

export async function prototypeView(place, [id], signal) {
  const path = `/v1/prototypes/${encodeURIComponent(id)}`;
  const forget = button("Delete", async () => {
    try {
      await remove(path);
      location.hash = "#/";
    } catch (error) {
      forget.after(problemBox(error));
    }
  });
  await prototypeDetails(place, await get(path, signal), signal, [forget]);
  const list = await jobList(signal, id);
  if (!signal.aborted) place.append(h("section", {}, list));
}

/** @param {Array<Node>} actions what else can be done with it */
export async function prototypeDetails(place, prototype, signal, actions) {
  const { id, name, version, examples, components, learned_from: learned } = prototype;
  document.title = `${name} – isomatch`;
  const from = h("div");
  const picture = h("div");
  fill(place,
    h("h2", {}, `${name}, version ${version}`),
    h("p", {}, `${several(prototype.points, "point")}, learned from ${several(examples, "shape")}, with up to`
      + ` ${several(components, "Gaussian")} for each distance. Made ${time(prototype.created)}.`),
    prototype.warnings.length ? h("ul", { class: "warnings" }, prototype.warnings.map((text) => h("li", {}, text))) : null,
    h("p", { class: "actions" },
      h("a", { href: `#/with/${id}`, class: "button primary" }, "Match it with a shape"), " ",
      download(`/v1/prototypes/${id}/archive`, "Archive (NPZ)", `${id}.npz`), " ", actions),
    h("dl", { class: "figures" }, measured(prototype.parameters).map(([term, value]) =>
      h("div", {}, h("dt", {}, term), h("dd", {}, value)))),
    picture, from);
  await Promise.all([
    learned === null ? null : exampleTable(prototype, signal).then((table) => fill(from, table)),
    draw(picture, prototype, signal),
  ]);
}

// Its points, on the shape they were chosen on.
async function draw(place, prototype, signal) {
  const side = canDraw() ? await prototypeSide(prototype, signal) : null;
  if (side === null || signal.aborted) return;
  stand(side, stance(side.geometry.positions));
  const points = Array.from({ length: side.points }, (_, point) => lifted(side, [side.place(point)], [1]));
  const colors = pointColors(points);
  const node = h("div", { class: "scene", role: "img", "aria-label": `The points of ${prototype.name} on its reference` });
  fill(place, h("figure", {}, node, h("figcaption", {}, "Its points, on the shape they were chosen on")));
  const scene = new Scene(node, side.mesh, signal);
  await scene.show(tinted(side.mesh, points, colors), {
    points, colors, names: points.map((_, point) => String(point)), numbered: true, ring: null,
  });
  place.dataset.drawn = String(points.length);
}

const structures = (choices) => [choices].flat().map((choice) => (choice.name ?? choice).replaceAll("_", " ")).join(", then ");

const measured = ({ metric, descriptor, normalise }) => [
  ["Distances", structures(metric)],
  ["Descriptor of points", structures(descriptor)],
  ["Sizes", normalise ? "do not count" : "count"],
];

async function exampleTable({ learned_from: learned, reference }, signal) {
  const names = await namesOf(learned.map((example) => example.shape), signal);
  const matched = learned.some((example) => example.misfit !== 0);
  const rows = learned.map(({ shape, used, misfit, reason }, at) => h("tr", {},
    h("th", { scope: "row" }, h("a", { href: `#/shapes/${shape}` }, names[at])),
    h("td", {}, shape === reference ? "the points were chosen on it" : used ? "used" : `left out: ${reason}`),
    matched ? h("td", {}, figure(misfit)) : null));
  return h("div", { class: "scroll" }, h("table", {},
    h("caption", {}, "What it was learned from", matched ? "; misfit is the energy of its match with a prototype of all" : ""),
    h("thead", {}, h("tr", {}, ["Shape", "What became of it", ...(matched ? ["Misfit"] : [])].map((text) => h("th", { scope: "col" }, text)))),
    h("tbody", {}, rows)));
}
