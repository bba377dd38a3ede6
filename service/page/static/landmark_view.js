// Landmarks carried along a dense match: seen on both shapes, corrected by hand, and downloaded.

import { button } from "./actions.js";
import { Problem, get, shapeRecord } from "./api.js";
import { Corrections } from "./corrections.js";
import { fill, h } from "./dom.js";
import { save } from "./download.js";
import { drawnShape } from "./drawn_shape.js";
import { resultOf } from "./events.js";
import { isOff, turnOff } from "./focus.js";
import { several } from "./format.js";
import { keepLandmarks, keptLandmarks } from "./kept_landmarks.js";
import { carryLandmarks, drawnPoints, landmarksOf, withMoves, writtenOf } from "./landmark_carrying.js";
import { landmarkCollectionView } from "./landmark_collection.js";
import { landmarkFileArea, mayReplace, systemField } from "./landmark_fields.js";
import { FORMATS, readLandmarks, stemOf, writeLandmarks } from "./landmark_files.js";
import { LandmarkScenes } from "./landmark_scenes.js";
import { landmarkTable } from "./landmark_table.js";
import { rotateAll } from "./match_scenes.js";
import { problemBox } from "./problem.js";
import { Selection } from "./selection.js";
import { nearestPoint, normalAt, positionOf } from "./surface_point.js";

const ENDS = ["source", "target"];
const [SOURCE, TARGET] = [0, 1];
/** Length of a step by an arrow key, in units of half the shape's size. */
const STEP = 0.01;
const KEYS = "Drag a landmark on the target, or choose it here and press an arrow key: it moves along the surface, with Shift in"
  + " finer steps. Landmarks are points of the mesh itself, even where the drawing is simplified. They are kept in this tab until it"
  + " is closed.";

export async function landmarkView(place, [id], signal) {
  const match = await get(`/v1/jobs/${encodeURIComponent(id)}`, signal);
  if (match.kind === "batch") return landmarkCollectionView(place, match, signal);
  const result = await resultOf(match, signal);
  if (!result.dense || result.source_kind !== "shape") {
    throw new Problem(null, { title: "No dense map", detail: "Landmarks are carried along the dense map of a match of two shapes; match again with it." });
  }
  // An upload may have another name than the one that its file is stored under.
  const shapes = await Promise.all(ENDS.map(async (end) => {
    const shape = await shapeRecord(result[end], signal);
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
  const system = systemField();
  let corrections = new Corrections([]);
  let table = new AbortController();
  let newest = null;
  const show = (shown) => {
    const { file, given, remark } = shown;
    fill(said, h("p", {}, `${several(given.length, "landmark")} of ${file}.`), remark === null ? null : h("p", { class: "warnings" }, remark));
    const [source, target] = shown.points.map((points, at) => drawnPoints(points, sides[at]));
    corrections = new Corrections(target, shown.moves);
    table.abort();
    table = new AbortController();
    return showLandmarks(list, shown, source, corrections, { match: id, sides, selection, scenes }, table.signal);
  };
  const take = (end) => async ([file]) => {
    if (file === undefined || !(await mayReplace(corrections.anyMoved))) return;
    newest = file;
    fill(said, h("p", { class: "faint" }, `Carrying the landmarks of ${file.name}.`));
    try {
      const coordinates = system.querySelector("select").value;
      const given = readLandmarks(file.name, await file.text(), coordinates, shapes[end].name);
      const carried = await carryLandmarks(id, { file: file.name, end, coordinates, given }, signal);
      if (!signal.aborted && newest === file) await show(carried);
    } catch (error) {
      if (!signal.aborted && newest === file) fill(said, problemBox(error));
    }
  };
  fill(place,
    h("h2", {}, "Landmarks: ", shapeLink(shapes[SOURCE]), " to ", shapeLink(shapes[TARGET])),
    h("p", { class: "actions" }, await specimenLinks(match, signal), h("a", { href: `#/jobs/${id}` }, "Back to the match")),
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

// Links to the other specimens of a batch: all, and those beside this one that are matched.
async function specimenLinks({ id, batch }, signal) {
  if (batch === null) return null;
  const matched = (await get(`/v1/batches/${batch}`, signal)).matches.filter(({ state }) => state === "succeeded");
  const at = matched.findIndex(({ job }) => job === id);
  const linkTo = (other, text) => other && h("a", { href: `#/landmarks/${other.job}` }, `${text}: ${other.target_name ?? "unnamed"}`);
  return [h("a", { href: `#/landmarks/${batch}` }, "All specimens"), linkTo(matched[at - 1], "Previous"), linkTo(matched[at + 1], "Next")];
}

const shapeLink = ({ id, name }) => h("a", { href: `#/shapes/${id}` }, name);

async function showLandmarks(list, shown, source, corrections, { match, sides, selection, scenes }, signal) {
  const side = sides[TARGET];
  const landmarks = landmarksOf(shown);
  const now = () => withMoves(shown, side, corrections.moves);
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
    if (!corrections.dragging) keepLandmarks(match, now());
  };
  corrections.addEventListener("change", update);
  update();
  const name = stemOf(side.shape.name);
  const text = (format) => writeLandmarks(format, name, writtenOf(now()), shown.coordinates);
  selection.clear();
  list.hidden = false;
  fill(list,
    h("p", { id: "landmark-keys", class: "faint" }, KEYS),
    landmarkTable(landmarks, corrections, selection, step, signal),
    h("p", { class: "actions" }, undo, resetAll),
    h("p", { class: "actions" }, "Download: ", FORMATS.map((format) => button(format.toUpperCase(), () =>
      save(new Blob([text(format)]), `${name}.${format}`)))));
  await scenes.show(landmarks, source, corrections);
}
