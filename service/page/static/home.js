// Where one begins: shapes come in, are chosen, and are matched or compared.

import { get } from "./api.js";
import { h, fill, button } from "./dom.js";
import { exampleButtons } from "./examples.js";
import { jobList, prototypeList, shapeList } from "./lists.js";
import { isPrototype, orderForm } from "./order.js";
import { problemBox } from "./problem.js";
import { dropZone } from "./uploads.js";
import { count } from "./words.js";

/** @param {Array<string>} ids shapes that are chosen already, as the address says */
export async function homeView(place, ids, signal) {
  const chosen = [];
  let forms = new AbortController();
  signal.addEventListener("abort", () => forms.abort());
  const selected = h("section", { "aria-labelledby": "chosen-title", class: "card", hidden: true });
  const lists = h("div", { class: "columns" });

  const choose = (...shapes) => {
    for (const shape of shapes) {
      // There is one prototype at most, which is the source.
      if (isPrototype(shape)) chosen.splice(0, isPrototype(chosen[0]) ? 1 : 0, shape);
      else if (!chosen.some((other) => other.id === shape.id)) chosen.push(shape);
    }
    show();
  };
  const show = () => {
    const hash = chosen.length ? `#/with/${chosen.map((shape) => shape.id).join("/")}` : "#/";
    history.replaceState(null, "", hash);
    forms.abort();
    forms = new AbortController();
    showChosen(selected, chosen, show, forms.signal);
  };
  const listShapes = async () => fill(shapes, await shapeList(choose, signal));
  const uploads = dropZone(async (shape) => {
    choose(shape);
    await listShapes();
  }, signal);

  fill(place,
    h("p", { class: "lead" },
      "Drop two meshes: which point of the one corresponds to which of the other, how well, and how"
      + " different are the two? Drop more, and all are compared with all."),
    uploads.node,
    h("p", { class: "actions" }, "No meshes at hand? ", exampleButtons(uploads.take)),
    selected, lists);
  const shapes = h("section", { class: "card" });
  const jobs = h("section", { class: "card" });
  const prototypes = h("section", { class: "card", hidden: true });
  fill(lists, jobs, shapes, prototypes);

  const records = await Promise.all(ids.map((id) =>
    get(`/v1/${id.startsWith("p-") ? "prototypes" : "shapes"}/${encodeURIComponent(id)}`, signal).catch((error) => {
      selected.before(problemBox(error));
      return null;
    })));
  choose(...records.filter((record) => record?.name));
  await Promise.all([listShapes(), jobList(signal).then((list) => fill(jobs, list)),
    prototypeList(choose, signal).then((list) => {
      prototypes.hidden = list.length === 0;
      fill(prototypes, list);
    })]);
}

function showChosen(node, chosen, changed, signal) {
  node.hidden = chosen.length === 0;
  if (chosen.length === 0) return;
  const swap = () => {
    chosen.reverse();
    changed();
  };
  fill(node,
    h("h2", { id: "chosen-title" }, "Chosen shapes"),
    h("ol", { class: "chips" }, chosen.map((shape, at) => chip(shape, at, chosen, changed))),
    chosen.length === 2 && !isPrototype(chosen[0]) ? button("Exchange source and target", swap) : null,
    chosen.length > 1 ? orderForm(chosen, signal) : h("p", { class: "faint" }, "Choose another one."));
}

function chip(shape, at, chosen, changed) {
  const role = chosen.length > 2 ? null : h("span", { class: "faint" }, ["source ", "target "][at]);
  const drop = button("Remove", () => {
    chosen.splice(at, 1);
    changed();
  }, { "aria-label": `Remove ${shape.name}`, class: "small" });
  return h("li", {}, role,
    isPrototype(shape) ? h("a", { href: `#/prototypes/${shape.id}` }, `${shape.name}, version ${shape.version}`)
      : h("a", { href: `#/shapes/${shape.id}` }, shape.name),
    h("span", { class: "faint" }, isPrototype(shape) ? " prototype " : ` ${count(shape.vertices)} vertices `),
    drop);
}
