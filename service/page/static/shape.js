// One shape: what is known of it, and how it looks.

import { get, remove } from "./api.js";
import { coarsened } from "./coarsen.js";
import { h, fill, button } from "./dom.js";
import { download } from "./download.js";
import { geometryOf } from "./geometry.js";
import { jobList } from "./lists.js";
import { canDraw } from "./plotly.js";
import { Scene } from "./scene.js";
import { seen, stance } from "./stance.js";
import { count, digits, percent, time } from "./words.js";

export async function shapeView(place, [id], signal) {
  const path = `/v1/shapes/${encodeURIComponent(id)}`;
  const shape = await get(path, signal);
  document.title = `${shape.name} – isomatch`;
  const picture = h("div", { class: "scene", role: "img", "aria-label": `${shape.name} in three dimensions` });
  const drawn = h("p", { class: "faint" });
  const jobs = h("section", {});
  const forget = button("Delete", async () => {
    await remove(path);
    location.hash = "#/";
  });
  fill(place,
    h("h2", {}, shape.name),
    h("p", {}, `${count(shape.vertices)} vertices, ${count(shape.faces)} triangles, `
      + `${shape.components === 1 ? "one component" : `${shape.components} components`}, `
      + `${shape.closed ? "closed" : "with boundary"}, area ${digits(shape.area)}, `
      + `uploaded ${time(shape.created)}.`),
    shape.warnings.length ? h("ul", { class: "warnings" }, shape.warnings.map((text) => h("li", {}, text))) : null,
    h("p", { class: "actions" },
      h("a", { href: `#/with/${shape.id}`, class: "button" }, "Match it"), " ",
      download(`${path}/mesh`, "The file", `${shape.id}.${shape.file_type}`), " ", forget),
    picture, drawn, jobs);
  jobList(signal, id).then((list) => fill(jobs, list), () => {});
  if (!canDraw()) {
    drawn.textContent = "This browser has no WebGL, which shapes are drawn with.";
    return;
  }
  const geometry = await geometryOf(id, signal);
  const mesh = coarsened(geometry);
  drawn.textContent = shareDrawn(mesh.share, shape.faces);
  const positions = seen(stance(mesh.positions), mesh.positions);
  const scene = new Scene(picture, { positions, faces: mesh.faces }, signal);
  await scene.show(mesh.colors);
}

/** What is said of a mesh of which not all is drawn. */
export const shareDrawn = (share, faces) => (share === 1 ? ""
  : `Drawn coarsely, with ${percent(share)} of its ${count(faces)} triangles; nothing else is simplified by that.`);
