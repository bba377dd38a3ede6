// The result of a match: summary, figures, table of pairs, and both shapes in three dimensions.

import { attempt } from "./actions.js";
import { get, orNull, shapeRecord } from "./api.js";
import { confidenceNote } from "./confidence.js";
import { h, fill, figureList, warningList } from "./dom.js";
import { download } from "./download.js";
import { certificate, certifiedBadge, digits, figure, lessEnergy, percent, several } from "./format.js";
import { againLink } from "./match_again.js";
import { matchScenes } from "./match_scenes.js";
import { orientationNote } from "./orientation.js";
import { pairTable } from "./pair_table.js";
import { problemBox } from "./problem.js";
import { Selection } from "./selection.js";
import { linkButton } from "./share_link.js";
import { transferForm } from "./transfer_form.js";

/** @param {string|undefined} part number of the alternative that the address names */
export async function matchView(place, result, job, signal, part) {
  const learned = result.source_kind === "prototype";
  const [source, target] = await Promise.all([
    recordOf(learned ? "prototypes" : "shapes", result.source, result.source_name, signal),
    recordOf("shapes", result.target, result.target_name, signal),
  ]);
  document.title = `${source.name} and ${target.name} – isomatch`;
  const kept = source.id !== null && target.id !== null;
  const selection = new Selection();
  const numbers = h("div");
  const proof = h("div", { "aria-live": "polite" });
  const pairs = h("div");
  const scenes = h("div", { class: "scenes" });
  const picture = h("span");
  const whose = h("span", { class: "faint" });
  const known = hypotheses(result);
  let shown = known[part]?.which ?? 0;
  const address = () => (shown === 0 ? "" : `/${shown}`);
  let drawn = null;
  let table = new AbortController();
  const choose = async (which) => {
    const hypothesis = known[which];
    shown = which;
    history.replaceState(null, "", `#/jobs/${job.id}${address()}`);
    selection.clear();
    fill(numbers, figures(result, job, hypothesis));
    fill(proof, proofOf(result, hypothesis));
    fill(picture, pictureOf(job, which));
    whose.textContent = `These files are of the answer, not of alternative ${which}:`;
    whose.hidden = which === 0;
    const colors = drawn === null ? null : await drawn.show(hypothesis);
    table.abort();
    table = new AbortController();
    fill(pairs, pairTable(hypothesis.correspondences, colors, selection, learned, table.signal));
  };
  fill(place,
    h("h2", {}, name(source, learned), " and ", name(target)),
    proof,
    warningList(result.warnings), orientationNote(result, signal), alternatives(known, shown, choose),
    h("div", { class: "judged" }, scenes, pairs), numbers,
    h("p", { class: "actions" },
      linkButton(job.id, address), " ", picture, " ",
      kept ? againLink(result, "Match again with other parameters") : null),
    files(job, result, whose),
    result.dense !== null && !learned && kept ? carrying(job, source, target, signal) : null,
  );
  await choose(shown);
  try {
    drawn = await matchScenes(scenes, result, source, target, selection, signal);
    if (drawn !== null) await choose(shown);
  } catch (error) {
    if (!signal.aborted) fill(scenes, problemBox(error));
  }
}

// The files of a match, by what is in them.
const CONTENTS = [
  ["Everything:", ["json", "npz"]],
  ["Pairs:", ["csv"]],
  ["Target in the source's colours:", ["ply", "obj"]],
  ["Both in corresponding colours:", ["glb"]],
];
const REGISTERED = ["ply", "obj", "glb"];

function files(job, { dense, source_kind: kind }, whose) {
  const known = new Map([job.links.arrays, ...job.links.exports].map((path) => [path.split(".").pop(), path]));
  known.set("json", job.links.result);
  const link = (ending, path, about = null) => [" ", download(path, [ending.toUpperCase(), about], `${job.id}.${ending}`)];
  const registered = dense === null || kind === "prototype" ? null : h("span", {}, "Source registered to the target:",
    REGISTERED.map((ending) => link(ending, `${job.links.self}/registered.${ending}`,
      h("span", { class: "visually-hidden" }, " of the source registered to the target"))));
  return h("p", { class: "actions" }, whose, CONTENTS.map(([text, endings]) => {
    const there = endings.filter((ending) => known.has(ending));
    return there.length === 0 ? null : h("span", {}, text, there.map((ending) => link(ending, known.get(ending))));
  }), registered);
}

// Links for values and landmarks that a dense map carries from one shape to the other.
const carrying = (job, source, target, signal) => [
  h("p", { class: "actions" }, h("a", { href: `#/landmarks/${job.id}`, class: "button" }, "Landmarks"),
    h("span", { class: "faint" }, "carried from one shape to the other, and corrected by hand")),
  transferForm(job, source, target, signal),
];

const pictureOf = (job, which) => (which === 0
  ? download(job.links.picture, "Picture (PNG)", `${job.id}.png`)
  : download(`${job.links.picture}?alternative=${which}`, `Picture (PNG) of alternative ${which}`, `${job.id}-${which}.png`));

const name = ({ id, name: called }, learned = false) =>
  (id ? h("a", { href: `#/${learned ? "prototypes" : "shapes"}/${id}` }, called) : called);

/**
 * Record of a shape or prototype, which may have been deleted since; the result is still shown.
 * @param {string|null} called its name in the result
 */
