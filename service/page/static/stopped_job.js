// A job without a result: why, its shapes, and a link to request it again.

import { fill, h } from "./dom.js";
import { keepParameters } from "./entries.js";
import { namesOf } from "./names.js";
import { COMPARE, LEARN, MATCH } from "./parameters.js";
import { problemBox, withNames } from "./problem.js";
import { LABELS } from "./transfer_form.js";

/** Tasks of the start page by the kinds of their jobs; other kinds are requested elsewhere. */
const TASKS = {
  match: "match", batch: "batch", dissimilarities: "compare", prototype: "learn", registration: "register", consistent_maps: "map",
};
/** The same of a prototype and shapes. */
const TASKS_OF_PROTOTYPES = { match: "recognise", batch: "recogniseAll" };
/** Parameters that the forms have fields for: see parameters.js. */
const COMPONENT = { largest_component: MATCH.largest_component };
const PARAMETERS = {
  match: MATCH, batch: MATCH, dissimilarities: COMPARE, prototype: { name: {}, ...LEARN },
  registration: COMPONENT, consistent_maps: COMPONENT,
};

/** @param {Object|null} problem why there is no result: `title`, `detail` and perhaps `errors`; null for a job that was cancelled */
export async function stoppedJob(place, job, problem, signal) {
  const ids = [...new Set([job.source, ...job.shapes].filter((id) => id !== null))];
  const names = await namesOf(ids, signal).catch(() => ids.map((id) => id.slice(0, 8)));
  if (signal.aborted) return;
  fill(place,
    // Of jobs with a source, `shapes` of the request has other places.
    problem && problemBox(withNames({ ...problem, message: labelled(problem.detail, job) }, job.source === null ? names : [])),
    // The shape of an upload that was refused does not exist.
    ids.length === 0 || job.kind === "validation" ? null : h("p", {},
      "Shapes: ", ids.map((id, at) => [at === 0 ? "" : ", ", shapeLink(id, names[at])]), isComplete(job, ids) ? "" : " and others"),
    job.links.match && h("p", { class: "actions" }, matchLink(job)),
    canRequest(job, ids) ? h("p", { class: "actions" },
      h("a", { href: `#/task/${TASKS[job.kind]}/${ids.join("/")}`, class: "button", onclick: () => keep(job, ids) }, "Request it again")) : null);
}

// The form has the parameters of the job.
const keep = ({ kind, parameters, name }, [first]) =>
  keepParameters(first.startsWith("p-") ? TASKS_OF_PROTOTYPES[kind] : TASKS[kind], { ...parameters, name }, PARAMETERS[kind]);

// A detail begins with the field that is wrong, which the form of a transfer has a name for.
const labelled = (detail, { kind }) => (kind !== "transfer" ? detail
  : detail.replace(/^(\w+)(?=: )/, (field) => LABELS[field] ?? field));

/** A link to the match that a transfer carries values along. */
export const matchLink = ({ links }) => h("a", { href: links.match.replace("/v1/", "#/"), class: "button" }, "Back to the match");

const shapeLink = (id, name) => h("a", { href: `#/${id.startsWith("p-") ? "prototypes" : "shapes"}/${id}` }, name);

// A record names only some of many shapes.
const isComplete = (job, ids) => ids.filter((id) => !id.startsWith("p-")).length >= job.shape_count;

const canRequest = (job, ids) => TASKS[job.kind] !== undefined && ids.length > 1 && isComplete(job, ids);
