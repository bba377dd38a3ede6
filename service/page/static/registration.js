// A registration: the mean shape and its components, and the template on each specimen.

import { button } from "./actions.js";
import { componentView } from "./components.js";
import { confidenceBadge } from "./confidence.js";
import { h, fill, table, warningList } from "./dom.js";
import { download, exportsOf } from "./download.js";
import { count, figure, several } from "./format.js";
import { problemBox } from "./problem.js";
import { linkButton } from "./share_link.js";

const HEADS = ["Specimen", "Answer", "Flipped triangles", "Mean distance", "Greatest distance", "Registered template"];
const FORMATS = ["ply", "obj", "glb"];

export async function registrationView(place, result, job, signal) {
  const template = result.template_name ?? result.template.slice(0, 8);
  const registered = result.specimens.filter((one) => one.registered).length;
  document.title = `${template} on ${several(registered, "specimen")} – isomatch`;
  const shown = h("div");
  let show = null;
  // Scores and arrays are those of the registered specimens.
  const places = result.specimens.map((_, at) => result.specimens.slice(0, at).filter((one) => one.registered).length);
  const rows = result.specimens.map((one, at) => row(one, at, job, (name) => show(places[at], name)));
  fill(place,
    h("h2", {}, `${template} registered to ${several(registered, "specimen")}`),
    h("p", {}, `${count(registered)} of ${several(result.specimens.length, "specimen")} registered, each with the`
      + ` ${count(result.vertices)} vertices and ${count(result.faces)} triangles of the template`
      + `${result.scale ? "; scaled to a common size for the mean" : ""}.`),
    warningList(result.warnings), shown,
    h("p", { class: "actions" },
      linkButton(job.id), " ", download(job.links.result, "JSON", `${job.id}.json`), " ",
      download(job.links.picture, "Picture (PNG)", `${job.id}.png`),
      h("span", {}, "Mean shape and arrays:", exportsOf(job))),
    table("Specimens; distances are those between the registered template and the specimen, over the square root of its area",
      HEADS, rows.map(({ node }) => node)));
  try {
    show = await componentView(shown, result, job, signal);
    if (show !== null) rows.forEach(({ reveal }) => reveal());
  } catch (error) {
    if (!signal.aborted) fill(shown, problemBox(error));
  }
}

function row(one, at, job, shown) {
  const name = one.name ?? one.shape.slice(0, 8);
  const head = h("th", { scope: "row" }, h("a", { href: `#/shapes/${one.shape}` }, name));
  if (!one.registered) return { node: h("tr", {}, head, h("td", { colspan: HEADS.length - 1 }, `not registered: ${one.reason}`)), reveal: () => {} };
  const show = button("Show", () => shown(name), { class: "small", "aria-label": `Show ${name}`, hidden: true });
  head.append(" ", show);
  const node = h("tr", {}, head,
    h("td", {}, confidenceBadge(one), one.reflected ? " reflected: best mirrored before" : null),
    h("td", {}, count(one.flipped)),
    h("td", {}, figure(one.mean_distance)), h("td", {}, figure(one.max_distance)),
    h("td", { class: "files-of" }, FORMATS.flatMap((format) => [" ", download(
      `${job.links.self}/registered.${format}?specimen=${at}`,
      [format.toUpperCase(), h("span", { class: "visually-hidden" }, ` of ${name}`)], `${job.id}-${at}.${format}`)])));
  return { node, reveal: () => { show.hidden = false; } };
}
