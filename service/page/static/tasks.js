// Tasks for chosen shapes, and the fields of their forms.

import { h } from "./dom.js";
import { checkbox, choiceField, moreFields, numberField, structureField, switchField, textField } from "./fields.js";
import { landmarkField } from "./landmarks.js";
import { COMPARE, LEARN, MATCH } from "./parameters.js";

/** Vertices to which shapes can be simplified, and above which that is offered. */
const SIMPLIFIED = 20000;

const idsOf = (shapes) => shapes.map((shape) => shape.id);
const namesOf = (shapes) => shapes.map((shape) => shape.name);
// With the names that are shown: an upload may have another than the one that its file is stored under.
const pair = ([source, target]) => ({ source: source.id, target: target.id, source_name: source.name, target_name: target.name });
const batch = ([source, ...targets]) => ({
  source: source.id, targets: idsOf(targets), source_name: source.name, target_names: namesOf(targets),
});
const all = (shapes) => ({ shapes: idsOf(shapes), names: namesOf(shapes) });

const matchFields = ({ metrics, descriptors }, shapes) => [
  numberField("points", MATCH.points),
  structureField("metric", MATCH.metric, metrics, shapes),
  structureField("descriptor", MATCH.descriptor, descriptors, shapes),
  h("div", { class: "checks" },
    switchField("orientation", MATCH.orientation, "Tell left from right and front from back (a dense map does so too)"),
    switchField("dense", MATCH.dense, "Extend the match to all vertices (dense map)"),
    checkbox("refine", "gmds", "Find matched points between vertices as well (GMDS)", MATCH.refine.default === "gmds"),
    common(shapes)),
];

const prototypeFields = (_, [prototype, ...targets]) => [
  numberField("points", {
    ...MATCH.points, default: prototype.points, max: prototype.points,
    about: "Points of the prototype that are matched.",
  }),
  h("div", { class: "checks" }, common(targets)),
];

const matching = {
  path: "/v1/matches",
  title: "Match",
  about: "Match: corresponding points of two shapes",
  parameters: MATCH,
  named: pair,
  fields: (structures, shapes, signal) => [...matchFields(structures, shapes), landmarkField(shapes, signal)],
};

const matchingAll = {
  path: "/v1/batches",
  title: "Match all",
  most: 1001,
  about: "Batch: match the first with each of the others",
  parameters: MATCH,
  named: batch,
  fields: matchFields,
};

const recognising = { path: "/v1/matches", title: "Match", named: pair, fields: prototypeFields };
const recognisingAll = { path: "/v1/batches", title: "Match all", named: batch, fields: prototypeFields };

const comparing = {
  most: 2000,
  path: "/v1/dissimilarities",
  title: "Compare",
  about: "Compare: dissimilarities of all pairs",
  parameters: COMPARE,
  named: all,
  fields: ({ metrics }, shapes) => [
    numberField("points", COMPARE.points),
    structureField("metric", COMPARE.metric, metrics, shapes),
    h("div", { class: "checks" }, classes(shapes), common(shapes)),
  ],
};

const registering = {
  most: 257,
  path: "/v1/registrations",
  title: "Register",
  about: "Register the first, as a template, to each of the others",
  named: ([template, ...specimens]) => ({ template: template.id, template_name: template.name, ...all(specimens) }),
  fields: (_, shapes) => [h("div", { class: "checks" },
    checkbox("scale", true, "Scale the specimens to a common size before their mean is taken", false), components(shapes))],
};

const landmarking = {
  most: 1001,
  path: "/v1/batches",
  view: "landmarks",
  title: "Match for landmarks",
  about: "Landmarks: carry those of the first, a template, to each of the others",
  named: (shapes) => ({ ...batch(shapes), dense: true }),
  fields: (_, shapes) => [h("div", { class: "checks" },
    h("span", { class: "faint" }, "The file of landmarks is chosen on the next page, while the shapes are matched."), components(shapes))],
};

const mapping = {
  most: 16,
  path: "/v1/consistent-maps",
  title: "Map",
  about: "Consistent maps between all, improved by one another",
  named: all,
  fields: (_, shapes) => [h("div", { class: "checks" }, components(shapes))],
};

const learning = {
  most: 256,
  path: "/v1/prototypes",
  title: "Learn",
  about: "Learn a prototype of a class from examples",
  parameters: LEARN,
  named: (shapes) => ({ shapes: idsOf(shapes) }),
  fields: (_, shapes) => [
    textField("name", "Name", beginning(shapes), "A name that exists gets a next version."),
    numberField("points", LEARN.points),
    choiceField("correspondence", "Correspondence of the examples", [
      ["matches", "by matching with the first shape"],
      ["shared_connectivity", "by vertex number: the files share their triangles"],
    ], 0, "Files of one template, in other poses, have the same triangles and share their vertices' numbers."),
    h("div", { class: "checks" }, simplification(shapes)),
  ],
};

/** The fields of a task, those of rarer parameters folded. */
export function fieldsOf({ fields, parameters }, ...given) {
  const shown = fields(...given);
  return parameters === undefined ? shown : [...shown, moreFields(parameters, shown)];
}

/** The tasks: address, fields and words of each; `most` is the greatest number of shapes, `view` shows the job. */
export const TASKS = {
  match: matching, batch: matchingAll, recognise: recognising, recogniseAll: recognisingAll,
  compare: comparing, map: mapping, register: registering, learn: learning, landmarks: landmarking,
};

/** Names of the tasks for so many shapes, of which the first may be a prototype. */
export function tasksFor(count, learned) {
  if (learned) return [count === 2 ? "recognise" : "recogniseAll"];
  return count === 2 ? ["match", "compare", "learn", "register", "landmarks"] : ["compare", "learn", "batch", "map", "register", "landmarks"];
}

// The common beginning of all names, up to a digit.
function beginning(shapes) {
  const [first, ...others] = shapes.map((shape) => shape.name.match(/^[^\d.]*/)[0].replace(/[\s_-]+$/, ""));
  return first && others.every((name) => name === first) ? first : "prototype";
}

function common(shapes) {
  return [simplification(shapes), components(shapes)];
}

// Only if chosen, as everywhere: what is computed does not depend on who asks for it.
const simplification = (shapes) => (shapes.some((shape) => shape.vertices > SIMPLIFIED)
  ? checkbox("simplify", SIMPLIFIED, "Simplify to 20,000 vertices first: faster, and the points are still vertices of the files", false)
  : null);

const components = (shapes) => (shapes.some((shape) => shape.components > 1)
  ? checkbox("largest_component", true, "Take only the largest component of shapes that have several", false)
  : null);

/**
 * Class of a shape, as `isomatch compare --labels-from-names` has it: its name up to the first digit, without a separator there,
 * or, without a digit, up to the first dash, underscore or blank.
 */
export function classOf(name) {
  const stem = name.replace(/(?<=.)\.[^.]*$/, "");
  return stem.split(/\d/.test(stem) ? /[\s_.-]*\d/ : /[\s_-]/, 1)[0] || stem;
}

function classes(shapes) {
  const labels = shapes.map((shape) => classOf(shape.name));
  if (new Set(labels).size === labels.length) return null;
  return checkbox("labels", JSON.stringify(labels), `Names begin with the class: ${[...new Set(labels)].join(", ")}`, true);
}
