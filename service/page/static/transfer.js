// The result of a transfer: what was carried, drawn on the shape that it was carried to.

import { request } from "./api.js";
import { carriedColors, drawable, isPainted, scaleColor, shadesOfFaces, shadesOfVertices } from "./carried_colors.js";
import { css, distinct } from "./colors.js";
import { confidenceNote } from "./confidence.js";
import { fill, h, warningList } from "./dom.js";
import { download, exportsOf } from "./download.js";
import { drawnShape, lifted, rotate } from "./drawn_shape.js";
import { digits, several } from "./format.js";
import { caption, obstacle } from "./match_scenes.js";
import { openNpz } from "./npz.js";
import { recordOf } from "./match.js";
import { problemBox } from "./problem.js";
import { Scene } from "./scene.js";
import { linkButton } from "./share_link.js";
import { matchLink } from "./stopped_job.js";
import { sourceView } from "./view.js";

/** Labels that are named beside the drawing. */
const MOST_NAMED = 24;
/** Steps in which the scale is shown. */
const STEPS = [0, 0.25, 0.5, 0.75, 1];

export async function transferView(place, result, job, signal) {
  const carried = result.attributes.map(({ name }) => name).join(", ") || several(result.points.length, "point");
  const shown = h("div", { class: "carried" });
  fill(place, h("h2", {}, "Transferred values"), h("p", {},
    `${result.what}: ${carried}, from ${result.source_name ?? result.source} to ${result.target_name ?? result.target}`),
  confidenceNote(result), warningList(result.warnings), shown,
  h("p", { class: "actions" }, linkButton(job.id), " ",
    download(job.links.result, "JSON", `${job.id}.json`), exportsOf(job), " ", matchLink(job)));
  try {
    await draw(shown, result, job, signal);
  } catch (error) {
    if (!signal.aborted) fill(shown, problemBox(error));
  }
}

async function draw(place, result, job, signal) {
  if (result.what === "uv") return;
  const target = await recordOf("shapes", result.target, result.target_name, signal);
  const reason = obstacle([target]);
  if (reason !== null) {
    fill(place, h("p", { class: "faint" }, reason));
    return;
  }
  const side = await drawnShape(target, "target", signal);
  if (result.on === "faces" && result.rows * 3 !== side.geometry.faces.length) {
    fill(place, h("p", { class: "faint" }, "Not drawn: the faces of the file are not the triangles of its surface. The files have the values."));
    return;
  }
  rotate(side, sourceView(side.geometry.positions));
  const node = h("div", { class: "scene", "data-side": "target", "aria-label": `${target.name} in three dimensions, with what was carried` });
  const scene = new Scene(node, side.mesh, signal);
  const source = await ownColors(result, signal);
  const legend = h("div");
  const choices = drawable(result);
  const array = result.points === null ? openNpz(await (await request(job.links.arrays, { signal })).arrayBuffer()) : null;
  const show = async (which) => {
    if (array === null) return scene.show(side.mesh.colors, landmarks(result.points, side));
    const { name, at } = choices[which];
    const values = await array(name);
    // A name that is one of the format's own is another in the archive.
    if (values === null) throw new Error(`${name} cannot be drawn; the other files have its values.`);
    const found = carriedColors(result.what, values, at);
    fill(legend, legendOf(found));
    return scene.show(side.mesh.reduced((result.on === "faces" ? shadesOfFaces : shadesOfVertices)(found.colors, side.geometry)));
  };
  fill(place, h("div", { class: "pair" }, source?.figure, caption([node])(side, 0),
    h("div", {}, choices.length > 1 ? choiceOf(choices, show) : null, legend)));
  await Promise.all([source?.show(), show(0)]);
  place.dataset.drawn = String(result.rows || result.points.length);
}

// The source beside the target, if it has colours of its own.
async function ownColors({ what, source, source_name: name }, signal) {
  if (!isPainted(what)) return null;
  const record = await recordOf("shapes", source, name, signal);
  if (record.id === null || !record.has_colors) return null;
  const side = await drawnShape(record, "source", signal);
  rotate(side, sourceView(side.geometry.positions));
  const node = h("div", { class: "scene", "data-side": "source", "aria-label": `${record.name} in three dimensions, in its own colours` });
  const scene = new Scene(node, side.mesh, signal);
  return { figure: caption([node])(side, 0), show: () => scene.show(side.mesh.colors) };
}

const choiceOf = (choices, show) => h("label", {}, "Shown ", h("select", { onchange: (event) => show(Number(event.target.value)) },
  choices.map(({ text }, which) => h("option", { value: which }, text))));

// Landmarks are numbered in their order, from 1; those that are missing are left out.
function landmarks(points, side) {
  const there = points.flatMap((point, i) => (point === null ? [] : [i]));
  return {
    points: there.map((i) => lifted(side, points[i].vertices.map(side.place), points[i].weights)),
    colors: there.map(distinct), names: there.map((i) => String(i + 1)), numbered: true, ring: null,
  };
}

function legendOf({ legend = null, range = null }) {
  if (range !== null) {
    const bar = h("div", { class: "scale" });
    bar.style.background = `linear-gradient(to right, ${STEPS.map((share) => css(scaleColor(share))).join(", ")})`;
    return [bar, h("p", { class: "ends" }, h("span", {}, digits(range[0])), h("span", {}, digits(range[1])))];
  }
  if (legend === null) return [];
  const more = legend.length - MOST_NAMED;
  return [h("ul", { class: "legend" }, legend.slice(0, MOST_NAMED).map(([label, color]) => {
    const swatch = h("span", { class: "swatch" });
    swatch.style.background = css(color);
    return h("li", {}, swatch, label);
  })), more > 0 ? h("p", { class: "faint" }, `and ${several(more, "label")} more`) : null];
}
