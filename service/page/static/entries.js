// What was entered into the form of a task, kept in the tab for when one comes back to it.

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
  const entries = Object.fromEntries(changed.map((field) => [field.name, isBox(field) ? field.checked : field.value]));
  sessionStorage.setItem(nameOf(task), JSON.stringify(entries));
}

const usual = (select) => ([...select.options].find((option) => option.defaultSelected) ?? select.options[0])?.value;

/** Fill in what was kept. */
export function restoreEntries(task, form) {
  const entries = JSON.parse(sessionStorage.getItem(nameOf(task)) ?? "{}");
  for (const field of fieldsOf(form, entries)) {
    const value = entries[field.name];
    if (isBox(field)) field.checked = value;
    else if (field.tagName !== "SELECT" || [...field.options].some((option) => option.value === value && !option.disabled)) field.value = value;
    if (field.tagName === "SELECT") field.dispatchEvent(new Event("change"));
    field.closest("details")?.setAttribute("open", "");
  }
}
