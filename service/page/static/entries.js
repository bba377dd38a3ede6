// Entries of the form of a task, kept in the tab for when the user comes back to it.

import { keep, kept } from "./tab_storage.js";

const nameOf = (task) => `isomatch-form-${task}`;

const fieldsOf = (form, names) => [...form.elements].filter((field) =>
  field.name && field.dataset.form === undefined && field.type !== "hidden" && field.type !== "file"
  && (names === null || field.name in names));

const isBox = (field) => field.type === "checkbox";

/** Keep what differs from the form as it is made. */
export function keepEntries(task, form) {
  const changed = fieldsOf(form, null).filter((field) => (isBox(field)
    ? field.checked !== field.defaultChecked
    : field.value !== (field.tagName === "SELECT" ? usual(field) : field.defaultValue)));
  store(task, Object.fromEntries(changed.map((field) => [field.name, isBox(field) ? field.checked : field.value])));
}

const store = (task, entries) => keep(nameOf(task), JSON.stringify(entries));

/**
 * Keep the parameters of a job, for the form of another; structures with parameters of their own have no field.
 * @param {Object} declared defaults of the parameters: see parameters.js
 */
export const keepParameters = (task, parameters, declared) =>
  store(task, Object.fromEntries(differing(parameters, declared).filter(([, value]) => typeof value !== "object")));

/** Names of the parameters that `keepParameters` leaves out. */
export const leftOut = (parameters, declared) =>
  differing(parameters, declared).filter(([, value]) => typeof value === "object").map(([name]) => name);

// The parameters that differ from their defaults.
const differing = (parameters, declared) => Object.entries(declared)
  .map(([name, { default: usual }]) => [name, single(parameters[name]), single(usual)])
  .filter(([, value, usual]) => value !== undefined && JSON.stringify(value) !== JSON.stringify(usual));

const single = (value) => (Array.isArray(value) && value.length === 1 ? value[0] : value);

const usual = (select) => ([...select.options].find((option) => option.defaultSelected) ?? select.options[0])?.value;

/** Fill in what was kept. */
export function restoreEntries(task, form) {
  const entries = JSON.parse(kept(nameOf(task)) ?? "{}");
  for (const field of fieldsOf(form, entries)) {
    const value = entries[field.name];
    if (isBox(field)) field.checked = value === true || String(value) === field.value;
    else if (field.tagName !== "SELECT" || [...field.options].some((option) => option.value === String(value) && !option.disabled)) field.value = value;
    if (field.tagName === "SELECT") field.dispatchEvent(new Event("change"));
    field.closest("details")?.setAttribute("open", "");
  }
}

/** Give all fields what they have in a form that nobody has changed. */
export function resetEntries(form) {
  for (const field of fieldsOf(form, null)) {
    if (isBox(field)) field.checked = field.defaultChecked;
    else field.value = field.tagName === "SELECT" ? usual(field) : field.defaultValue;
    if (field.tagName === "SELECT") field.dispatchEvent(new Event("change"));
  }
}
