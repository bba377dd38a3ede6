// The mean shape of a registration, which sliders move along its principal components.

import { button } from "./actions.js";
import { PATIENCE_FOR_FILES, request } from "./api.js";
import { h, fill } from "./dom.js";
import { percent } from "./format.js";
import { openNpz } from "./npz.js";
import { canDraw } from "./plotly.js";
import { Scene, extent } from "./scene.js";
import { shareDrawn } from "./shape.js";
import { simplified } from "./vertex_clustering.js";
import { UPRIGHT, centred, rotated } from "./view.js";

/** Components with sliders, and their ends in standard deviations, as in the service's picture. */
const SLIDERS = 3;
const ENDS = 2;
/** Size of the mean in its drawing: what is moved farther is drawn smaller. */
const LEAST_SIZE = 0.8;
/** Most vertices of all registered templates that are fetched to be drawn: each has 48 bytes. */
const MOST_FETCHED = 1_000_000;

/**
 * Draw the mean shape with its sliders; the service's picture where the browser cannot.
 * @returns {Promise<function(number, string)|null>} shows one of the registered specimens, with its name; or null
 */
export async function componentView(place, result, job, signal) {
  const count = result.specimens.filter((one) => one.registered).length;
  fill(place, h("p", { class: "faint" }, "Loading the mean shape."));
  if (!canDraw() || result.vertices * count > MOST_FETCHED) {
    await showPicture(place, job, signal);
    return null;
  }
  const shape = await fetched(job, result.view ?? UPRIGHT, signal);
  if (signal.aborted) return null;
  return drawn(place, shape, result, signal);
}

async function showPicture(place, job, signal) {
  const address = URL.createObjectURL(await (await request(job.links.picture, { signal, patience: PATIENCE_FOR_FILES })).blob());
  signal.addEventListener("abort", () => URL.revokeObjectURL(address));
  fill(place, h("img", { src: address, class: "picture", alt: "The mean shape, and it moved along its principal components" }));
}

// The mean, and what one standard deviation of each component adds to it, in the coordinates of the view.
async function fetched(job, rows, signal) {
  const array = openNpz(await (await request(job.links.arrays, { signal })).arrayBuffer());
  const [mean, faces, components, variances, scores] = await Promise.all(
    ["mean", "faces", "components", "variances", "scores"].map(array));
  const size = extent(mean.data) || 1;
  const whole = mean.data.map((value) => value / size);
  const mesh = simplified({ positions: whole, faces: Uint32Array.from(faces.data), colors: null });
  const deviations = Array.from(variances.data, (variance) => Math.sqrt(Math.max(0, variance)));
  const steps = deviations.map((deviation, c) => rotated(rows, mesh.reduced(
    components.data.subarray(whole.length * c, whole.length * (c + 1)).map((value) => (deviation * value) / size))));
  const specimens = Array.from({ length: scores.shape[0] }, (_, m) => deviations.map((deviation, c) =>
    (deviation > 0 ? scores.data[m * deviations.length + c] / deviation : 0)));
  return { mean: centred(rotated(rows, mesh.positions)), faces: mesh.faces, share: mesh.share, steps, specimens };
}

const moved = ({ mean, steps }, scores) => steps.reduce((sum, step, c) =>
  (scores[c] === 0 ? sum : sum.map((value, at) => value + scores[c] * step[at])), mean);

async function drawn(place, shape, result, signal) {
  const node = h("div", { class: "scene", "aria-label": "The mean shape in three dimensions" });
  const caption = h("figcaption", { "aria-live": "polite" });
  const none = shape.steps.map(() => 0);
  const ends = shape.steps.slice(0, SLIDERS).flatMap((_, c) => [-ENDS, ENDS].map((end) => extent(moved(shape, none.with(c, end)))));
  const reach = Math.min(Math.max(0, ...ends), extent(shape.mean) / LEAST_SIZE);
  const scene = new Scene(node, { positions: shape.mean, faces: shape.faces }, signal, { reach });
  let scores = none;
  let drawing = null;
  // Sliders move faster than shapes are drawn: at most one drawing waits, that of the last scores.
  const draw = () => {
    drawing ??= new Promise((resolve) => requestAnimationFrame(resolve)).then(() => {
      drawing = null;
      return scene.reshape(moved(shape, scores));
    });
    return drawing;
  };
  const take = (given, said) => {
    scores = given;
    caption.textContent = said;
    sliders.forEach(({ update }) => update(scores));
    return draw();
  };
  const sliders = result.components.slice(0, SLIDERS).map(({ explained }, c) => slider(c, explained, (score) => {
    const next = scores.with(c, score);
    take(next, next.every((one) => one === 0) ? "Mean shape" : "Mean shape, moved along its components");
  }));
  const mean = () => take(none, "Mean shape");
  fill(place, h("div", { class: "pair" }, h("figure", {}, node, caption,
    h("p", { class: "faint" }, shareDrawn(shape.share, result.faces))),
    sliders.length === 0 ? null : h("div", {}, h("h3", {}, "Principal components"), sliders.map((one) => one.node),
      button("Mean shape", mean))));
  await mean();
  place.dataset.drawn = String(shape.mean.length / 3);
  return async (specimen, name) => {
    await take(shape.specimens[specimen], `${name}, moved onto the mean`);
    node.scrollIntoView({ block: "nearest" });
  };
}

function slider(c, explained, changed) {
  const id = `component-${c + 1}`;
  const said = h("output", { for: id, "aria-live": "off" });
  const input = h("input", {
    id, type: "range", min: -ENDS, max: ENDS, step: 0.1, value: 0,
    oninput: () => changed(Number(input.value)),
  });
  const update = (scores) => {
    // Specimens may be farther from the mean than the slider's ends.
    input.value = scores[c];
    const size = Math.abs(scores[c]).toFixed(1);
    const sign = Number(size) === 0 ? "" : scores[c] > 0 ? "+" : "−";
    said.textContent = `${sign}${size} s.d.`;
    input.setAttribute("aria-valuetext", said.textContent);
  };
  const node = h("div", { class: "slider" },
    h("label", { for: id }, `Component ${c + 1}, ${percent(explained)} of the variance`), said, input);
  return { node, update };
}
