// Matrices of a collection as heat maps, such as its dissimilarities: dark cells are similar shapes, blocks are classes.

import { plain } from "./dom.js";
import { colorOf, hideParts, plotly } from "./plotly.js";
import { digits } from "./format.js";

/** The colour scale, as in the service's pictures (worker/pictures/heat_map.py). */
const COLORSCALE = "Viridis";
/** Values above this quantile have the last colour, where there are as many pairs: of few, none is an outlier. */
const UPPER_QUANTILE = 0.98;
const LEAST_CLIPPED = 50;
/** Share of the scale from which on black is easier to read on it than white: there its relative luminance is 0.18. */
const LIGHT_FROM = 0.43;
/** Shapes up to which cells have their numbers written in them, and digits of these. */
const MOST_NUMBERED = 12;
const CELL_DIGITS = 2;
/** Places of the ticks of the scale, as shares of its end, and digits of their numbers. */
const TICKS = [0, 0.25, 0.5, 0.75, 1];
const NARROW_TICKS = [0, 0.5, 1];
const TICK_DIGITS = 3;
/** Shapes up to which rows and columns are named; beyond, their classes are, if they are as few. */
const MOST_NAMES = 40;
/** Shapes up to which a gap is left between cells. */
const MOST_GAPS = 80;
/** Characters of a shortened name, and of one beside a narrow drawing. */
const LONGEST = 18;
const NARROW_LONGEST = 10;
/** Pixels below which a drawing is narrow. */
const NARROW = 500;
const drawn = new WeakSet();

/**
 * Draw a matrix.
 * @param {Object} picture `names` of rows and columns, `labels` or null; `matrix` of numbers, null for no
 *   cell; `end`, see `scaleEnd`; `title` of the colours; `text`, of row and column; `number`, the text of
 *   a number of the matrix with so many digits, and `tick`, that of one of the scale
 * @param {function(number, number)} choose called with the row and column of a cell that is clicked
 */
