// Landmarks carried along a dense match: seen on both shapes, corrected by hand, and downloaded.

import { Problem, get, post } from "./api.js";
import { Corrections } from "./corrections.js";
import { button, fill, h } from "./dom.js";
import { save } from "./download.js";
import { drawnShape } from "./drawn_shape.js";
import { resultOf } from "./events.js";
import { choiceField } from "./fields.js";
import { isOff, turnOff } from "./focus.js";
import { several } from "./format.js";
import { keepLandmarks, keptLandmarks } from "./kept_landmarks.js";
import { landmarkConfidences } from "./landmark_confidence.js";
import { inFile, onSurface } from "./landmark_distance.js";
import { FORMATS, readLandmarks, writeLandmarks } from "./landmark_files.js";
import { LandmarkScenes } from "./landmark_scenes.js";
import { landmarkTable } from "./landmark_table.js";
import { rotateAll } from "./match_scenes.js";
import { problemBox } from "./problem.js";
import { Selection } from "./selection.js";
import { nearestPoint, normalAt, positionOf } from "./surface_point.js";
import { fileArea } from "./uploads.js";

const ENDS = ["source", "target"];
const [SOURCE, TARGET] = [0, 1];
/** Length of a step by an arrow key, in units of half the shape's size. */
const STEP = 0.01;
const SYSTEMS = [["LPS", "LPS, as 3D Slicer stores models"], ["RAS", "RAS"]];
const KEYS = "Drag a landmark on the target, or choose it here and press an arrow key: it moves along the surface, with Shift in"
  + " finer steps. Landmarks are points of the mesh itself, even where the drawing is simplified. They are kept in this tab until it"
  + " is closed.";

export async function landmarkView(place, [id], signal) {
  const match = await get(`/v1/jobs/${encodeURIComponent(id)}`, signal);
  const result = await resultOf(match, signal);
  if (!result.dense || result.source_kind !== "shape") {
    throw new Problem(0, { title: "No dense map", detail: "Landmarks are carried along the dense map of a match of two shapes; match again with it." });
  }
  // An upload may have another name than the one that its file is stored under.
  const shapes = await Promise.all(ENDS.map(async (end) => {
    const shape = await get(`/v1/shapes/${result[end]}`, signal);
    return { ...shape, name: result[`${end}_name`] ?? shape.name };
  }));
  document.title = `Landmarks of ${shapes[TARGET].name} – isomatch`;
  const sides = await Promise.all(shapes.map((shape, at) => drawnShape(shape, ENDS[at], signal)));
  rotateAll(sides, result.correspondences);

  const said = h("div", { "aria-live": "polite" });
  const list = h("section", { "aria-label": "Landmarks of the target", hidden: true });
  const pictures = h("div");
  const selection = new Selection();
  const scenes = new LandmarkScenes(pictures, sides, selection, signal);
  const system = choiceField("coordinates", "Coordinates of the meshes", SYSTEMS, 0,
    "Positions in files of 3D Slicer name their coordinate system and are converted to that of the meshes.");
  let newest = null;
  const show = (shown) => {
    const { file, end, given, points, remark, sure } = shown;
    fill(said, h("p", {}, `${several(given.length, "landmark")} of ${file}.`), remark === null ? null : h("p", { class: "warnings" }, remark));
    const landmarks = given.map((landmark, i) => landmarkOn(landmark, end, points[end][i], sure?.[i] ?? null));
    return showLandmarks(list, landmarks, shown, { match: id, sides, selection, scenes });
  };
  const take = (end) => async ([file]) => {
    if (file === undefined) return;
    newest = file;
    fill(said, h("p", { class: "faint" }, `Carrying the landmarks of ${file.name}.`));
    try {
      const coordinates = system.querySelector("select").value;
      const given = readLandmarks(file.name, await file.text(), coordinates);
      const { points: here, remark } = onSurface(given, sides[end]);
      if (here.every((point) => point === null)) {
        throw new Problem(0, { title: "No landmark to carry", detail: remark ?? "All landmarks of this file are missing." });
      }
      const there = await carried(match, end, here, sides, signal);
      if (signal.aborted || newest !== file) return;
      const points = end === SOURCE ? [here, there] : [there, here];
      const sure = end === SOURCE ? landmarkConfidences(result, end, points, sides) : null;
      await show({ file: file.name, end, coordinates, given, points, remark, sure, moves: [] });
    } catch (error) {
      if (!signal.aborted && newest === file) fill(said, problemBox(error));
    }
  };
  fill(place,
    h("h2", {}, "Landmarks: ", shapeLink(shapes[SOURCE]), " to ", shapeLink(shapes[TARGET])),
    h("p", {}, h("a", { href: `#/jobs/${id}` }, "Back to the match")),
    h("div", { class: "columns" },
      landmarkFileArea("source", shapes[SOURCE], "They are carried to the target.", take(SOURCE)),
      landmarkFileArea("target", shapes[TARGET], "To correct them; files of isomatch landmarks have a confidence.", take(TARGET)),
      system),
    said, h("div", { class: "columns corrected" }, pictures, list));
  const kept = keptLandmarks(id);
  if (kept !== null) {
    system.querySelector("select").value = kept.coordinates;
    show(kept);
  }
  await scenes.begin();
}

