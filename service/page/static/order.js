// What is asked of the chosen shapes.

import { get, post } from "./api.js";
import { h, fill } from "./dom.js";
import { checkbox, numberField, showErrors, structureField } from "./fields.js";
import { fieldName, problemBox } from "./problem.js";

const LARGE = 50000;
const SIMPLIFIED = 20000;

export const isPrototype = (chosen) => Boolean(chosen?.examples);

/** A form for a match of two shapes, or for a comparison of all. */
export function orderForm(shapes) {
  const learned = isPrototype(shapes[0]);
  if (learned && shapes.length > 2) {
    return h("p", { class: "faint" }, "A prototype is matched with one shape: remove the others.");
  }
  const parts = h("div", { class: "fields" });
  const said = h("div", { "aria-live": "polite" });
  const submit = h("button", { type: "submit", class: "primary" });
  const form = h("form", { novalidate: true, "aria-label": "What is to be done" });
  let task;
  const take = (name) => {
    task = { match: matching, compare: comparing, recognise: recognising }[name];
    submit.textContent = task.title;
    fill(parts, h("p", { class: "faint" }, "Loading what can be chosen."));
    get("/v1/structures").then((structures) => fill(parts, task.fields(structures, shapes)))
      .catch((error) => fill(parts, problemBox(error)));
  };
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    submit.disabled = true;
    fill(said);
    try {
      const job = await post(task.path, { ...task.named(shapes), ...values(form) });
      location.hash = `#/jobs/${job.id}`;
    } catch (error) {
      showErrors(form, error.errors ?? [], fieldName);
      fill(said, problemBox(error));
    } finally {
      submit.disabled = false;
    }
  });
  fill(form, shapes.length === 2 && !learned ? choiceOf(take) : null, parts, said, h("p", {}, submit));
  if (learned) take("recognise");
  else take(shapes.length === 2 ? "match" : "compare");
  return form;
}

function choiceOf(take) {
  const option = (name, text) => h("label", {},
    h("input", {
      type: "radio", name: "task", value: name, checked: name === "match", "data-form": true,
      onchange: () => take(name),
    }), " ", text);
  return h("fieldset", {}, h("legend", {}, "What is to be done"),
    option("match", "Match: points of the one to points of the other"),
    option("compare", "Compare: how different they are"));
}

const matching = {
  path: "/v1/matches",
  title: "Match",
  named: ([source, target]) => ({ source: source.id, target: target.id }),
  fields: ({ metrics, descriptors }, shapes) => [
    numberField("points", "Points", 32, 3, 256, "How many points are matched."),
    structureField("metric", "Metric", metrics, "recommended: commute time, then geodesic", shapes),
    structureField("descriptor", "Descriptor", descriptors, "recommended: scale-invariant heat kernel", shapes),
    h("div", { class: "checks" },
      checkbox("dense", true, "Extend the match to all vertices (dense map)", sizeOf(shapes) <= SIMPLIFIED),
      checkbox("refine", "gmds", "Find matched points between vertices as well (GMDS)", false),
      common(shapes)),
  ],
};

const recognising = {
  path: "/v1/matches",
  title: "Match",
  named: ([source, target]) => ({ source: source.id, target: target.id }),
  fields: (_, [prototype, target]) => [
    numberField("points", "Points", prototype.points, 3, prototype.points,
      "So many of the prototype's points are found on the shape."),
    h("div", { class: "checks" }, common([target])),
  ],
};

const comparing = {
  path: "/v1/dissimilarities",
  title: "Compare",
  named: (shapes) => ({ shapes: shapes.map((shape) => shape.id) }),
  fields: ({ metrics }, shapes) => [
    numberField("points", "Points", 6, 3, 10, "So many points of each shape are matched, to proven optimality."),
    structureField("metric", "Metric", metrics, "recommended: commute time", shapes),
    h("div", { class: "checks" }, classes(shapes), common(shapes)),
  ],
};

const sizeOf = (shapes) => Math.max(...shapes.map((shape) => shape.vertices));

function common(shapes) {
  const largest = sizeOf(shapes);
  const several = shapes.some((shape) => shape.components > 1);
  return [
    largest <= SIMPLIFIED ? null : checkbox("simplify", SIMPLIFIED,
      "Simplify to 20,000 vertices first: faster, and the points are still vertices of the files",
      largest > LARGE),
    several ? checkbox("largest_component", true, "Take the largest part of shapes that have several", true) : null,
  ];
}

// Names like cat0.off and cat1.off: what comes before the first digit or dash is the class.
function classes(shapes) {
  const labels = shapes.map((shape) => shape.name.match(/^[^\d\-.]+/)?.[0].trim() ?? "");
  const useful = labels.every((label) => label) && new Set(labels).size < labels.length;
  if (!useful) return null;
  return checkbox("labels", JSON.stringify(labels), `Names begin with the class: ${[...new Set(labels)].join(", ")}`, true);
}

function values(form) {
  const chosen = [...form.elements].filter((field) =>
    field.name && field.dataset.form === undefined && field.value !== "" && (field.type !== "checkbox" || field.checked));
  return Object.fromEntries(chosen.map((field) => [field.name, valueOf(field)]));
}

function valueOf(field) {
  if (field.dataset.json !== undefined) return JSON.parse(field.value);
  return field.type === "number" ? Number(field.value) : field.value;
}
