// Landmarks of a template carried to all specimens of a batch: a row for each, and one archive of all files.

import { button } from "./actions.js";
import { Problem, get } from "./api.js";
import { inDoubt } from "./confidence.js";
import { fill, h, table } from "./dom.js";
import { save } from "./download.js";
import { ended, follow } from "./events.js";
import { count, several, stateName } from "./format.js";
import { leftOut, writtenOf } from "./landmark_carrying.js";
import { landmarkFileArea, mayReplace, systemField } from "./landmark_fields.js";
import { FORMATS, readLandmarks, writeLandmarks, writeTable } from "./landmark_files.js";
import { recordOf } from "./match.js";
import { problemBox } from "./problem.js";
import { TABLE, Specimens } from "./specimens.js";
import { throttled } from "./throttle.js";
import { zipped } from "./zip.js";

const HEADS = ["Specimen", "Landmarks", "Mean confidence", "Least confidence", "State", "Files"];
const ABOUT = "Open a specimen to see its landmarks and to correct them, those in doubt first. They are kept in this tab until it is closed.";
const CARRIED = "They are carried to each specimen as soon as it is matched. Several templates: command isomatch landmarks.";
const FULL = " This tab has no room to keep them all: download them before you leave this page.";

/** @param {Object} batch the job of dense matches of a template with specimens */
export async function landmarkCollectionView(place, batch, signal) {
  const known = await get(batch.links.partial, signal);
  const template = await recordOf("shapes", known.source, known.source_name, signal);
  if (!batch.parameters.dense || template.id === null) {
    throw new Problem(null, { title: "No dense maps", detail: "Landmarks are carried along dense maps of shapes that are kept; match again with them." });
  }
  document.title = `Landmarks of ${several(known.matches.length, "specimen")} – isomatch`;
  const said = h("div", { "aria-live": "polite" });
  const progress = h("p", { role: "status", class: "faint" });
  const list = h("section", { "aria-label": "Specimens" });
  const system = systemField();
  const specimens = new Specimens(known, signal);
  let job = batch;
  const show = () => {
    progress.textContent = sentence(job, specimens);
    fill(list, remarkOn(specimens), table(ABOUT, HEADS, specimens.all.map(row)), downloads(specimens.all));
  };
  specimens.addEventListener("change", show);
  const take = async ([file]) => {
    if (file === undefined) return;
    try {
      const coordinates = system.querySelector("select").value;
      const given = readLandmarks(file.name, await file.text(), coordinates, template.name);
      if (!(await mayReplace(specimens.all.some(({ carried }) => carried?.moves.length > 0)))) return;
      fill(said);
      await specimens.begin({ file: file.name, coordinates, given });
    } catch (error) {
      if (!signal.aborted) fill(said, problemBox(error));
    }
  };
  fill(place,
    h("h2", {}, "Landmarks: ", h("a", { href: `#/shapes/${template.id}` }, template.name), ` to ${several(known.matches.length, "specimen")}`),
    h("p", {}, h("a", { href: `#/jobs/${batch.id}` }, "Back to the matches")),
    h("div", { class: "columns" },
      landmarkFileArea("template", template, CARRIED, take), system),
    said, progress, list);
  if (specimens.template !== null) system.querySelector("select").value = specimens.template.coordinates;
  show();
  specimens.work();
  const update = async () => specimens.update((await get(batch.links.partial, signal)).matches);
  const sometimes = throttled(update);
  if (ended(batch)) return;
  await follow(batch.links.events, (now) => {
    job = now;
    if (!ended(now)) sometimes();
  }, signal);
  if (!signal.aborted) await update();
}

// A remark on landmarks that are on no specimen.
function remarkOn({ all }) {
  const first = all.find(({ carried }) => carried !== null);
  const remark = first === undefined ? null : leftOut(first.carried);
  return remark === null ? null : h("p", { class: "warnings" }, remark);
}

function sentence(job, { all, template, fits, pause }) {
  const matched = all.filter(({ match }) => match.state === "succeeded").length;
  const carried = all.filter((one) => one.carried !== null).length;
  const matches = `${count(matched)} of ${several(all.length, "specimen")} matched${ended(job) ? "" : " so far"}`;
  return template === null ? `${matches}. Choose the landmarks of the template.`
    : `${matches}, landmarks of ${template.file} carried to ${count(carried)}.${fits ? "" : FULL}`
      + (pause === null ? "" : ` ${pause.message} Trying again.`);
}

function row({ match, name, stem, carried, problem }) {
  const view = carried !== null || match.state === "succeeded" ? "landmarks" : "jobs";
  const head = h("th", { scope: "row" }, h("a", { href: `#/${view}/${match.job}` }, name));
  if (carried === null) {
    const state = h("span", { class: `state ${match.state}` }, match.state === "succeeded" ? "matched" : stateName(match.state));
    const said = problem?.message ?? match.error?.detail ?? state;
    return h("tr", {}, head, h("td", {}), h("td", {}), h("td", {}), h("td", {}, said), h("td", {}));
  }
  const marks = writtenOf(carried);
  const there = marks.filter(({ position }) => position !== null).length;
  const sure = marks.filter(({ confidence }) => confidence !== null);
  const least = sure.reduce((found, one) => (found === null || Number(one.confidence) < Number(found.confidence) ? one : found), null);
  const mean = sure.reduce((sum, { confidence }) => sum + Number(confidence), 0) / sure.length;
  return h("tr", {}, head,
    h("td", {}, there === marks.length ? count(there) : `${count(there)} of ${count(marks.length)}`),
    h("td", {}, least === null ? null : mean.toFixed(2)),
    h("td", {}, least === null ? null : leastOf(least)),
    h("td", {}, carried.moves.length > 0 ? `${count(carried.moves.length)} moved` : "carried"),
    h("td", { class: "files-of" }, FORMATS.flatMap((format) => [" ", button(
      [format.toUpperCase(), h("span", { class: "visually-hidden" }, ` of ${name}`)],
      () => save(new Blob([textOf(format, stem, carried)]), `${stem}.${format}`), { class: "small" })])));
}

const leastOf = ({ label, confidence }) => [inDoubt(Number(confidence))
  ? h("span", { class: "badge doubt" }, `in doubt, ${confidence}`) : confidence, ` at ${label}`];

const textOf = (format, stem, carried) => writeLandmarks(format, stem, writtenOf(carried), carried.coordinates);

function downloads(specimens) {
  const done = specimens.filter(({ carried }) => carried !== null);
  if (done.length === 0) return null;
  const rows = done.flatMap(({ stem, carried }) => writtenOf(carried).map(({ label, position, confidence, remark }) =>
    [stem, label, ...(position ?? [null, null, null]), confidence, remark === "corrected" ? 1 : 0]));
  const every = [["specimen", "label", "x", "y", "z", "confidence", "corrected"], ...rows];
  const all = done.length === 1 ? "The specimen" : `All ${count(done.length)} specimens`;
  return h("p", { class: "actions" }, `${all} in one archive, with a table of confidences:`,
    FORMATS.map((format) => button(["ZIP of ", format.toUpperCase()], () => {
      const files = done.map(({ stem, carried }) => [`${stem}.${format}`, textOf(format, stem, carried)]);
      save(zipped([...files, [TABLE, writeTable(every)]]), "landmarks.zip");
    })));
}
