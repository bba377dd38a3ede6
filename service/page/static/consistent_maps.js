// Consistent maps of a collection: a heat map whose cells can be chosen, tables of pairs and shapes, and a pair drawn.

import { attempt } from "./actions.js";
import { confidenceBadge, confidenceNote, confidencePercent } from "./confidence.js";
import { h, fill, table, warningList } from "./dom.js";
import { download, exportsOf } from "./download.js";
import { choiceField } from "./fields.js";
import { count, digits, figure, percent, several } from "./format.js";
import { drawHeatMap, scaleEnd, shortened } from "./heat_map.js";
import { mapScenes } from "./map_scenes.js";
import { problemBox } from "./problem.js";
import { linkButton } from "./share_link.js";

/** End of the scale of probabilities. */
const CERTAINTY = () => ({ most: 1, clipped: false });
const CONFIDENCE = { title: "confidence", text: confidencePercent, tick: percent, end: CERTAINTY };
/** Measures that the cells of the heat map can have. */
const MEASURES = {
  confidence: { ...CONFIDENCE, of: (pair) => pair.confidence?.probability ?? null },
  confidence_before: { ...CONFIDENCE, of: (pair) => pair.confidence_before?.probability ?? null },
  cycle_error: { title: "cycle error", of: (pair) => pair.cycle_error, text: digits, end: scaleEnd },
  cycle_error_before: { title: "cycle error", of: (pair) => pair.cycle_error_before, text: digits, end: scaleEnd },
};
const CHOICES = [
  ["confidence", "confidence of the maps"],
  ["confidence_before", "confidence of the matches, before"],
  ["cycle_error", "cycle error of the maps"],
  ["cycle_error_before", "cycle error of the matches, before"],
];

export async function consistentMapsView(place, result, job, signal) {
  const names = result.shapes.map(({ name, shape }) => name ?? shape.slice(0, 8));
  const known = new Map(result.shapes.map(({ shape }, at) => [shape, names[at]]));
  const pairs = pairsOf(result);
  document.title = `Maps of ${several(names.length, "shape")} – isomatch`;
  const map = h("div", { class: "heat", role: "img", "aria-label": "Heat map of the pairs; the table below has all of them" });
  const detail = h("section", { class: "card detail", "aria-label": "The chosen pair", tabindex: -1 },
    h("p", { class: "faint" }, "Choose a cell, or a pair in the table."));
  const draw = mapScenes(job, signal);
  const choose = async (i, j) => {
    if (i === j) return;
    const scenes = h("div");
    fill(detail, pairDetail(result, known, pairs[i][j], i, j), scenes);
    detail.focus({ preventScroll: true });
    detail.scrollIntoView({ block: "nearest" });
    if (!pairs[i][j].mapped) return;
    try {
      await draw(scenes, i, result.shapes[i], j, result.shapes[j]);
    } catch (error) {
      if (!signal.aborted) fill(scenes, problemBox(error));
    }
    detail.scrollIntoView({ block: "nearest" });
  };
  const measure = choiceField("measure", "Cells", CHOICES, 0, "Before is by the match of the pair alone.");
  const drawMap = (name) => drawHeatMap(map, pictureOf(MEASURES[name], pairs, names), choose, signal);
  measure.addEventListener("change", (event) => attempt(measure, () => drawMap(event.target.value)));
  fill(place,
    h("h2", {}, `Maps between ${several(names.length, "shape")}`),
    h("p", {}, summary(result)), errors(result), warningList(result.warnings),
    h("div", { class: "measure" }, measure), map, detail,
    h("p", { class: "actions" },
      linkButton(job.id), " ", download(job.links.result, "JSON", `${job.id}.json`), exportsOf(job)),
    shapeTable(result, names), pairTable(result, names, choose));
  await drawMap("confidence");
}

// All pairs by the places of their shapes, in both orders.
function pairsOf({ shapes, pairs }) {
  const square = shapes.map(() => shapes.map(() => null));
  let at = 0;
  for (let i = 0; i < shapes.length; i++) {
    for (let j = i + 1; j < shapes.length; j++) square[i][j] = square[j][i] = pairs[at++];
  }
  return square;
}

function pictureOf({ title, of, text, tick = text, end }, pairs, names) {
  const matrix = pairs.map((row) => row.map((pair) => (pair === null ? null : of(pair))));
  const said = (i, j) => {
    if (i === j) return "the same shape";
    if (!pairs[i][j].mapped) return "no map";
    return matrix[i][j] === null ? "no third shape" : `${title} ${text(matrix[i][j])}${pairs[i][j].fits ? "" : ", does not fit"}`;
  };
  return { names, matrix, end: end(matrix), title, text: said, number: text, tick };
}

