// Landmarks of a file that are carried along a dense match, and what is written of them.
//
// Carried landmarks have `file`, the name of the file, `end`, 0 for the source, whose landmarks it has, and their
// `coordinates`; `given`, the landmarks in it; `points` on the source and on the target, null where there is none; `remark` on
// those that are far from the surface and on labels that recur, or null; `sure`, their confidences, or null; `moves`, the
// corrections; and `positions` on the target, corrections included, in the coordinates of its file.

import { Problem, post } from "./api.js";
import { resultOf } from "./events.js";
import { landmarkConfidences } from "./landmark_confidence.js";
import { inFile, onSurface } from "./landmark_distance.js";

const [SOURCE, TARGET] = [0, 1];

/**
 * Carry landmarks from one shape of a match to the other.
 * @param {Object} match `id` of its job, its `result`, and both shapes as `sides`: see drawn_shape.js
 * @param {Object} template `file`, `end`, `coordinates` and `given`
 * @throws {Problem} none of the landmarks can be carried
 */
export async function carryLandmarks({ id, result, sides }, { file, end, coordinates, given }, signal) {
  const { points: here, remark } = usablePoints(given, sides[end]);
  const there = await images(id, end, here, sides, signal);
  const points = end === SOURCE ? [here, there] : [there, here];
  const sure = end === SOURCE ? landmarkConfidences(result, end, points, sides) : null;
  return withMoves({ file, end, coordinates, given, points, remark, sure }, sides[TARGET], []);
}

/**
 * The points of a surface that landmarks are carried from, as `onSurface` has them.
 * @throws {Problem} there are none
 */
export function usablePoints(given, side) {
  const { points, remark } = onSurface(given, side);
  if (points.every((point) => point === null)) {
    throw new Problem(0, { title: "No landmark to carry", detail: remark ?? "All landmarks of this file are missing." });
  }
  return { points, remark: [...recurring(given), ...(remark === null ? [] : [remark])].join(" ") || null };
}

/** A sentence for each label of several landmarks, as the client has them (client/isomatch/_landmarks/remarks.py). */
export function recurring(given) {
  const counts = new Map();
  for (const { label } of given) counts.set(label, (counts.get(label) ?? 0) + 1);
  return [...counts].filter(([, times]) => times > 1)
    .map(([label, times]) => `${times} landmarks are called "${label}"; only their order tells them apart.`);
}

// The images of points on the other shape, by a transfer of the service.
async function images(match, end, points, sides, signal) {
  const [here, there] = [sides[end], sides[1 - end]];
  const given = points.filter((point) => point !== null).map(({ corners, weights }) => ({
    vertices: corners.map((corner) => here.geometry.numbers[corner]), weights: weights.map((weight) => Math.max(0, weight)),
  }));
  const job = await post("/v1/transfers", {
    match, what: "landmarks", direction: end === SOURCE ? "source_to_target" : "target_to_source", points: given,
  });
  const found = (await resultOf(job, signal)).points.map((point) => point && (
    { corners: point.vertices.map(there.place), weights: point.weights }));
  return points.map((point) => (point === null ? null : found.shift()));
}

/** Landmarks with their corrections: the index and the point of each that was moved. */
export function withMoves(carried, side, moves) {
  const moved = new Map(moves);
  const positions = carried.points[TARGET].map((point, i) => (point === null ? null : inFile(side, moved.get(i) ?? point)));
  return { ...carried, moves, positions };
}

/** What is known of each landmark of the target: `label`, `remark`, `confidence`, and `lack`, which says why it has no point. */
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
  const moved = new Set(carried.moves.map(([i]) => i));
  return landmarksOf(carried).map(({ label, remark, confidence }, i) => ({
    label, remark: moved.has(i) ? "corrected" : remark, confidence: moved.has(i) ? null : confidence, position: carried.positions[i],
  }));
}
