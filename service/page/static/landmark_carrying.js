// Landmarks of a file that are carried along a dense match, and what is written of them.
//
// Carried landmarks have `file`, the name of the file, `end`, 0 for the source, whose landmarks it has, and their
// `coordinates`; `given`, the landmarks in it; `points` on the source and on the target, each with the `vertices` of the
// shape's file and `weights`, null where there is none; `positions` on the target, in the coordinates of its file; `sure`, their
// confidences, or null; `remark`, the warnings of the service, or null; and `moves`, the corrections on the target: index,
// point of the drawn surface, and position of each.

import { post } from "./api.js";
import { resultOf } from "./events.js";
import { positionOf } from "./surface_point.js";

const [SOURCE, TARGET] = [0, 1];
const DIRECTIONS = ["source_to_target", "target_to_source"];
/** Labels that the service takes; it calls others by their numbers. */
const LABEL = /^[^\p{C}\p{Zl}\p{Zp}]{0,200}$/u;

/**
 * Carry landmarks from one shape of a match to the other, by a transfer of the service.
 * @param {string} match id of its job
 * @param {Object} template `file`, `end`, `coordinates` and `given`
 * @throws {Problem} none of the landmarks can be carried
 */
export async function carryLandmarks(match, { file, end, coordinates, given }, signal) {
  const sent = given.map(({ label, position }) => ({ label: LABEL.test(label) ? label : null, position }));
  const job = await post("/v1/transfers", { match, what: "landmarks", direction: DIRECTIONS[end], landmarks: sent });
  const { landmarks, warnings } = await resultOf(job, signal);
  const ends = [landmarks.map(({ on_source: point }) => point), landmarks.map((image) => (image.vertices === null ? null : image))];
  if (end === TARGET) ends.reverse();
  return {
    file, end, coordinates, given, remark: warnings.join(". ") || null, moves: [],
    points: ends.map((points) => points.map((point) => point && { vertices: point.vertices, weights: point.weights })),
    positions: ends[TARGET].map((point) => point && point.position),
    sure: end === SOURCE ? landmarks.map(({ confidence }) => confidence) : null,
  };
}

/** Points on a shape that is drawn, as surface_point.js has them. */
export const drawnPoints = (points, { place }) =>
  points.map((point) => point && { corners: point.vertices.map(place), weights: point.weights });

/** Whether a problem is one of the landmarks that are to be carried, whatever the match. */
export const isOfLandmarks = ({ errors = [] }) => errors.some(({ field }) => field.startsWith("body.landmarks"));

/** A sentence on landmarks of the source that were left out, or null. */
export function leftOut({ given, points }) {
  const names = given.flatMap(({ label, position }, i) => (position !== null && points[SOURCE][i] === null ? [`"${label}"`] : []));
  return names.length === 0 ? null : `Left out, far from the surface: ${names.join(", ")}.`;
}

/** Landmarks with their corrections: the index and the point of each that was moved. */
export const withMoves = (carried, side, moves) => ({ ...carried, moves: moves.map(([i, point]) => [i, point, inFile(side, point)]) });

// Position of a point in the coordinates of the shape's file.
function inFile({ unrotated }, point) {
  const place = positionOf(unrotated.positions, point);
  return place.map((value, k) => unrotated.origin[k] + unrotated.scale * value);
}

/** Description of each landmark of the target: `label`, `remark`, `confidence`, and `lack`, which says why it has no point. */
export const landmarksOf = ({ given, end, points, sure }) => given.map(({ label, remark: description, position }, i) => {
  const point = points[end][i];
  const known = sure?.[i] ?? null;
  const remark = end === TARGET ? description : known === null ? "" : `confidence ${known.toFixed(2)}`;
  return {
    label, remark, lack: point !== null ? "" : position === null ? "missing" : "left out",
    confidence: remark.match(/^confidence (\d+(?:\.\d+)?)$/)?.[1] ?? null,
  };
});

/** Landmarks of the target as files have them, see landmark_files.js. */
export function writtenOf(carried) {
  const moved = new Map(carried.moves.map(([i, , position]) => [i, position]));
  return landmarksOf(carried).map(({ label, remark, confidence }, i) => ({
    label, remark: moved.has(i) ? "corrected" : remark, confidence: moved.has(i) ? null : confidence, position: moved.get(i) ?? carried.positions[i],
  }));
}
