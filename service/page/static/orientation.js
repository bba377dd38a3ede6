// Orientation: matches that may be mirrored, and a repetition that preserves orientation.

import { button } from "./actions.js";
import { post } from "./api.js";
import { h } from "./dom.js";
import { againLink } from "./match_again.js";

/** A note on a match that may be mirrored, with a button that repeats it; null if it cannot be. */
export function orientationNote(result, signal) {
  const { parameters, source, target, source_name, target_name } = result;
  const known = parameters.orientation || parameters.dense || parameters.refine || parameters.landmarks.length > 0;
  if (known || result.source_kind !== "shape" || result.alternatives.length === 0) return null;
  const again = button("Match with orientation", async () => {
    const job = await post("/v1/matches", { ...parameters, source, target, source_name, target_name, orientation: true });
    if (!signal.aborted) location.hash = `#/jobs/${job.id}`;
  });
  return h("p", { class: "actions" }, "The energy is the same for the mirror image of this match: left and right may be swapped. ", again,
    h("span", {}, " or ", againLink(result, "give a landmark").filter(Boolean), "."));
}
