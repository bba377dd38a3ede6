// Fields of a form, each with its label and what must be known of it.

import { h } from "./dom.js";

function labelled(name, label, field, about) {
  const hint = h("p", { id: `about-${name}`, class: "faint" }, about);
  field.id = `field-${name}`;
  field.setAttribute("aria-describedby", `about-${name} error-${name}`);
  return h("div", { class: "field" }, h("label", { for: field.id }, label), field, hint,
    h("p", { id: `error-${name}`, class: "error", hidden: true }));
}

export const numberField = (name, label, value, min, max, about) =>
  labelled(name, label, h("input", { name, type: "number", value, min, max, step: 1 }),
    `${about} From ${min} to ${max}.`);

export const textField = (name, label, value, about) =>
  labelled(name, label, h("input", { name, type: "text", value, maxlength: 200 }), about);

/** @param {Array<Array<string>>} options values, each with what is said of it */
export const choiceField = (name, label, options, chosen, about) =>
  labelled(name, label, h("select", { name }, options.map(([value, text], at) =>
    h("option", { value, selected: at === chosen }, text))), about);

export function structureField(name, label, structures, recommended, shapes) {
  const colored = shapes.every((shape) => shape.has_colors);
  const field = h("select", { name },
    h("option", { value: "" }, recommended),
    structures.map((structure) => h("option", {
      value: structure.name, disabled: structure.needs_colors && !colored,
    }, structure.name.replaceAll("_", " "), structure.needs_colors ? " (needs vertex colours)" : "")));
  const box = labelled(name, label, field, "What is compared. The recommended ones suit most shapes.");
  field.addEventListener("change", () => {
    const found = structures.find((structure) => structure.name === field.value);
    box.querySelector(`#about-${name}`).textContent = found
      ? `${found.description} ${invariances(found.invariance)}`
      : "What is compared. The recommended ones suit most shapes.";
  });
  return box;
}

export function checkbox(name, value, label, checked) {
  const json = typeof value !== "string" || name === "labels";
  return h("label", { class: "check" },
    h("input", { type: "checkbox", name, value: String(value), checked, "data-json": json }), " ", label);
}

/** Mark the fields that were refused, each with the reason. */
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
}

function invariances({ bending, topology, scale }) {
  const words = { yes: "yes", approx: "approximately", no: "no" };
  return `Invariant to bending: ${words[bending]}; to topology: ${words[topology]}; to scale: ${words[scale]}.`;
}
