// A batch: its matches, each with its state, its confidence and a link to it.

import { get } from "./api.js";
import { confidenceBadge } from "./confidence.js";
import { h, fill, table } from "./dom.js";
import { download } from "./download.js";
import { count, figure, stateName } from "./format.js";
import { completed, namesOf } from "./names.js";
import { linkButton } from "./share_link.js";

const HEADS = ["Target", "State", "Answer", "Distortion of distances"];
/** Milliseconds until matches that still run are requested again. */
const AGAIN = 1000;

/** Show the matches known so far. */
export async function batchProgress(place, path, signal) {
  const known = await get(path, signal);
  const rows = await rowsOf(known.matches, signal);
  if (signal.aborted) return;
  fill(place, matchTable(rows, `${count(known.ended)} of ${count(rows.length)} matches have ended`));
}

/** Show the matches of a batch that ended without a result: some may have ended before, and some run for a moment more. */
export async function stoppedBatchView(place, job, signal) {
  for (;;) {
    const known = await get(job.links.partial, signal);
    await batchView(place, known, job, signal);
    if (known.ended === known.matches.length) return;
    await new Promise((resolve) => setTimeout(resolve, AGAIN));
  }
}

export async function batchView(place, result, job, signal) {
  const rows = await rowsOf(result.matches, signal);
  const path = job.state === "succeeded" ? `${job.links.self}/result` : job.links.partial;
  const succeeded = result.matches.filter((match) => match.state === "succeeded").length;
  const matches = rows.length === 1 ? "1 match" : `${count(rows.length)} matches`;
  document.title = `${matches} – isomatch`;
  fill(place,
    h("h2", {}, `${matches} with ${result.source_name ?? (await namesOf([result.source], signal))[0]}`),
    h("p", { class: "actions" }, linkButton(job.id), " ", download(path, "JSON", `${job.id}.json`), " ",
      job.parameters.dense && h("a", { href: `#/landmarks/${job.id}`, class: "button" }, "Landmarks")),
    matchTable(rows, `${count(succeeded)} of ${count(rows.length)} matches have succeeded`));
}

async function rowsOf(matches, signal) {
  const names = await completed(matches.map((match) => match.target_name), matches.map((match) => match.target), signal);
  return matches.map((match, at) => row(match, names[at]));
}

function row({ job, state, error, summary }, name) {
  return h("tr", {},
    h("th", { scope: "row" }, h("a", { href: `#/jobs/${job}` }, name)),
    h("td", {}, h("span", { class: `state ${state}` }, stateName(state))),
    h("td", {}, error ? error.detail : summary && confidenceBadge(summary)),
    h("td", {}, summary ? figure(summary.distortion.second_order) : null));
}

const matchTable = (rows, caption) => table(caption, HEADS, rows);
