// Confidence of matches: badges in three colours, and the reasons for doubt.

import { h, withCode } from "./dom.js";

/** Probability of being right above which an answer is not in doubt (broker/contracts/results.py). */
const LIKELY_RIGHT = 0.5;
/** Probability from which on nobody needs to check it. */
const SURE = 0.9;

export const inDoubt = (probability) => probability <= LIKELY_RIGHT;

const LEVELS = [
  { holds: inDoubt, badge: "doubt", meaning: "The answer may be wrong." },
  { holds: (one) => one < SURE, badge: "fair", meaning: "The answer is likely right; check it." },
  { holds: () => true, badge: "good", meaning: "The answer is almost certainly right." },
];

const levelOf = (probability) => LEVELS.find(({ holds }) => holds(probability));

/** "97 %", never 0 or 100: no calibration is as sure as that. */
export const confidencePercent = (probability) => `${Math.min(Math.max(Math.round(100 * probability), 1), 99)} %`;

function badge({ probability }) {
  const said = `confidence ${confidencePercent(probability)}`;
  return h("span", { class: `badge ${levelOf(probability).badge}` }, inDoubt(probability) ? `in doubt, ${said}` : said);
}

const list = (reasons) => h("ul", {}, reasons.map((reason) => h("li", {}, withCode(reason))));

/** Confidence of a match as a badge, with the reasons for doubt below when it is opened; null likewise. */
export function confidenceBadge({ confidence }) {
  if (!confidence) return null;
  const { reasons } = confidence;
  return reasons.length === 0 ? badge(confidence)
    : h("details", { class: "reasons" }, h("summary", {}, badge(confidence), h("span", { class: "visually-hidden" }, ", reasons for doubt")), list(reasons));
}

/** Confidence of a match, with the reasons for doubt; null where its surfaces were not registered. */
export function confidenceNote({ confidence }) {
  if (!confidence) return null;
  const { probability, reasons } = confidence;
  return h("div", { class: "confidence", "data-field": "confidence" },
    h("p", {}, badge(confidence), " ", levelOf(probability).meaning,
      reasons.length > 0 ? " Reasons for doubt:" : null),
    reasons.length > 0 ? list(reasons) : null);
}
