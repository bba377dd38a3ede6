// The form that requests a job for the chosen shapes.

import { button } from "./actions.js";
import { get, post } from "./api.js";
import { h, fill } from "./dom.js";
import { keepEntries, resetEntries, restoreEntries } from "./entries.js";
import { showErrors } from "./fields.js";
import { isOff, occupied, turnOff } from "./focus.js";
import { count } from "./format.js";
import { fieldName, problemBox, withNames } from "./problem.js";
import { TASKS, fieldsOf, tasksFor } from "./tasks.js";
import { stillUploading } from "./uploads.js";

/** The metrics and descriptors of the service, requested once. */
let structures = null;

export const isPrototype = (chosen) => Boolean(chosen?.examples);

/**
 * A form for one of the tasks that the chosen shapes allow.
 * @param {Object} last `task`, the name of the task that was chosen last; kept up to date
 * @param {Object} uploading `files`, how many are still uploading; the form, which waits for them, takes `changed`
 */
export function jobForm(shapes, last, uploading, signal) {
  const learned = isPrototype(shapes[0]);
  const parts = h("div", { class: "fields" });
  const said = h("div", { "aria-live": "polite" });
  const submit = h("button", { type: "submit", class: "primary" });
  const awaited = h("span", { class: "faint", role: "status" });
  const form = h("form", { novalidate: true, "aria-label": "Task" });
  let task;
  let complete = false;
  // A job that is requested now would lack the files that still come.
  const allow = () => {
    awaited.textContent = uploading.files > 0 ? stillUploading(uploading.files) : "";
    turnOff(submit, !complete || uploading.files > 0);
  };
  uploading.changed = allow;
  const take = async (name) => {
    const taken = TASKS[name];
    last.task = name;
    task = taken;
    submit.textContent = task.title;
    complete = false;
    allow();
    fill(parts, h("p", { class: "faint" }, "Loading the metrics and descriptors."));
    try {
      structures ??= get("/v1/structures");
      const known = await structures;
      if (task !== taken || signal.aborted) return;
      fill(parts, fieldsOf(task, known, shapes, signal));
      restoreEntries(name, form);
      complete = true;
      allow();
    } catch (error) {
      structures = null;
      if (!signal.aborted) fill(parts, problemBox(error), button("Try again", () => take(last.task)));
    }
  };
  form.addEventListener("change", () => keepEntries(last.task, form));
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    if (isOff(submit)) return;
    fill(said);
    const wrong = unusable(form);
    if (wrong.length > 0) {
      showErrors(form, wrong, fieldName);
      return;
    }
    await occupied(submit, async () => {
      const named = task.named(shapes);
      try {
        const job = await post(task.path, { ...named, ...values(form) });
        if (!signal.aborted) location.hash = `#/${task.view ?? "jobs"}/${job.id}`;
      } catch (error) {
        fill(said, problemBox(withNames(error, namesIn(named, shapes))));
        showErrors(form, error.errors ?? [], fieldName);
      }
    });
  });
  const defaults = button("Defaults", () => {
    resetEntries(form);
    keepEntries(last.task, form);
    showErrors(form, [], fieldName);
  });
  const names = tasksFor(shapes.length, learned);
  const allowed = names.filter((name) => !isOver(name, shapes));
  const first = allowed.includes(last.task) ? last.task : allowed[0] ?? names[0];
  fill(form, names.length > 1 ? choiceOf(names, first, shapes, take) : null, parts, said, h("p", { class: "actions" }, submit, defaults, awaited));
  take(first);
  return form;
}

// Names of the shapes that a request lists.
const namesIn = (request, shapes) => (request.shapes ?? request.targets ?? []).map((id) => shapes.find((shape) => shape.id === id).name);

const isOver = (name, shapes) => shapes.length > TASKS[name].most;

// The limit of a task, from half of it on.
const limitOf = ({ most }, shapes) => (2 * shapes.length > most ? h("span", { class: "faint" }, ` (at most ${count(most)} shapes)`) : null);

function choiceOf(names, first, shapes, take) {
  const option = (name) => h("label", {},
    h("input", {
      type: "radio", name: "task", value: name, checked: name === first, disabled: isOver(name, shapes), "data-form": true,
      onchange: () => take(name),
    }), " ", TASKS[name].about, limitOf(TASKS[name], shapes));
  return h("fieldset", {}, h("legend", {}, "Task"), names.map(option));
}

/** Errors of the fields that cannot be sent as they are. */
function unusable(form) {
  // The value of a number field that has no number is empty, as if it was left out.
  const wrongs = [...form.elements].map((field) => ({
    field: field.name, message: field.dataset.unfinished ?? (field.validity.badInput ? "Give a number." : null),
  }));
  return wrongs.filter(({ message }) => message !== null);
}

function values(form) {
  const chosen = [...form.elements].filter((field) =>
    field.name && field.dataset.form === undefined && field.value !== ""
    && (field.type !== "checkbox" || field.checked || field.dataset.switch !== undefined));
  return Object.fromEntries(chosen.map((field) => [field.name, valueOf(field)]));
}

function valueOf(field) {
  if (field.dataset.switch !== undefined) return field.checked;
  if (field.dataset.json !== undefined) return JSON.parse(field.value);
  return field.type === "number" ? Number(field.value) : field.value;
}
