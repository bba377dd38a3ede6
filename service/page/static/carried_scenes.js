// Values or landmarks of a transfer, drawn on both of its shapes with the same colours.

import { attempt } from "./actions.js";
import { PATIENCE_FOR_FILES, get, orNull, request } from "./api.js";
import { carriedColors, drawable, scaleColor, shadesOfFaces, shadesOfVertices } from "./carried_colors.js";
import { behindNames, css, distinct } from "./colors.js";
import { fill, h } from "./dom.js";
import { drawnShape, lifted } from "./drawn_shape.js";
import { digits, several } from "./format.js";
import { recordOf } from "./match.js";
import { caption, join, obstacle, rotateAll, toggle } from "./match_scenes.js";
import { openNpz } from "./npz.js";
import { Scene } from "./scene.js";
import { Selection } from "./selection.js";

/** Labels that are named beside the drawing. */
const MOST_NAMED = 24;
/** Labels whose colours are told apart at a glance. */
const MOST_DISTINCT = 12;
/** Steps in which the scale is shown. */
const STEPS = [0, 0.25, 0.5, 0.75, 1];
const ENDS = ["source", "target"];
/** Position of a missing landmark, which is not drawn. */
const NOWHERE = [NaN, NaN, NaN];
const OTHER_FACES = "the faces of its file are not the triangles of its surface";

/**
 * Draw what was carried, on the source and on the target.
 *
 * Values are those of the files of the job: of the source, those that were given. What cannot be drawn is said.
 */
export async function drawCarried(place, result, job, signal) {
  if (result.what === "uv") return;
  const [source, target] = await Promise.all(ENDS.map((end) => recordOf("shapes", result[end], result[`${end}_name`], signal)));
  const reason = obstacle([target]);
  if (reason !== null) {
    fill(place, h("p", { class: "faint" }, reason));
    return;
  }
  const ends = await Promise.all([given(source, result, job, signal), carried(target, result, job, signal)]);
  const parts = ends.filter(({ remark }) => remark === undefined);
  const remarks = ends.flatMap(({ remark = null }, at) => (remark === null ? [] : [`The ${ENDS[at]} is not drawn: ${remark}.`]));
  if (parts.length > 0) await drawParts(place, parts, result, job, signal);
  place.append(...remarks.map((text) => h("p", { class: "faint" }, text)));
}

async function drawParts(place, parts, result, job, signal) {
  const sides = parts.map(({ side }) => side);
  rotateAll(sides, sides.length === 2 ? await pairsOf(result, job, signal) : []);
  const options = { together: true };
  const nodes = sides.map(({ shape, end }) => h("div", {
    class: "scene", "data-side": end, "aria-label": `${shape.name} in three dimensions, with what was carried`,
  }));
  const legend = h("div");
  const choices = result.points === null ? drawable(result) : [];
  const scenes = sides.map(({ mesh }, at) => new Scene(nodes[at], mesh, signal));
  const show = async (which) => {
    if (result.points !== null) {
      return Promise.all(scenes.map(async (scene, at) => scene.show(behindNames(sides[at].mesh.colors, true), await landmarks(parts[at]))));
    }
    const { name, at: column } = choices[which];
    // A texture is seen on its own shape as it is.
    const painted = parts.filter(({ array }) => array !== null);
    const values = await Promise.all(painted.map(({ array }) => array(name)));
    // A name that is one of the format's own is another in the archive.
    if (values.includes(null)) throw new Error(`${name} cannot be drawn; the other files have its values.`);
    const { colors, ...scale } = carriedColors(result.what, values, column);
    fill(legend, legendOf(scale));
    return Promise.all(parts.map((part, at) => scenes[at].show(shadesOn(part, colors[painted.indexOf(part)]))));
  };
  fill(place, h("div", { class: "pair" }, sides.map(caption(nodes))),
    sides.length === 2 ? h("p", { class: "checks" }, toggle("Turn both together", options, "together", () => {})) : null,
    choices.length > 1 ? choiceOf(choices, show) : null, legend);
  await show(0);
  if (signal.aborted) return;
  if (scenes.length === 2) join(scenes, new Selection(), options);
  place.dataset.drawn = String(result.rows || result.points.length);
}

const shadesOn = ({ side, array, isOfFaces }, colors) => (array === null ? side.mesh.colors
  : side.mesh.reduced((isOfFaces ? shadesOfFaces : shadesOfVertices)(colors, side.geometry)));

// The shape that was carried to, with the arrays of the result.
async function carried(target, result, job, signal) {
  const [side, array] = await Promise.all([drawnShape(target, "target", signal), arraysOf(job.links.arrays, signal)]);
  return partOf(side, array, result, result.on);
}

// The shape that was carried from, with the arrays that were given.
async function given(source, result, job, signal) {
  if (source.id === null) return { remark: "it is no longer kept" };
  const side = await drawnShape(source, "source", signal);
  if (result.what === "texture") return source.has_colors ? { side, array: null } : { remark: "its colours are not known" };
  const array = await orNull(arraysOf(`/v1/transfers/${job.id}/source.npz`, signal));
  return array === null ? { remark: "what was given is no longer kept" } : partOf(side, array, result);
}

const arraysOf = async (path, signal) => openNpz(await (await request(path, { signal, patience: PATIENCE_FOR_FILES })).arrayBuffer());

// Rows are of vertices, up to the last used one or up to the last, or of faces.
async function partOf(side, array, { points, attributes: [first] }, on = null) {
  if (points !== null) return { side, array, isOfFaces: false };
  const { shape, geometry: { faces, numbers } } = side;
  const rows = (await array(first.name))?.shape[0];
  const used = numbers.reduce((most, number) => Math.max(most, number), -1) + 1;
  const isOfFaces = on === "faces" || (on === null && rows !== undefined && rows !== used && rows !== shape.file_vertices);
  return isOfFaces && 3 * rows !== faces.length ? { remark: OTHER_FACES } : { side, array, isOfFaces };
}

// Pairs of matched points, which the drawings are aligned by.
async function pairsOf({ direction }, job, signal) {
  const pairs = (await orNull(get(`${job.links.match}/result`, signal)))?.correspondences ?? [];
  return direction === "source_to_target" ? pairs : pairs.map(({ source, target }) => ({ source: target, target: source }));
}

function choiceOf(choices, show) {
  const shown = h("select", { onchange: () => attempt(label, () => show(Number(shown.value))) },
    choices.map(({ text }, which) => h("option", { value: which }, text)));
  const label = h("label", {}, "Shown ", shown);
  return label;
}

// Landmarks are numbered in their order, from 1; those that are missing are nowhere.
async function landmarks({ side, array }) {
  const [vertices, weights] = await Promise.all([array("vertices"), array("weights")]);
  const points = Array.from({ length: vertices.shape[0] }, (_, i) => {
    const [corners, shares] = [vertices, weights].map(({ data }) => [...data.subarray(3 * i, 3 * i + 3)]);
    const places = corners.map(side.place);
    return places.includes(undefined) ? NOWHERE : lifted(side, places, shares);
  });
  return { points, colors: points.map((_, i) => distinct(i)), names: points.map((_, i) => String(i + 1)), numbered: true, ring: null };
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
  })), more > 0 ? h("p", { class: "faint" }, `and ${several(more, "more label")}`) : null,
  legend.length > MOST_DISTINCT ? h("p", { class: "faint" },
    `Of ${several(legend.length, "label")} some have colours that look alike; the files have the labels themselves.`) : null];
}
