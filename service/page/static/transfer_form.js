// The form that carries attributes along the dense map of a match.

import { post, upload } from "./api.js";
import { fill, h } from "./dom.js";
import { choiceField, fileField, showErrors } from "./fields.js";
import { occupied } from "./focus.js";
import { fieldName, problemBox } from "./problem.js";

const ENDINGS = ".npz,.csv,.ply,.obj,.glb,.seg,.txt";
/** Formats of shapes whose own files may have what is carried; others have none. */
const OWN = { texture: ["glb", "gltf", "zip"], uv: ["glb", "gltf", "obj", "zip"] };
const OWN_VALUES = ["csv", "glb", "obj", "ply", "txt"];
const KINDS = [
  ["labels", "labels, such as a segmentation"],
  ["scalars", "scalars"],
  ["vectors", "vectors"],
  ["colors", "colours"],
  ["skinning", "skinning weights"],
  ["texture", "the texture of the shape's own file"],
  ["uv", "its texture coordinates (UV)"],
];
/** Labels of the fields of a request in the form. */
export const LABELS = { attributes: "File of values", what: "Kind", direction: "Direction", on: "Onto" };
const ELEMENTS = [
  ["", "what the values are of"],
  ["vertices", "vertices"],
  ["faces", "faces"],
];

/** A form for a transfer between the shapes of a match; the page of its job has the result. */
export function transferForm(match, source, target, signal) {
  const file = fileField("attributes", LABELS.attributes, ENDINGS,
    "NPZ, CSV, PLY, OBJ, GLB, or one label a line (SEG, TXT); row i of vertex i, or of face i. Without one, values in the shape's own file are carried.");
  const said = h("div", { "aria-live": "polite" });
  const submit = h("button", { type: "submit", class: "primary" }, "Transfer");
  const kinds = choiceField("what", LABELS.what, KINDS, 0, "Labels are carried by majority, all others by weighted means.");
  const directions = choiceField("direction", LABELS.direction, [
    ["source_to_target", `from ${source.name} to ${target.name}`],
    ["target_to_source", `from ${target.name} to ${source.name}`],
  ], 0, "The values are those of the first of the two.");
  const [input, kind, direction] = [file, kinds, directions].map((field) => field.querySelector("input, select"));
  const given = () => (direction.value === "source_to_target" ? source : target);
  // Until a kind is chosen: without a file, what the shape's own file is known to have.
  let chosen = false;
  const preselect = () => {
    if (!chosen) kind.value = input.files.length === 0 && given().has_colors ? "colors" : "labels";
  };
  kind.addEventListener("change", () => { chosen = true; });
  for (const field of [input, direction]) field.addEventListener("change", preselect);
  preselect();
  const form = h("form", { novalidate: true, "aria-label": "Transfer" },
    h("div", { class: "fields" }, file, kinds, directions,
      choiceField("on", LABELS.on, ELEMENTS, 0, "A face takes the label of most of its area, or the mean over it.")),
    said, h("p", {}, submit));
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    await occupied(submit, async () => {
      showErrors(form, [], fieldName);
      fill(said);
      try {
        const { what, direction: towards, on } = Object.fromEntries(new FormData(form));
        const [values] = input.files;
        const lacking = values === undefined ? lack(what, given()) : null;
        if (lacking !== null) {
          showErrors(form, [{ field: "attributes", message: lacking }], fieldName);
          return;
        }
        const told = (_, job) => {
          const text = job?.waiting_for === "worker" ? `${values.name} waits: no worker is alive.` : `Uploading ${values.name}.`;
          if (said.textContent !== text) fill(said, h("p", { class: "faint" }, text));
        };
        const attributes = values === undefined ? null : (await upload("/v1/attributes", values, told, signal)).id;
        const job = await post("/v1/transfers", { match: match.id, attributes, what, direction: towards, on: on || null });
        if (!signal.aborted) location.hash = `#/jobs/${job.id}`;
      } catch (error) {
        fill(said, problemBox(error));
        showErrors(form, error.errors ?? [], fieldName);
      }
    });
  });
  return h("details", { class: "more" }, h("summary", {}, "Transfer: carry values of vertices or faces from one shape to the other"), form);
}

/** The reason why the own file of a shape has nothing of a kind to carry, or null if it may have some. */
function lack(what, { name, file_type: type, has_colors: colored }) {
  if (what === "colors" ? colored : (OWN[what] ?? OWN_VALUES).includes(type)) return null;
  return `${name} has none in its own file; choose ${what in OWN ? "another kind" : "a file of values"}.`;
}
