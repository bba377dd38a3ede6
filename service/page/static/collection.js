// Dissimilarities of a collection: a heat map whose cells can be chosen, and a table of nearest neighbours.

import { get } from "./api.js";
import { h, fill, table, warningList, MOST_IN_FULL } from "./dom.js";
import { download, exportsOf } from "./download.js";
import { certifiedBadge, count, figure, percent, several } from "./format.js";
import { dissimilarityPicture, drawHeatMap } from "./heat_map.js";
import { completed } from "./names.js";
import { linkButton } from "./share_link.js";

const NEIGHBOURS = 3;
const MOST_ROWS = 500;

/** Draw the dissimilarities known so far. */
export async function collectionProgress(place, path, signal) {
  const known = await get(path, signal);
  const names = await completed(known.names, known.shapes, signal);
  if (signal.aborted) return;
  const map = place.querySelector(".heat") ?? h("div", { class: "heat", role: "img", "aria-label": "Heat map" });
  fill(place, h("p", { class: "faint" }, `${count(known.pairs_done)} of ${count(known.pairs)} pairs compared.`), known.pairs_done ? map : null);
  if (!known.pairs_done) return;
  await drawHeatMap(map, dissimilarityPicture(known.matrix, names, known.labels), () => {}, signal);
}

export async function collectionView(place, result, job, signal) {
  const names = await completed(result.names, result.shapes, signal);
  document.title = `${result.shapes.length} shapes – isomatch`;
  const map = h("div", { class: "heat", role: "img", "aria-label": "Heat map of the dissimilarities; the table below has the nearest of each shape" });
  const detail = h("section", { class: "card detail", "aria-live": "polite", "aria-label": "The chosen pair", tabindex: -1 },
    h("p", { class: "faint" }, "Choose a cell, two shapes, or a neighbour in the table."));
  const chosen = twoShapes(names, (i, j) => choose(i, j));
  const choose = (i, j) => {
    chosen.show(i, j);
    fill(detail, cell(result, names, i, j));
  };
  // The table may be far below.
  const reveal = (i, j) => {
    choose(i, j);
    detail.focus();
  };
  fill(place,
    h("h2", {}, `Dissimilarities of ${result.shapes.length} shapes`),
    h("p", { class: "proof" },
      certifiedBadge(result), " ",
      result.certified ? "All dissimilarities are proven minimal." :
        `The dissimilarities of ${several(result.uncertified.length, "pair")} are not proven minimal.`),
    scores(result),
    warningList(result.warnings),
    map, chosen.node, detail,
    h("p", { class: "actions" },
      linkButton(job.id), " ", download(job.links.result, "JSON", `${job.id}.json`), exportsOf(job), " ",
      download(job.links.picture, "Picture (PNG)", `${job.id}.png`)),
    neighbours(result, names, reveal));
  await drawHeatMap(map, dissimilarityPicture(result.matrix, names, result.labels), choose, signal);
}

function scores(result) {
  if (result.mean_average_precision === null) return null;
  return h("p", {}, "Mean average precision: ", h("data", { value: result.mean_average_precision }, percent(result.mean_average_precision)),
    ", precision at 1: ", h("data", { value: result.precision_at_1 }, percent(result.precision_at_1)), ".");
}

function cell(result, names, i, j) {
  if (i === j) return h("p", {}, link(result, names, i), ": the dissimilarity of a shape to itself is 0.");
  return [
    h("p", {}, link(result, names, i), " and ", link(result, names, j), ": dissimilarity ", figure(result.matrix[i][j]), "."),
    h("p", {}, h("a", { href: `#/with/${result.shapes[i]}/${result.shapes[j]}`, class: "button" }, "Match these two")),
  ];
}

const link = (result, names, i) => h("a", { href: `#/shapes/${result.shapes[i]}` }, names[i]);

/** Fields for any two shapes: cells of large collections are small, and cannot be reached by keyboard. */
function twoShapes(names, choose) {
  const options = () => names.map((name, i) => h("option", { value: i }, name));
  const [row, column] = ["shape-a", "shape-b"].map((id) => h("select", {
    id, onchange: () => choose(Number(row.value), Number(column.value)),
  }, options()));
  const field = (label, select) => h("div", {}, h("label", { for: select.id }, label), select);
  return {
    node: h("div", { class: "two-shapes" }, field("Dissimilarity of", row), field("and", column)),
    show: (i, j) => [row.value, column.value] = [i, j],
  };
}

/** The nearest neighbours of each shape; of many shapes, one is found by its name. */
export function neighbours(result, names, choose) {
  const shown = neighbourTable(result, names, choose);
  if (names.length <= MOST_IN_FULL) return shown;
  const rows = [...shown.querySelectorAll("tbody tr")];
  const find = (event) => {
    const wanted = event.target.value.trim().toLowerCase();
    for (const row of rows) row.hidden = !row.querySelector("th").textContent.toLowerCase().includes(wanted);
  };
  return [h("p", { class: "measure" }, h("label", { for: "find" }, "Find a shape "), h("input", { id: "find", type: "search", oninput: find })), shown];
}

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
  const caption = ["Nearest neighbours", left > 0 ? ` of the first ${MOST_ROWS} shapes; the JSON has all` : ""];
  return table(caption, heads, rows, { class: "stacked" });
}
