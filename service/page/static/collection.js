// Dissimilarities of a collection: a heat map whose cells can be chosen, and nearest neighbours.

import { get } from "./api.js";
import { h, fill } from "./dom.js";
import { download } from "./download.js";
import { drawHeatMap } from "./heat_map.js";
import { linkButton } from "./link.js";
import { namesOf } from "./names.js";
import { count, figure, percent } from "./words.js";

const NEIGHBOURS = 3;
const MOST_ROWS = 200;
const PAUSE = 1500;

/** What is known while the job runs: told the job at each change, it draws now and then. */
export function partialView(place, path, signal) {
  let last = 0;
  let busy = false;
  return async () => {
    if (busy || performance.now() - last < PAUSE) return;
    busy = true;
    try {
      const known = await get(path, signal);
      const names = await namesOf(known.shapes, signal);
      const map = place.querySelector(".heat") ?? h("div", { class: "heat", role: "img", "aria-label": "Heat map" });
      const said = `${count(known.pairs_done)} of ${count(known.pairs)} pairs are known.`;
      if (signal.aborted || place.dataset.done) return;
      fill(place, h("p", { class: "faint" }, said), known.pairs_done ? map : null);
      if (!known.pairs_done) return;
      await drawHeatMap(map, known.matrix, names, known.labels, () => {}, signal);
    } catch {
      // There is another one at the next change, and at the end the result.
    } finally {
      last = performance.now();
      busy = false;
    }
  };
}

export async function collectionView(place, result, job, signal) {
  place.dataset.done = "true";
  const names = await namesOf(result.shapes, signal);
  document.title = `${result.shapes.length} shapes – isomatch`;
  const map = h("div", { class: "heat", role: "img", "aria-label": "Heat map of the dissimilarities; the table below has the nearest of each shape" });
  const detail = h("section", { class: "card detail", "aria-live": "polite" },
    h("p", { class: "faint" }, "Choose a cell, or a neighbour in the table."));
  const choose = (i, j) => fill(detail, cell(result, names, i, j));
  fill(place,
    h("h2", {}, `${result.shapes.length} shapes, all with all`),
    h("p", { class: "proof" },
      h("span", { class: result.certified ? "badge good" : "badge" }, result.certified ? "certified" : "not certified"), " ",
      result.certified ? "Every dissimilarity is proven to be the least there is." :
        `Of ${result.uncertified.length} pairs it is not proven that there is no lesser one.`),
    scores(result),
    result.warnings.length ? h("ul", { class: "warnings" }, result.warnings.map((text) => h("li", {}, text))) : null,
    map, detail,
    h("p", { class: "actions" },
      linkButton(job.id), " ", download(job.links.result, "JSON", `${job.id}.json`), " ",
      download(job.links.picture, "Picture (PNG)", `${job.id}.png`), " ",
      download(job.links.arrays, "Arrays (NPZ)", `${job.id}.npz`)),
    neighbourTable(result, names, choose));
  await drawHeatMap(map, result.matrix, names, result.labels, choose, signal);
}

function scores(result) {
  if (result.mean_average_precision === null) return null;
  return h("p", {}, "Mean average precision ", h("data", { value: result.mean_average_precision }, percent(result.mean_average_precision)),
    ", nearest shape of the same class for ", h("data", { value: result.precision_at_1 }, percent(result.precision_at_1)), ".");
}

function cell(result, names, i, j) {
  if (i === j) return h("p", {}, link(result, names, i), ": a shape is not compared with itself.");
  return [
    h("p", {}, link(result, names, i), " and ", link(result, names, j), ": dissimilarity ", figure(result.matrix[i][j]), "."),
    h("p", {}, h("a", { href: `#/with/${result.shapes[i]}/${result.shapes[j]}`, class: "button" }, "Match these two")),
  ];
}

const link = (result, names, i) => h("a", { href: `#/shapes/${result.shapes[i]}` }, names[i]);

function neighbourTable(result, names, choose) {
  const nearest = (i) => result.nearest[i].slice(0, NEIGHBOURS).map((j) => h("li", {},
    h("button", { type: "button", class: "small", onclick: () => choose(i, j) }, names[j]), " ",
    figure(result.matrix[i][j])));
  const rows = result.shapes.slice(0, MOST_ROWS).map((_, i) => h("tr", {},
    h("th", { scope: "row" }, link(result, names, i)),
    result.labels ? h("td", {}, result.labels[i]) : null,
    h("td", {}, h("ol", { class: "neighbours" }, nearest(i)))));
  const heads = ["Shape", ...(result.labels ? ["Class"] : []), "Nearest shapes"];
  const left = result.shapes.length - rows.length;
  return h("div", { class: "scroll" }, h("table", {},
    h("caption", {}, "Nearest neighbours", left > 0 ? ` of the first ${MOST_ROWS} shapes; the JSON has all` : ""),
    h("thead", {}, h("tr", {}, heads.map((text) => h("th", { scope: "col" }, text)))),
    h("tbody", {}, rows)));
}