const shapeLink = ({ id, name }) => h("a", { href: `#/shapes/${id}` }, name);

const landmarkFileArea = (end, { name }, about, take) => fileArea(
  { id: `landmarks-${end}`, accept: ".json,.fcsv,.csv" }, [h("strong", {}, `Choose landmarks of the ${end}`), `, ${name}`],
  `MRK.JSON, FCSV or CSV. ${about}`, take);

// What is known of a landmark of the target, from a file of the end `end`, its point there, and how sure it is if it was
// carried; `lack` says why it has no point.
function landmarkOn({ label, remark: description, position }, end, point, sure) {
  const remarkThere = end === TARGET ? description : sure === null ? "" : `confidence ${sure.toFixed(2)}`;
  return {
    label, remark: remarkThere, lack: point !== null ? "" : position === null ? "missing" : "left out",
    confidence: remarkThere.match(/^confidence (\d+(?:\.\d+)?)$/)?.[1] ?? null,
  };
}

// The images of points on the other shape, by a transfer of the service.
async function carried(match, end, points, sides, signal) {
  const [here, there] = [sides[end], sides[1 - end]];
  const given = points.filter((point) => point !== null).map(({ corners, weights }) => ({
    vertices: corners.map((corner) => here.geometry.numbers[corner]), weights: weights.map((weight) => Math.max(0, weight)),
  }));
  const job = await post("/v1/transfers", {
    match: match.id, what: "landmarks", direction: end === SOURCE ? "source_to_target" : "target_to_source", points: given,
  });
  const found = (await resultOf(job, signal)).points.map((point) => point && (
    { corners: point.vertices.map(there.place), weights: point.weights }));
  return points.map((point) => (point === null ? null : found.shift()));
}

async function showLandmarks(list, landmarks, shown, { match, sides, selection, scenes }) {
  const side = sides[TARGET];
  const [source, target] = shown.points;
  const corrections = new Corrections(target, shown.moves);
  const step = (i, right, up) => {
    const [across, upwards] = scenes.axes;
    const before = corrections.points[i];
    const { positions } = side.geometry;
    const aim = positionOf(positions, before).map((value, k) => value + STEP * (right * across[k] + up * upwards[k]));
    corrections.move(i, nearestPoint(side.geometry, aim, normalAt(positions, before)) ?? before);
  };
  const undo = h("button", { type: "button", onclick: () => corrections.undo() }, "Undo");
  const resetAll = h("button", { type: "button", onclick: () => isOff(resetAll) || corrections.resetAll() }, "Reset all");
  const update = () => {
    turnOff(undo, !corrections.canUndo);
    turnOff(resetAll, !corrections.anyMoved);
    if (!corrections.dragging) keepLandmarks(match, { ...shown, moves: corrections.moves });
  };
  corrections.addEventListener("change", update);
  update();
  const name = side.shape.name.replace(/\.[^.]*$/, "");
  const text = (format) => writeLandmarks(format, name, landmarks.map(({ label, remark: description }, i) => ({
    label, remark: corrections.moved(i) ? "corrected" : description,
    position: corrections.points[i] === null ? null : inFile(side, corrections.points[i]),
  })), shown.coordinates);
  selection.clear();
  list.hidden = false;
  fill(list,
    h("p", { id: "landmark-keys", class: "faint" }, KEYS),
    landmarkTable(landmarks, corrections, selection, step),
    h("p", { class: "actions" }, undo, resetAll),
    h("p", { class: "actions" }, "Download: ", FORMATS.map((format) => button(format.toUpperCase(), () =>
      save(new Blob([text(format)]), `${name}.${format}`)))));
  await scenes.show(landmarks, source, corrections);
}
