// Fields of a form, each with a label and a hint.

import { h } from "./dom.js";

function labelled(name, label, field, about) {
  const hint = h("p", { id: `about-${name}`, class: "faint" }, about);
  field.id = `field-${name}`;
  field.setAttribute("aria-describedby", `about-${name} error-${name}`);
  return h("div", { class: "field" }, h("label", { for: field.id }, label), field, hint,
    h("p", { id: `error-${name}`, class: "error", hidden: true }));
}

const spaced = (name) => name.replaceAll("_", " ");
const titled = (name) => spaced(name)[0].toUpperCase() + spaced(name).slice(1);

function range({ min, above, max }) {
  return above === undefined ? `From ${min} to ${max}.` : `Over ${above}, up to ${max}.`;
}

/** @param {Object} about default, range and meaning of the parameter: see parameters.js */
export const numberField = (name, about) =>
  labelled(name, titled(name), h("input", {
    name, type: "number", value: about.default, min: about.min ?? about.above, max: about.max,
    step: about.type === "integer" ? 1 : "any",
  }), `${about.about} ${range(about)}`);

export const textField = (name, label, value, about) =>
  labelled(name, label, h("input", { name, type: "text", value, maxlength: 200 }), about);

export const fileField = (name, label, accept, about) =>
  labelled(name, label, h("input", { name, type: "file", accept }), about);

/** @param {Array<Array<string>>} options values, each with its text */
export const choiceField = (name, label, options, chosen, about) =>
  labelled(name, label, h("select", { name }, options.map(([value, text], at) =>
    h("option", { value, selected: at === chosen }, text))), about);

export function structureField(name, { about, default: usual }, structures, shapes) {
  const colored = shapes.every((shape) => shape.has_colors);
  const hint = `${about} The recommended ones suit most shapes.`;
  const field = h("select", { name },
    h("option", { value: "" }, `recommended: ${[usual].flat().map(spaced).join(", then ")}`),
    structures.map((structure) => h("option", {
      value: structure.name, disabled: structure.needs_colors && !colored,
    }, spaced(structure.name), structure.needs_colors ? " (needs vertex colours)" : "")));
  const box = labelled(name, titled(name), field, hint);
  field.addEventListener("change", () => {
    const found = structures.find((structure) => structure.name === field.value);
    box.querySelector(`#about-${name}`).textContent = found
      ? `${found.description} ${invariances(found.invariance)}`
      : hint;
  });
  return box;
}

/** The parameters that a form has no fields for yet, folded; what is left empty is not sent. */
export function moreFields(parameters, shown) {
  const names = new Set(shown.flat(2).filter(Boolean)
    .flatMap((node) => [...node.querySelectorAll("[name]")].map((field) => field.name)));
  const more = Object.entries(parameters).filter(([name]) => !names.has(name))
    .map(([name, about]) => optionalField(name, about)).filter(Boolean);
  return h("details", { class: "more" }, h("summary", {}, "More parameters"),
    h("div", { class: "fields" }, more));
}

function optionalField(name, about) {
  const { type, values, default: usual } = about;
  if (type === "integer" || type === "number") {
    const box = numberField(name, { ...about, default: "" });
    if (usual !== null) box.querySelector("input").placeholder = usual;
    return box;
  }
  const options = type === "boolean" ? ["true", "false"] : values;
  if (options === undefined) return null;
  const others = options.filter((value) => value !== String(usual)).map((value) => [value, value]);
  const box = choiceField(name, titled(name), [["", usual === null ? "none" : String(usual)], ...others], 0, about.about);
  if (type === "boolean") box.querySelector("select").dataset.json = "true";
  return box;
}

export function checkbox(name, value, label, checked) {
  const json = typeof value !== "string" || name === "labels";
  return h("label", { class: "check" },
    h("input", { type: "checkbox", name, value: String(value), checked, "data-json": json }), " ", label);
}

/** A checkbox whose state is the value of a parameter, by default the parameter's own default. */
export const switchField = (name, about, label) => h("label", { class: "check" },
  h("input", { type: "checkbox", name, checked: about.default, "data-switch": true }), " ", label);

/** Mark the fields that were refused, each with the reason, and go to the first. */
export function showErrors(form, errors, nameOf) {
  for (const field of form.querySelectorAll("[aria-invalid]")) field.removeAttribute("aria-invalid");
  for (const text of form.querySelectorAll(".error")) text.hidden = true;
  for (const { field, message } of errors) {
    const name = nameOf(field).split(".")[0];
    const text = form.querySelector(`#error-${CSS.escape(name)}`);
    if (text === null) continue;
    form.querySelector(`#field-${CSS.escape(name)}`).setAttribute("aria-invalid", "true");
    text.textContent = message;
    text.hidden = false;
    text.closest("details")?.setAttribute("open", "");
  }
  form.querySelector("[aria-invalid]")?.focus();
}

function invariances({ bending, topology, scale }) {
  const words = { yes: "yes", approx: "approximately", no: "no" };
  return `Invariant to bending: ${words[bending]}; to topology: ${words[topology]}; to scale: ${words[scale]}.`;
}