export async function drawHeatMap(node, { names, labels = null, matrix, end, title, text, number, tick = number }, choose, signal) {
  const Plotly = await plotly();
  if (signal.aborted) return;
  const order = ordered(labels, names.length);
  const narrow = node.clientWidth < NARROW;
  const short = narrow ? shortened(names.map(withoutEnding), NARROW_LONGEST) : shortened(names);
  // Names may repeat, so the axes are numeric and only their ticks are named.
  const ticks = names.length <= MOST_NAMES
    ? { tickvals: order.map((_, at) => at), ticktext: order.map((i) => plain(short[i])) } : classTicks(labels, narrow);
  const gap = names.length <= MOST_GAPS ? 1 : 0;
  const marked = narrow ? NARROW_TICKS : TICKS;
  const z = order.map((i) => order.map((j) => matrix[i][j]));
  const isLight = (value) => value !== null && value >= LIGHT_FROM * end.most;
  const numbered = (holds, color) => (names.length > MOST_NUMBERED ? {} : {
    text: z.map((row) => row.map((value) => (value !== null && holds(value) ? number(value, CELL_DIGITS) : ""))),
    texttemplate: "%{text}", textfont: { color },
  });
  const data = {
    type: "heatmap", colorscale: COLORSCALE, xgap: gap, ygap: gap, hoverinfo: "text",
    z, zmin: 0, zmax: end.most,
    hovertext: order.map((i) => madeWhenRead((at) => [names[i], names[order[at]], text(i, order[at])].map(plain).join("<br>"))),
    ...numbered((value) => !isLight(value), "white"),
    colorbar: {
      thickness: 12, ticklabeloverflow: "allow",
      tickvals: marked.map((share) => share * end.most), ticktext: marked.map((share) => tickText(share, end, tick)),
      ...(narrow ? { title: { text: title, side: "top" }, orientation: "h", y: 1, yanchor: "bottom" } : { title: { text: title, side: "right" } }),
    },
  };
  // The numbers of a heat map have one colour: those of light cells are drawn by another, upon the first.
  const light = names.length > MOST_NUMBERED ? [] : [{
    type: "heatmap", colorscale: COLORSCALE, xgap: gap, ygap: gap, hoverinfo: "skip", showscale: false, zmin: 0, zmax: end.most,
    z: z.map((row) => row.map((value) => (isLight(value) ? value : null))), ...numbered(isLight, "black"),
  }];
  // Names that are turned end at their columns: beyond the last one there is no room.
  const axis = { ...ticks, automargin: true, autotickangles: [0, -45, -90], showgrid: false, zeroline: false, fixedrange: true };
  const layout = {
    margin: { l: 20, r: 10, t: 10, b: 20 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
    font: { color: colorOf("ink") }, xaxis: axis, yaxis: { ...axis, autorange: "reversed" },
  };
  await Plotly.react(node, [data, ...light], layout, { displaylogo: false, displayModeBar: false, responsive: true });
  node.removeAllListeners("plotly_click");
  node.on("plotly_click", ({ points: [{ x, y }] }) => choose(order[y], order[x]));
  if (drawn.has(node)) return;
  drawn.add(node);
  hideParts(node);
  signal.addEventListener("abort", () => Plotly.purge(node));
}

// An array for plotly.js, which reads the text of the cell under the pointer alone: of 2,000 shapes, all take 400 MB.
const madeWhenRead = (make) => new Proxy([], {
  get: (array, at) => (typeof at === "string" && /^\d+$/.test(at) ? make(Number(at)) : array[at]),
});

/** Dissimilarities as a picture for `drawHeatMap`. */
export function dissimilarityPicture(matrix, names, labels) {
  // The square root tells small dissimilarities apart, which decide the nearest neighbours.
  const roots = matrix.map((row) => row.map((value) => (value === null ? null : Math.sqrt(Math.max(0, value)))));
  const text = (i, j) => (matrix[i][j] === null ? "not compared yet" : digits(matrix[i][j]));
  const number = (root, significant) => digits(root * root, significant);
  return { names, labels, matrix: roots, end: scaleEnd(roots), title: "dissimilarity", text, number };
}

/** The end of the scale: `most`, the number that has the last colour, and `clipped`, whether greater ones have it, too. */
export function scaleEnd(matrix) {
  const pairs = matrix.flatMap((row, i) => row.slice(i + 1).filter((value) => value !== null));
  const sorted = Float64Array.from(pairs).sort();
  const quantile = sorted.length < LEAST_CLIPPED ? 1 : UPPER_QUANTILE;
  const most = sorted[Math.floor(quantile * (sorted.length - 1))] || 1;
  return { most, clipped: sorted.at(-1) > most };
}

const tickText = (share, { most, clipped }, number) => `${share === 1 && clipped ? "≥ " : ""}${number(share * most, TICK_DIGITS)}`;

/** Names in a few letters; long ones often have the same first words, which do not tell shapes apart. */
export function shortened(names, longest = LONGEST) {
  // By letters, not by halves of them, as of an emoji.
  const spelt = names.map((name) => [...name]);
  const first = spelt[0];
  const same = first.findIndex((letter, at) => spelt.some((letters) => letters[at] !== letter));
  const words = [...first.slice(0, same < 0 ? 0 : same).join("").replace(/[^\s_-]*$/, "")].length;
  return spelt.map((letters) => {
    if (letters.length <= longest) return letters.join("");
    const rest = words > 0 ? ["…", ...letters.slice(words)] : letters;
    return rest.length <= longest ? rest.join("") : `${rest.slice(0, longest - 1).join("")}…`;
  });
}

const withoutEnding = (name) => name.replace(/(?<=.)\.[a-z]{3,4}$/i, "");

/** Names of the classes, each in the middle of its rows. */
function classTicks(labels, narrow) {
  const sizes = new Map();
  for (const label of labels ?? []) sizes.set(label, (sizes.get(label) ?? 0) + 1);
  if (sizes.size === 0 || sizes.size > MOST_NAMES) return { showticklabels: false, ticks: "" };
  const classes = [...sizes.keys()];
  let before = 0;
  const middles = classes.map((label) => {
    before += sizes.get(label);
    return before - sizes.get(label) / 2 - 0.5;
  });
  return { tickvals: middles, ticktext: shortened(classes, narrow ? NARROW_LONGEST : LONGEST).map(plain) };
}

function ordered(labels, count) {
  const order = Array.from({ length: count }, (_, i) => i);
  if (!labels) return order;
  const first = new Map();
  labels.forEach((label, i) => first.has(label) || first.set(label, i));
  return order.sort((i, j) => first.get(labels[i]) - first.get(labels[j]) || i - j);
}
