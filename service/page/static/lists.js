// What there is already: the newest jobs and shapes.

import { get } from "./api.js";
import { h, button } from "./dom.js";
import { count, kindName, stateName, time } from "./words.js";

const PAGE = 8;

export const jobList = (signal) =>
  list("Recent jobs", "/v1/jobs", "No job yet.", (job) => h("li", {},
    h("a", { href: `#/jobs/${job.id}` }, kindName(job.kind)), " ",
    h("span", { class: `state ${job.state}` }, stateName(job.state)), " ",
    h("time", { datetime: job.created, class: "faint" }, time(job.created))), signal);

/** Prototypes that can be matched with a shape. */
export const prototypeList = (choose, signal) =>
  list("Prototypes", "/v1/prototypes", null, (prototype) => h("li", {},
    h("a", { href: `#/prototypes/${prototype.id}` }, `${prototype.name}, version ${prototype.version}`), " ",
    h("span", { class: "faint" }, `${prototype.points} points `),
    button("Choose", () => choose(prototype), { class: "small", "aria-label": `Choose ${prototype.name}` })),
  signal);

/** @param {function(Object)} choose told the shape that is chosen */
export const shapeList = (choose, signal) =>
  list("Shapes", "/v1/shapes", "No shape yet.", (shape) => h("li", {},
    h("a", { href: `#/shapes/${shape.id}` }, shape.name), " ",
    h("span", { class: "faint" }, `${count(shape.vertices)} vertices `),
    button("Choose", () => choose(shape), { class: "small", "aria-label": `Choose ${shape.name}` })),
  signal);

async function list(title, path, none, line, signal) {
  const items = h("ul", { class: "list" });
  const more = button("More", () => add());
  let cursor = null;
  const add = async () => {
    const query = new URLSearchParams({ limit: PAGE, ...(cursor ? { cursor } : {}) });
    const page = await get(`${path}?${query}`, signal);
    items.append(...page.items.map(line));
    cursor = page.next_cursor;
    more.hidden = cursor === null;
  };
  await add();
  const empty = items.childElementCount === 0;
  if (empty && none === null) return [];
  return [h("h2", {}, title), empty ? h("p", { class: "faint" }, none) : items, more];
}
