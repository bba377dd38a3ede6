// The start page: upload and choose shapes, and what is done with them.

import { button } from "./actions.js";
import { get, shapeRecord } from "./api.js";
import { h, fill, scrolled } from "./dom.js";
import { exampleButtons } from "./examples.js";
import { keepFocus } from "./focus.js";
import { markChosen, prototypeList, recentJobs, shapeList } from "./lists.js";
import { isPrototype, jobForm } from "./job_form.js";
import { problemBox } from "./problem.js";
import { dropZone } from "./uploads.js";
import { count } from "./format.js";

/** Chosen shapes up to which their number is seen at once. */
const MOST_UNCOUNTED = 4;

/**
 * @param {Array<string>} ids ids in the address, of shapes that are chosen already
 * @param {string|null} task name of the task that is chosen already, if the shapes allow it
 */
export async function homeView(place, ids, signal, task = null) {
  const chosen = [];
  const last = { task };
  const uploading = { files: 0, changed: () => {} };
  let forms = new AbortController();
  signal.addEventListener("abort", () => forms.abort());
  const selected = h("section", { "aria-labelledby": "chosen-title", class: "card", hidden: true });
  const told = h("p", { class: "visually-hidden", role: "status" });
  const lists = h("div", { class: "columns" });
  // Leads to the form, which may be far above the lists.
  const number = h("span");
  const bar = h("p", { class: "chosen-bar", hidden: true }, number, " ", button("To the form", () => {
    selected.scrollIntoView();
    selected.querySelector("input, a").focus({ preventScroll: true });
  }, { class: "small" }));
  const sight = new IntersectionObserver(([{ isIntersecting: seen }]) => { bar.hidden = seen || chosen.length === 0; });
  sight.observe(selected);
  signal.addEventListener("abort", () => sight.disconnect());

  const choose = (...shapes) => {
    // Shapes that arrive once the page was left are not chosen.
    if (signal.aborted) return;
    for (const shape of shapes) {
      // At most one prototype can be chosen, as the source.
      if (isPrototype(shape)) chosen.splice(0, isPrototype(chosen[0]) ? 1 : 0, shape);
      else if (!chosen.some((other) => other.id === shape.id)) chosen.push(shape);
    }
    show();
  };
  const remove = (id) => {
    chosen.splice(chosen.findIndex((shape) => shape.id === id), 1);
    show();
  };
  const choice = {
    toggle: (item) => (chosen.some(({ id }) => id === item.id) ? remove(item.id) : choose(item)),
    mark: (items) => markChosen(items, chosen.map(({ id }) => id)),
  };
  const show = () => {
    const hash = chosen.length ? `#/with/${chosen.map((shape) => shape.id).join("/")}` : "#/";
    history.replaceState(null, "", hash);
    forms.abort();
    forms = new AbortController();
    told.textContent = sentence(chosen);
    showChosen(selected, chosen, last, uploading, show, forms.signal);
    choice.mark(lists);
    number.textContent = `${count(chosen.length)} chosen`;
  };
  const listShapes = async () => fill(shapes, await shapeList(choice, signal));
  // The list stays while the service is away, and is listed again when the user comes back to the page.
  let stale = false;
  const listAgain = async () => {
    try {
      await listShapes();
      stale = false;
    } catch (error) {
      stale = true;
      if (!signal.aborted && shapes.querySelector("ul") === null) fill(shapes, problemBox(error));
    }
  };
  const again = () => !document.hidden && stale && listAgain();
  window.addEventListener("focus", again, { signal });
  document.addEventListener("visibilitychange", again, { signal });
  const uploads = dropZone(choose, listAgain, (files) => {
    uploading.files = files;
    uploading.changed();
  }, signal);

  fill(place,
    h("p", { class: "lead" },
      "Drop two meshes to match them: find the correspondence of minimum distortion, and a bound on how"
      + " far it is from the optimum. Drop more to compare all pairs, to map all to one another, to match one with all"
      + " others, to register it to them as a template, or to carry its landmarks to them."),
    uploads.node,
    h("p", { class: "actions" }, "Examples: ", exampleButtons(uploads.take)),
    told, selected, lists, bar);
  const shapes = h("section", { class: "card" });
  const jobs = h("section", { class: "card" });
  const prototypes = h("section", { class: "card", hidden: true });
  fill(lists, jobs, shapes, prototypes);

  const chooseFirst = async () => {
    const awaited = h("p", { class: "faint", role: "status" });
    selected.before(awaited);
    const waiting = () => { awaited.textContent = "Waiting for a shape that is being validated."; };
    const records = await Promise.all(ids.map((id) => recordOf(id, signal, waiting).catch((error) => {
      selected.before(problemBox(error));
      return null;
    })));
    if (signal.aborted) return;
    awaited.remove();
    choose(...records.filter((record) => record !== null));
    uploads.begin();
  };
  await Promise.all([chooseFirst(), listShapes(), recentJobs(jobs, signal),
    prototypeList(choice, signal).then((list) => {
      prototypes.hidden = list.length === 0;
      fill(prototypes, list);
    })]);
}

const recordOf = (id, signal, waiting) => (id.startsWith("p-")
  ? get(`/v1/prototypes/${encodeURIComponent(id)}`, signal) : shapeRecord(id, signal, waiting));

// For who does not see the list.
const sentence = (chosen) => (chosen.length > MOST_UNCOUNTED ? `${chosen.length} shapes are chosen.`
  : chosen.length > 0 ? `Chosen: ${chosen.map((shape) => shape.name).join(", ")}.` : "");

function showChosen(node, chosen, last, uploading, changed, signal) {
  keepFocus(node, () => { node.hidden = chosen.length === 0; });
  if (chosen.length === 0) return;
  const swap = () => {
    chosen.reverse();
    changed();
  };
  fill(node,
    h("h2", { id: "chosen-title" }, chosen.length > MOST_UNCOUNTED ? `${chosen.length} chosen shapes` : "Chosen shapes"),
    h("ol", scrolled("chips", chosen.length, "Chosen shapes"), chosen.map((shape, at) => chip(shape, at, chosen, changed))),
    chosen.length === 2 && !isPrototype(chosen[0]) ? button("Swap source and target", swap) : null,
    chosen.length > 1 ? jobForm(chosen, last, uploading, signal) : h("p", { class: "faint" }, "Choose another shape."));
}

function chip(shape, at, chosen, changed) {
  const roles = chosen.length > 2 ? ["first "] : ["source ", "target "];
  const role = at < roles.length ? h("span", { class: "faint" }, roles[at]) : null;
  const first = chosen.length <= 2 || at === 0 || isPrototype(chosen[0]) ? null : button("Put first", () => {
    chosen.unshift(...chosen.splice(at, 1));
    changed();
    document.querySelector(".chips a").focus();
  }, { "aria-label": `Put ${shape.name} first`, class: "small" });
  const drop = button("Remove", () => {
    chosen.splice(at, 1);
    changed();
  }, { "aria-label": `Remove ${shape.name}`, class: "small" });
  return h("li", {}, role,
    isPrototype(shape) ? h("a", { href: `#/prototypes/${shape.id}` }, `${shape.name}, version ${shape.version}`)
      : h("a", { href: `#/shapes/${shape.id}` }, shape.name),
    h("span", { class: "faint" }, isPrototype(shape) ? " prototype " : ` ${count(shape.vertices)} vertices `),
    first, " ", drop);
}
