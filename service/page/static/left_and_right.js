// Answers that may be the mirror image of the truth, and the way out.

import { post } from "./api.js";
import { h, button } from "./dom.js";
import { problemBox } from "./problem.js";

/** What is said of left and right where nothing told them apart, with a button that asks again. */
export function leftAndRight(result) {
  const { parameters, source, target } = result;
  const told = parameters.orientation || parameters.dense || parameters.refine || parameters.landmarks.length > 0;
  if (told || result.source_kind !== "shape" || result.alternatives.length === 0) return null;
  const again = button("Tell left from right", async () => {
    try {
      const job = await post("/v1/matches", { ...parameters, source, target, orientation: true });
      location.hash = `#/jobs/${job.id}`;
    } catch (error) {
      again.after(problemBox(error));
    }
  });
  return h("p", { class: "actions" }, "The energy cannot tell this answer from its mirror image. ", again,
    h("span", {}, " or ", h("a", { href: `#/with/${source}/${target}` }, "give a landmark"), "."));
}
