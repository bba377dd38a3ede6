// The result of a match: in words, in numbers, in pairs, and in three dimensions.

import { Problem, get } from "./api.js";
import { h, fill } from "./dom.js";
import { download } from "./download.js";
import { leftAndRight } from "./left_and_right.js";
import { linkButton } from "./link.js";
import { pairTable } from "./pairs.js";
import { problemBox } from "./problem.js";
import { Selection } from "./selection.js";
import { pairOfScenes } from "./side_by_side.js";
import { certificate, digits, figure, percent, several } from "./words.js";

export async function matchView(place, result, job, signal) {
  const learned = result.source_kind === "prototype";
  const [source, target] = await Promise.all([
    recordOr(learned ? "prototypes" : "shapes", result.source, signal),
    recordOr("shapes", result.target, signal),
  ]);
  document.title = `${source.name} and ${target.name} – isomatch`;
  const selection = new Selection();
  const numbers = h("dl", { class: "figures" });
  const pairs = h("div");
  const scenes = h("div");
  const picture = h("span");
  const announced = h("p", { class: "visually-hidden", "aria-live": "polite" });
  let drawn = null;
  const choose = async (which) => {
    const hypothesis = hypotheses(result)[which];
    selection.clear();
    fill(numbers, figures(result, hypothesis));
    fill(picture, pictureOf(job, which));
    const colors = drawn === null ? null : await drawn.show(hypothesis);
    fill(pairs, pairTable(hypothesis.correspondences, colors, selection, learned));
  };
  selection.addEventListener("change", () => {
    announced.textContent = selection.chosen === null ? "" : `Pair ${selection.chosen + 1} is chosen.`;
  });
  fill(place,
    h("h2", {}, name(source, learned), " and ", name(target)),
    h("p", { class: "proof" },
      h("span", { class: result.certified ? "badge good" : "badge" }, result.certified ? "certified" : "not certified"),
      " ", summary(result), " ", certificate(result)),
    result.warnings.length ? h("ul", { class: "warnings" }, result.warnings.map((text) => h("li", {}, text))) : null,
    leftAndRight(result), alternatives(result, choose), scenes, numbers,
    h("p", { class: "actions" },
      linkButton(job.id), " ", download(job.links.result, "JSON", `${job.id}.json`), " ",
      picture, " ",
      h("a", { href: `#/with/${result.source}/${result.target}` }, "Match these again, otherwise")),
    announced, pairs);
  await choose(0);
  try {
    drawn = await pairOfScenes(scenes, result, source, target, selection, signal);
    if (drawn !== null) await choose(0);
  } catch (error) {
    if (!signal.aborted) fill(scenes, problemBox(error));
  }
}

const pictureOf = (job, which) => (which === 0
  ? download(job.links.picture, "Picture (PNG)", `${job.id}.png`)
  : download(`${job.links.picture}?alternative=${which}`, "Picture (PNG)", `${job.id}-${which}.png`));

const name = ({ id, name: called }, learned = false) =>
  (id ? h("a", { href: `#/${learned ? "prototypes" : "shapes"}/${id}` }, called) : called);

// A shape may have been deleted since: the numbers are still there.
async function recordOr(kind, id, signal) {
  try {
    return await get(`/v1/${kind}/${encodeURIComponent(id)}`, signal);
  } catch (error) {
    if (error instanceof Problem && [404, 410].includes(error.status)) {
      return { id: null, name: "a shape that is no longer kept", faces: 0 };
    }
    throw error;
  }
}

/** The answer that was chosen and the alternatives, with what is drawn and listed of each. */
function hypotheses(result) {
  return [result, ...result.alternatives].map((answer, which) => ({
    which,
    energy: answer.energy,
    distortion: answer.distortion,
    correspondences: answer.correspondences,
    refined: which === 0 && result.refinement?.hypothesis === 0 ? result.refinement.points : null,
    dense: result.dense?.hypothesis === which ? result.dense : null,
  }));
}

function summary(result) {
  const alone = result.unmatched.length;
  const matched = `${several(result.correspondences.length, "point")} matched`;
  const left = alone ? `, ${alone} left without partner` : "";
  return `${matched}${left}${result.refinement ? ", refined between vertices" : ""}.`;
}

function alternatives(result, choose) {
  if (result.alternatives.length === 0) return null;
  const options = hypotheses(result).map(({ which, energy }) => h("label", {},
    h("input", {
      type: "radio", name: "hypothesis", value: which, checked: which === 0,
      onchange: () => choose(which),
    }), " ", which === 0 ? "Chosen" : `${which}`,
    h("span", { class: "faint" }, which === 0 ? ` ${digits(energy)}` : ` ${more(energy, result.energy)}`)));
  return h("fieldset", { class: "alternatives" },
    h("legend", {}, "Answers and their energies, each among candidates of its own; one is most often the mirror image"), options);
}

function more(energy, least) {
  const share = least > 0 ? energy / least - 1 : 0;
  return share >= 0 ? `+${percent(share)}` : `−${percent(-share)}`;
}

// Bounds are of the problem whose candidates the chosen answer has.
const OTHER = "of the chosen one only";

function figures(result, { which, energy, distortion }) {
  const best = which === 0;
  const entries = [
    ["Energy", figure(energy), "energy"],
    ["Lower bound", best ? figure(result.lower_bound) : OTHER, "lower_bound"],
    ["Gap", best ? h("data", { value: result.gap, title: String(result.gap) }, percent(result.gap)) : OTHER, "gap"],
    ["Distortion of distances", figure(distortion.second_order), "second_order"],
    ["Distortion of descriptors", figure(distortion.first_order), "first_order"],
    ["Greatest distortion", figure(distortion.linf), "linf"],
    ["Gromov–Hausdorff distance of the points, at most", figure(0.5 * distortion.linf), "gromov_hausdorff"],
    ...(typeof result.misfit !== "number" ? [] : [
      ["Misfit of the target to the class (1 is usual)", best ? figure(result.misfit) : OTHER, "misfit"]]),
    ["Computed in", `${digits(result.timings.total)} s`, "seconds"],
  ];
  return entries.map(([term, value, field]) =>
    h("div", {}, h("dt", {}, term), h("dd", { "data-field": field }, value)));
}
