// A link from a match to the form of another, with its parameters.

import { h } from "./dom.js";
import { keepParameters, leftOut } from "./entries.js";
import { enterLandmarks } from "./landmarks.js";
import { MATCH } from "./parameters.js";

/** The link, and a note on parameters that the form has no field for. */
export function againLink({ source, target, source_kind: kind, parameters: { landmarks, ...others } }, text) {
  const learned = kind === "prototype";
  const keep = () => {
    // The points of a prototype are fewer; its other parameters are its own.
    keepParameters(learned ? "recognise" : "match", others, learned ? { points: {} } : MATCH);
    if (!learned) enterLandmarks([source, target], landmarks);
  };
  const left = learned ? [] : leftOut(others, MATCH);
  return [
    h("a", { href: `#/with/${source}/${target}`, onclick: keep }, text),
    left.length === 0 ? null : h("span", { class: "faint" }, `(choose ${left.join(" and ")} again)`),
  ];
}
