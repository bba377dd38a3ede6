// A shape: its record, its drawing and its jobs.

import { shapeRecord } from "./api.js";
import { deleteButton } from "./deletion.js";
import { h, fill, warningList } from "./dom.js";
import { download } from "./download.js";
import { count, digits, percent, time } from "./format.js";
import { geometryOf } from "./geometry.js";
import { jobList } from "./lists.js";
import { NO_WEBGL, canDraw } from "./plotly.js";
import { Scene } from "./scene.js";
import { simplified } from "./vertex_clustering.js";
import { rotated } from "./view.js";

export async function shapeView(place, [id], signal) {
  const path = `/v1/shapes/${encodeURIComponent(id)}`;
  const shape = await shapeRecord(id, signal);
  document.title = `${shape.name} – isomatch`;
  const picture = h("div", { class: "scene", "aria-label": `${shape.name} in three dimensions` });
  const drawn = h("p", { class: "faint" });
  const jobs = h("section", {});
  const forget = deleteButton(path, shape.name,
    "Results of its jobs stay, but it can no longer be matched or drawn. The file must be uploaded again.", signal);
  fill(place,
    h("h2", {}, shape.name),
    h("p", {}, `${count(shape.vertices)} ${shape.kind === "points" ? "points" : "vertices"}, `
      + `${count(shape.faces)} triangles${shape.kind === "points" ? " made of them" : ""}, `
      + `${shape.components === 1 ? "one component" : `${shape.components} components`}, `
      + `${shape.closed ? "closed" : "with boundary"}, area ${digits(shape.area)}, `
      + `uploaded ${time(shape.created)}.`),
    warningList(shape.warnings),
    h("p", { class: "actions" },
      h("a", { href: `#/with/${shape.id}`, class: "button" }, "Match it"), " ",
      download(`${path}/mesh`, "Mesh file", `${shape.id}.${shape.file_type}`), " ", forget),
    picture, drawn, jobs);
  jobList(signal, id).then((list) => fill(jobs, list), () => {});
  if (!canDraw()) {
    picture.remove();
    drawn.textContent = NO_WEBGL;
    return;
  }
  const mesh = simplified(await geometryOf(id, signal));
  drawn.textContent = shareDrawn(mesh.share, shape.faces);
  const positions = rotated(shape.view, mesh.positions);
  const scene = new Scene(picture, { positions, faces: mesh.faces }, signal);
  await scene.show(mesh.colors);
}

/** A note on a mesh that is simplified for drawing; empty if it is not. */
export const shareDrawn = (share, faces) => (share === 1 ? ""
  : `Drawn with ${percent(share)} of its ${count(faces)} triangles; only the drawing is simplified.`);
