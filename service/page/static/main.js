// Routing: the part of the address after # names the view.

import { button } from "./actions.js";
import { fill, h } from "./dom.js";
import { Problem } from "./api.js";
import { askForKey } from "./api_key.js";
import { problemBox } from "./problem.js";
import { homeView } from "./home.js";
import { jobView } from "./job.js";
import { landmarkView } from "./landmark_view.js";
import { prototypeView } from "./prototype.js";
import { shapeView } from "./shape.js";
import { mayLeave, takeDroppedAnywhere } from "./uploads.js";

const main = document.getElementById("main");
let leaving = new AbortController();
let navigations = 0;

const ROUTES = {
  jobs: jobView, landmarks: landmarkView, shapes: shapeView, prototypes: prototypeView, with: homeView, "": homeView,
  task: (place, [task, ...ids], signal) => homeView(place, ids, signal, task),
};

async function show(event) {
  const wanted = location.href;
  const own = ++navigations;
  if (!(await mayLeave())) {
    // Shapes that have arrived meanwhile are in the address already.
    if (event && location.href === wanted) history.replaceState(null, "", event.oldURL);
    return;
  }
  if (own !== navigations) return;
  if (location.href !== wanted) history.replaceState(null, "", wanted);
  leaving.abort();
  leaving = new AbortController();
  const { signal } = leaving;
  // "#job=" is the form of shared links.
  const [name, ...rest] = location.hash.replace(/^#job=/, "#/jobs/").replace(/^#\/?/, "").split("/").map(decoded);
  const view = ROUTES[name] ?? nowhere;
  const awaited = h("p", { class: "faint awaited" }, "Loading…");
  const place = h("div", { class: "view" }, awaited);
  fill(main, place);
  document.title = "isomatch";
  try {
    await view(place, rest.filter(Boolean), signal);
  } catch (error) {
    if (signal.aborted) return;
    awaited.remove();
    if (document.title === "isomatch" && error.title) document.title = `${error.title} – isomatch`;
    place.append(problemBox(error), error.passing ? h("p", {}, button("Try again", () => show())) : "");
  }
}

function decoded(part) {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}

function nowhere(place) {
  fill(place, h("p", {}, "This address does not exist. ", h("a", { href: "#/" }, "Start page")));
}

document.getElementById("key").addEventListener("click", async () => {
  const given = await askForKey("A service that is configured with API keys needs one with every request.");
  if (given) show();
});
document.querySelector(".skip").addEventListener("click", (event) => {
  event.preventDefault();
  main.focus();
});
// Screen readers tell where a link has led.
new MutationObserver(() => {
  document.getElementById("title").textContent = document.title;
}).observe(document.querySelector("title"), { childList: true });
// Problems of what nobody waits for; that of a view that was left is none.
window.addEventListener("unhandledrejection", (event) => {
  const { reason } = event;
  if (reason instanceof Problem || reason?.name === "AbortError") event.preventDefault();
  if (reason?.name === "AbortError" || !(reason instanceof Error)) return;
  main.querySelector(":scope > .problem")?.remove();
  main.prepend(problemBox(reason));
});
takeDroppedAnywhere();
window.addEventListener("hashchange", show);
show();
