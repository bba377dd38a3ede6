// Lists of the newest jobs, shapes and prototypes.

import { button } from "./actions.js";
import { get } from "./api.js";
import { h, fill } from "./dom.js";
import { keepFocus } from "./focus.js";
import { completed } from "./names.js";
import { ago, count, kindName, stateName, time } from "./format.js";

const PAGE = 8;
const MOST_NAMED = 3;
/** Lines that are kept up to date: jobs that the service lists at once. */
const MOST_REFRESHED = 200;

/** Milliseconds until unfinished jobs are requested again. */
const AGAIN = 4000;

/** The newest jobs, of all or of one shape or prototype, with the names of their shapes. */
export const jobList = (signal, of = null) =>
  list(of === null ? "Recent jobs" : `Jobs of this ${of.startsWith("p-") ? "prototype" : "shape"}`, of === null ? "/v1/jobs" : `/v1/jobs?shape=${of}`,
    of === null ? "No job yet." : null, (job) => jobLine(job, signal), signal);

function jobLine(job, signal) {
  // Jobs of the same shapes have the same title: who is told of the link alone is told when it was requested.
  const about = `about-${job.id}`;
  const link = h("a", { href: `#/jobs/${job.id}`, "aria-describedby": about }, kindName(job));
  titleOf(job, signal).then((title) => fill(link, title)).catch(() => {});
  const changed = changedParameters(job);
  return h("li", { "data-job": job.id }, link, " ", h("span", { id: about },
    changed === "" ? null : h("span", { class: "faint" }, `${changed} `), h("span", { class: "now" }, stateOf(job))));
}

const stateOf = (job) => [
  h("span", { class: `state ${job.state}` }, stateName(job.state)), " ",
  h("time", { datetime: job.created, title: time(job.created), class: "faint" }, ago(job.created)),
];

/** Show the newest jobs, and again while one has not ended, and when the user comes back to the page. */
export async function recentJobs(place, signal) {
  fill(place, await jobList(signal));
  const refresh = async () => {
    const known = place.querySelector("ul");
    if (known === null) {
      fill(place, await jobList(signal));
      return;
    }
    const shown = Math.min(Math.max(known.childElementCount, PAGE), MOST_REFRESHED);
    const { items } = await get(`/v1/jobs?limit=${shown}`, signal);
    // Lines stay where they are, and with them the focus.
    for (const job of items.reverse()) {
      const line = known.querySelector(`[data-job="${job.id}"]`);
      if (line === null) known.prepend(jobLine(job, signal));
      else fill(line.querySelector(".now"), stateOf(job));
    }
  };
  const again = () => document.hidden || refresh().catch(() => {});
  const timer = setInterval(() => place.querySelector(".state:is(.queued, .running)") && again(), AGAIN);
  signal.addEventListener("abort", () => clearInterval(timer));
  window.addEventListener("focus", again, { signal });
  document.addEventListener("visibilitychange", again, { signal });
}

// "dense, points 64": what tells jobs of the same shapes apart.
const changedParameters = ({ parameters: { what, ...others } }) => Object.entries(others).map(([name, value]) =>
  (value === true ? name : value === false ? `no ${name}` : `${name} ${value}`).replaceAll("_", " ")).join(", ");

// Kind of a job and names of its shapes, those of the request first; only the newest page of others is searched.
export async function titleOf(job, signal) {
  const kind = kindName(job);
  if (job.name !== null) return `${kind}: ${job.name}`;
  const ids = job.kind === "match" ? [job.source, job.target] : job.shapes.slice(0, MOST_NAMED);
  // Shapes are listed once each, and prototypes are named with their version.
  const given = job.prototype === null && (job.kind === "match" || job.names.length === job.shapes.length) ? job.names : [];
  const names = await completed(given, ids, signal, 1);
  if (names.length === 0) return kind;
  const more = job.kind === "match" ? 0 : job.shape_count - names.length;
  return `${kind}: ${names.join(job.kind === "match" ? " and " : ", ")}${more > 0 ? ` and ${count(more)} more` : ""}`;
}

// A button that chooses; pressed again, no longer.
const chooseButton = (item, choice) => h("button", {
  type: "button", class: "small choose", "data-id": item.id, "data-name": item.name, onclick: () => choice.toggle(item),
});

/** Show on the buttons of lists which shapes and prototypes are chosen. */
export function markChosen(lists, ids) {
  for (const node of lists.querySelectorAll(".choose")) {
    const chosen = ids.includes(node.dataset.id);
    node.textContent = chosen ? "Chosen" : "Choose";
    node.setAttribute("aria-pressed", String(chosen));
    node.setAttribute("aria-label", `${node.textContent} ${node.dataset.name}`);
  }
}

/** @param {Object} choice `toggle`, called with the prototype whose button is pressed, and `mark`, with new lines */
export const prototypeList = (choice, signal) =>
  list("Prototypes", "/v1/prototypes", null, (prototype) => h("li", {},
    h("a", { href: `#/prototypes/${prototype.id}` }, `${prototype.name}, version ${prototype.version}`), " ",
    h("span", { class: "faint" }, `${prototype.points} points `),
    chooseButton(prototype, choice)),
  signal, choice.mark);

/** @param {Object} choice as of `prototypeList` */
export const shapeList = (choice, signal) =>
  list("Shapes", "/v1/shapes", "No shape yet.", (shape) => h("li", {},
    h("a", { href: `#/shapes/${shape.id}` }, shape.name), " ",
    h("span", { class: "faint" }, `${count(shape.vertices)} vertices `),
    chooseButton(shape, choice)),
  signal, choice.mark);

async function list(title, path, none, line, signal, mark = () => {}) {
  const items = h("ul", { class: "list" });
  const more = button("More", () => add());
  let cursor = null;
  const add = async () => {
    const query = new URLSearchParams({ limit: PAGE, ...(cursor ? { cursor } : {}) });
    const page = await get(`${path}${path.includes("?") ? "&" : "?"}${query}`, signal);
    cursor = page.next_cursor;
    // The last time, the focus goes to the first line that is added.
    keepFocus(more.parentElement ?? items, () => {
      items.append(...page.items.map(line));
      more.hidden = cursor === null;
    });
    mark(items);
  };
  await add();
  const empty = items.childElementCount === 0;
  if (empty && none === null) return [];
  return [h("h2", {}, title), empty ? h("p", { class: "faint" }, none) : items, more];
}
