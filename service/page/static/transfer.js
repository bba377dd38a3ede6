// The result of a transfer: what was carried, drawn on both shapes, and its files.

import { drawCarried } from "./carried_scenes.js";
import { confidenceNote } from "./confidence.js";
import { fill, h, warningList } from "./dom.js";
import { download, exportsOf } from "./download.js";
import { kindName, several } from "./format.js";
import { problemBox } from "./problem.js";
import { linkButton } from "./share_link.js";
import { matchLink } from "./stopped_job.js";

export async function transferView(place, result, job, signal) {
  const carried = result.attributes.map(({ name }) => name).join(", ") || several(result.points.length, "point");
  // Values of a shape's own file have the name of their kind.
  const what = carried === result.what ? carried : `${result.what}: ${carried}`;
  const shown = h("div", { class: "carried" });
  fill(place, h("h2", {}, kindName(job)), h("p", {},
    `${what}, from ${result.source_name ?? result.source} to ${result.target_name ?? result.target}`),
  confidenceNote(result), warningList(result.warnings), shown,
  h("p", { class: "actions" }, linkButton(job.id), " ",
    download(job.links.result, "JSON", `${job.id}.json`), exportsOf(job), " ", matchLink(job)));
  try {
    await drawCarried(shown, result, job, signal);
  } catch (error) {
    if (!signal.aborted) fill(shown, problemBox(error));
  }
}
