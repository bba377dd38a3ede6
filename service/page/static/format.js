// Numbers, times, states and certificates as text.

import { inDoubt } from "./confidence.js";
import { h } from "./dom.js";

const STATES = {
  queued: "waiting",
  running: "running",
  succeeded: "done",
  failed: "failed",
  cancelled: "cancelled",
};
const KINDS = {
  match: "Match",
  batch: "Batch",
  dissimilarities: "Comparison",
  prototype: "Prototype",
  transfer: "Transfer",
  registration: "Registration",
  consistent_maps: "Consistent maps",
  validation: "Upload",
};

/** Names of values that transfers carry, where requests have others. */
const CARRIED = { colors: "colours", skinning: "skinning weights", uv: "texture coordinates" };

export const count = (number) => number.toLocaleString("en");
export const stateName = (state) => STATES[state] ?? state;
/** "Match", "Transfer of landmarks". */
export const kindName = ({ kind, parameters: { what } }) => `${KINDS[kind] ?? kind}${what === undefined ? "" : ` of ${CARRIED[what] ?? what}`}`;
export const time = (iso) => new Date(iso).toLocaleString();

const SPANS = [["day", 86400], ["hour", 3600], ["minute", 60]];
const relative = new Intl.RelativeTimeFormat("en", { numeric: "auto", style: "short" });

/** "3 minutes ago". */
export function ago(iso) {
  const seconds = Math.max(0, (Date.now() - new Date(iso)) / 1000);
  const span = SPANS.find(([, length]) => seconds >= length);
  return span ? relative.format(-Math.floor(seconds / span[1]), span[0]) : "just now";
}

/** "3 points", "1 point". */
export const several = (number, noun) => `${count(number)} ${noun}${number === 1 ? "" : "s"}`;

export function digits(number, significant = 4) {
  if (number === null || number === undefined) return "none";
  if (number === 0) return "0";
  const size = Math.abs(number);
  return size >= 1e-3 && size < 1e5 ? String(Number(number.toPrecision(significant))) : number.toExponential(significant - 1);
}

export function percent(share) {
  const value = 100 * share;
  if (value > 0 && value < 0.01) return "less than 0.01 %";
  // Rounded, less than all would look like all.
  if (value < 100 && value >= 99.5) return value > 99.99 ? "more than 99.99 %" : `${(Math.floor(100 * value) / 100).toFixed(2)} %`;
  return `${value.toFixed(value < 10 ? 2 : 0)} %`;
}

/** A rounded number whose element has all digits. */
export function figure(number) {
  return number === null || number === undefined
    ? "none"
    : h("data", { value: number, title: String(number) }, digits(number));
}

const isDoubtful = (confidence) => Boolean(confidence) && inDoubt(confidence.probability);

/** A badge that says whether a result is certified; where the answer is in doubt, it does not look good. */
export const certifiedBadge = ({ certified, confidence }) =>
  h("span", { class: certified && !isDoubtful(confidence) ? "badge good" : "badge" }, certified ? "certified" : "not certified");

/** The certificate of a match as a sentence. */
export function certificate({ certified, gap, energy, lower_bound: bound }) {
  if (certified) {
    return "No better correspondence among this answer's candidates.";
  }
  if (energy > 0 && bound <= 0) return "No useful lower bound is known for this match.";
  return (
    `Within ${percent(gap)} of the best among this answer's candidates: none has an energy`
    + ` below ${digits(bound)}.`
  );
}

/** Relative difference up to which energies are the same, as for certificates. */
const NEGLIGIBLE = 1e-4;

/** A sentence on correspondences that have less energy and were not chosen, or null if there are none. */
export function lessEnergy({ energy, alternatives, proof, confidence }) {
  const less = (other) => other.energy < energy - NEGLIGIBLE * Math.abs(energy);
  const known = [...(alternatives.some(less) ? ["an alternative"] : []), ...(proof && less(proof) ? ["a correspondence of all samples"] : [])];
  if (!confidence || known.length === 0) return null;
  const subject = known.join(" and ");
  return `${subject[0].toUpperCase()}${subject.slice(1)} ${known.length > 1 ? "have" : "has"} less energy, but the answer was chosen by registration in`
    + ` space, which ${isDoubtful(confidence) ? "is in doubt here" : "tells it from others, such as the mirror image"}.`;
}