export async function recordOf(kind, id, called, signal) {
  const record = await orNull(kind === "shapes" ? shapeRecord(id, signal) : get(`/v1/${kind}/${encodeURIComponent(id)}`, signal))
    ?? { id: null, name: "a shape that is no longer kept", faces: 0 };
  return { ...record, name: called ?? record.name };
}

/** The chosen match and its alternatives. */
function hypotheses(result) {
  return [result, ...result.alternatives].map((answer, which) => ({
    which,
    relation: answer.relation?.replace("_", " ") ?? "alternative",
    energy: answer.energy,
    distortion: answer.distortion,
    correspondences: answer.correspondences,
    refined: which === 0 && result.refinement?.hypothesis === 0 ? result.refinement.points : null,
    dense: result.dense?.hypothesis === which ? result.dense : null,
  }));
}

// Confidence and certificate of what is shown; an alternative has neither.
function proofOf(result, { which, relation, energy, correspondences }) {
  if (which === 0) {
    return [confidenceNote(result),
      h("p", { class: "proof" }, certifiedBadge(result), " ", summary(result), " ", certificate(result), " ", lessEnergy(result))];
  }
  return h("p", { class: "proof" }, h("span", { class: "badge" }, `alternative ${which}: ${relation}`),
    ` ${several(correspondences.length, "point")} matched, energy ${digits(energy)}, that of the answer ${digits(result.energy)}.`
    + " Certificate and confidence are known of the answer alone.");
}

function summary(result) {
  const alone = result.unmatched.length;
  const matched = `${several(result.correspondences.length, "point")} matched`;
  const left = alone ? `, ${several(alone, "point")} unmatched` : "";
  return `${matched}${left}${result.refinement ? ", refined between vertices" : ""}.`;
}

function alternatives(known, shown, choose) {
  if (known.length === 1) return null;
  const choices = h("fieldset", { class: "alternatives" });
  const options = known.map(({ which, relation, energy }) => h("label", {},
    h("input", {
      type: "radio", name: "hypothesis", value: which, checked: which === shown,
      onchange: () => attempt(choices, () => choose(which)),
    }), " ", which === 0 ? "Answer" : `${which}: ${relation}`,
    h("span", { class: "faint" }, ` energy ${digits(energy)}`)));
  return fill(choices, h("legend", {}, "Answer and alternatives"), options);
}

const overAllSamples = ({ energy, lower_bound: bound, certified }) =>
  h("span", {}, figure(energy), certified ? ", proven" : [", not proven: at least ", figure(bound)]);

const ofTheSamples = ({ value, lower_bound, certified }) =>
  h("span", {}, figure(value), certified ? ", proven" : [", at least ", figure(lower_bound)]);

const partOf = ({ part, source, target }) => part === "both"
  ? `${percent(source)} of the source's area overlaps ${percent(target)} of the target's`
  : part === "source"
  ? `the source is a part of the target, ${percent(target)} of its area`
  : `the target is a part of the source, ${percent(source)} of its area`;

// The bounds hold for the problem that the chosen match solves.
const OTHER = "only for the chosen match";

/** Parts of the time that are named: those of at least this share. */
const NAMED_SHARE = 0.1;

// From the request to the result, and what it was spent on.
function waited({ timings: { total, ...stages } }, { created, started, ended }) {
  const seconds = (from, to) => (new Date(to) - new Date(from)) / 1000;
  const all = seconds(created, ended);
  const parts = Object.entries({ "waiting for a worker": seconds(created, started), ...stages })
    .filter(([, value]) => value >= NAMED_SHARE * all).sort((a, b) => b[1] - a[1])
    .map(([stage, value]) => `${stage.replaceAll("_", " ")} ${digits(value)}\u00a0s`);
  return [`${digits(all)} s`, parts.map((part) => [" ", h("span", { class: "faint" }, part)])];
}

function figures(result, job, { which, energy, distortion }) {
  const best = which === 0;
  const entries = [
    ["Energy", figure(energy), "energy"],
    ["Lower bound", best ? figure(result.lower_bound) : OTHER, "lower_bound"],
    ["Gap", best ? h("data", { value: result.gap, title: String(result.gap) }, percent(result.gap)) : OTHER, "gap"],
    ...(result.overlap ? [["Overlap", partOf(result.overlap), "overlap"]] : []),
    ...(result.proof ? [["Least energy over all samples", overAllSamples(result.proof), "proof"]] : []),
    ["Distortion of distances", figure(distortion.second_order), "second_order"],
    ...(distortion.first_order === null ? [] : [["Distortion of descriptors", figure(distortion.first_order), "first_order"]]),
    ["Greatest distortion", figure(distortion.linf), "linf"],
    ...(result.gromov_hausdorff_distance ? [["Gromov–Hausdorff distance of the samples",
      ofTheSamples(result.gromov_hausdorff_distance), "gromov_hausdorff_distance"]] : []),
    ["Gromov–Hausdorff distance of the points, upper bound", figure(0.5 * distortion.linf), "gromov_hausdorff"],
    ...(typeof result.misfit !== "number" ? [] : [
      ["Misfit of the target to the class (1 is typical)", best ? figure(result.misfit) : OTHER, "misfit"]]),
    ["Waited", waited(result, job), "seconds"],
  ];
  return figureList(entries);
}