const improved = (pair) => pair.through.length > 0;

function summary({ pairs }) {
  const [mapped, changed, wrong] = [(pair) => pair.mapped, improved, (pair) => !pair.fits]
    .map((holds) => pairs.filter(holds).length);
  return `${count(mapped)} of ${several(pairs.length, "pair")} mapped, ${count(changed)} of them by way of other shapes;`
    + ` ${wrong === 0 ? "all fit" : `${count(wrong)} ${wrong === 1 ? "does" : "do"} not fit`}.`;
}

function errors(result) {
  if (result.cycle_error === null) return h("p", {}, "Cycle errors need three shapes that are mapped to one another.");
  return h("p", {}, "Mean cycle error: ", change(result.cycle_error_before, result.cycle_error, figure), ".");
}

/** A measure before and after, once if it has not changed. */
const change = (before, after, shown) => (before === after ? shown(after) : [shown(before), " → ", shown(after)]);

const confidences = (pair) => (improved(pair)
  ? [confidenceBadge({ confidence: pair.confidence_before }), " → ", confidenceBadge(pair)] : confidenceBadge(pair));

function pairDetail({ shapes }, known, pair, i, j) {
  const link = (at) => h("a", { href: `#/shapes/${shapes[at].shape}` }, known.get(shapes[at].shape));
  const forward = pair.source === shapes[i].shape;
  const through = (forward ? pair.through : pair.through.toReversed()).map((id) => known.get(id)).join(", ");
  return [
    h("h3", {}, link(i), " to ", link(j)),
    pair.mapped ? null : h("p", {}, `No map: ${pair.reason}.`),
    confidenceNote(pair),
    improved(pair) ? h("div", {}, `Mapped by way of ${through}; by its own match: `, confidenceBadge({ confidence: pair.confidence_before })) : null,
    pair.cycle_error === null ? null : h("p", {}, "Cycle error: ", change(pair.cycle_error_before, pair.cycle_error, figure), "."),
    pair.mapped && !pair.fits ? h("p", {}, `It does not fit: ${pair.reason}.`) : null,
    h("p", { class: "actions" }, h("a", { href: `#/with/${shapes[i].shape}/${shapes[j].shape}`, class: "button" }, "Match these two")),
  ];
}

const agreement = ({ fits, reason }) => (fits ? "fits" : h("span", { class: "error" }, reason));

function shapeTable({ shapes }, names) {
  const rows = shapes.map((one, at) => h("tr", {},
    h("th", { scope: "row" }, h("a", { href: `#/shapes/${one.shape}` }, names[at])),
    h("td", {}, one.cycle_error === null ? "none" : change(one.cycle_error_before, one.cycle_error, figure)),
    h("td", {}, agreement(one))));
  return table("Shapes; a cycle error is the mean over the triples that a shape is in; where it changed: before → after",
    ["Shape", "Cycle error", "Agreement"], rows);
}

// Pairs that do not fit come first, then those that were improved.
function pairTable({ shapes, pairs }, names, choose) {
  const places = new Map(shapes.map(({ shape }, at) => [shape, at]));
  const short = shortened(names);
  const rank = (pair) => (pair.fits ? (improved(pair) ? 1 : 2) : 0);
  const rows = pairs.toSorted((a, b) => rank(a) - rank(b)).map((pair) => {
    const [i, j, ...through] = [pair.source, pair.target, ...pair.through].map((id) => places.get(id));
    const row = h("button", {
      type: "button", class: "small", title: `${names[i]} – ${names[j]}`, onclick: () => choose(i, j),
    }, `${short[i]} – ${short[j]}`);
    return h("tr", {},
      h("th", { scope: "row" }, row), h("td", {}, confidences(pair)),
      h("td", {}, pair.cycle_error === null ? "none" : change(pair.cycle_error_before, pair.cycle_error, figure)),
      h("td", {}, through.map((k) => short[k]).join(", ")), h("td", {}, agreement(pair)));
  });
  return h("div", { class: "maps" },
    table("Pairs; choose one to draw its map. What does not fit comes first, then what was mapped by way of other shapes.",
      ["Pair", "Confidence", "Cycle error", "By way of", "Agreement"], rows));
}
