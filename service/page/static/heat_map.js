// A matrix of dissimilarities as a heat map: dark cells are similar shapes, blocks are classes.

import { plain } from "./dom.js";
import { colorOf, plotly } from "./plotly.js";
import { digits } from "./format.js";

/** The colour scale, as in the service's pictures (worker/pictures/heat_map.py). */
const COLORSCALE = "Viridis";
/** Dissimilarities above this quantile have the last colour. */
const UPPER_QUANTILE = 0.98;
/** Shapes up to which rows and columns are named. */
const MOST_NAMES = 40;
/** Characters of a shortened name. */
const LONGEST = 18;
const drawn = new WeakSet();

/** @param {function(number, number)} choose called with the row and column of a cell that is clicked */
export async function drawHeatMap(node, matrix, names, labels, choose, signal) {
  const Plotly = await plotly();
  if (signal.aborted) return;
  const order = ordered(labels, names.length);
  const short = order.map((i) => plain(shortened(names[i])));
  // Names may repeat, so the axes are numeric and only their ticks are named.
  const ticks = names.length <= MOST_NAMES
    ? { tickvals: order.map((_, at) => at), ticktext: short } : { showticklabels: false };
  const data = {
    type: "heatmap", colorscale: COLORSCALE, xgap: 1, ygap: 1, hoverinfo: "text",
    // The square root tells small dissimilarities apart, which decide the nearest neighbours.
    z: order.map((i) => order.map((j) => root(matrix[i][j]))), zmin: 0, zmax: greatest(matrix),
    text: order.map((i) => order.map((j) => cellText(names[i], names[j], matrix[i][j]))),
    colorbar: { title: { text: "√ dissimilarity", side: "right" }, thickness: 12, exponentformat: "e" },
  };
  const axis = { ...ticks, automargin: true, showgrid: false, zeroline: false, fixedrange: true };
  const layout = {
    margin: { l: 20, r: 10, t: 10, b: 20 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
    font: { color: colorOf("ink") }, xaxis: axis, yaxis: { ...axis, autorange: "reversed" },
  };
  await Plotly.react(node, [data], layout, { displaylogo: false, displayModeBar: false, responsive: true });
  node.removeAllListeners("plotly_click");
  node.on("plotly_click", ({ points: [{ x, y }] }) => choose(order[y], order[x]));
  if (drawn.has(node)) return;
  drawn.add(node);
  signal.addEventListener("abort", () => Plotly.purge(node));
}

function greatest(matrix) {
  const pairs = matrix.flatMap((row, i) => row.slice(i + 1).filter((value) => value !== null));
  const sorted = Float64Array.from(pairs).sort();
  return root(sorted[Math.floor(UPPER_QUANTILE * (sorted.length - 1))] ?? 0) || 1;
}

const root = (value) => (value === null ? null : Math.sqrt(Math.max(0, value)));

const shortened = (name) => (name.length <= LONGEST ? name : `${name.slice(0, LONGEST - 1)}…`);

const cellText = (row, column, value) =>
  `${plain(row)}<br>${plain(column)}<br>${value === null ? "not compared yet" : digits(value)}`;

function ordered(labels, count) {
  const order = Array.from({ length: count }, (_, i) => i);
  if (!labels) return order;
  const first = new Map();
  labels.forEach((label, i) => first.has(label) || first.set(label, i));
  return order.sort((i, j) => first.get(labels[i]) - first.get(labels[j]) || i - j);
}
