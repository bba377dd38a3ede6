// A shape in three dimensions, with its matched points.

import { normals } from "./geometry.js";
import { colorOf, plotly } from "./plotly.js";
import { screenAxes } from "./camera.js";
import { css } from "./colors.js";
import { dragPoints } from "./dragging.js";

const FLAT = { lighting: { ambient: 1, diffuse: 0, specular: 0, roughness: 1, fresnel: 0 } };
const LIGHT = [-0.36, 0.56, 0.75];
const DARKEST = 0.55;
const SKIN = 218;
// The aspect ratio sizes the shape, as the projection is orthographic.
const ZOOM = { x: 1.75, y: 1.75, z: 1.75 };
const CONFIG = { displaylogo: false, responsive: true, displayModeBar: false, doubleClick: false };
/** Size of the points of a cloud, in pixels. */
const DOT = 2;
const SURFACE = 0;
const POINTS = 1;
const RING = 2;
/** Pixels that the pointer may move during a click. */
const STILL = 5;
/** Milliseconds until plotly.js has reported the vertex under a touch. */
const TOUCH = 150;
const NOTHING = { points: [], colors: [], names: [], numbered: false, ring: null };

/**
 * The drawing of a shape.
 *
 * `mesh` has `positions` and `faces`, and `cloud` if its points are drawn instead; nothing is drawn before the first `show`. With `picked`,
 * clicks on vertices are reported. `reach` is how far from the origin the shape may be moved.
 */
export class Scene {
  #node;
  #signal;
  #plotly = null;
  #surface;
  #cloud;
  #mesh;
  #points = [];
  #size;
  #brightness;

  constructor(node, { positions, faces, cloud = false }, signal, { picked = false, reach = 0 } = {}) {
    this.#node = node;
    this.#signal = signal;
    this.#size = Math.max(reach, extent(positions));
    this.#brightness = brightness(positions, faces);
    this.#mesh = { positions, faces };
    const drawn = cloud
      ? { type: "scatter3d", mode: "markers" }
      : { type: "mesh3d", ...FLAT, ...columns(faces, ["i", "j", "k"]) };
    this.#surface = {
      ...drawn, hoverinfo: picked ? "none" : "skip", ...columns(positions, ["x", "y", "z"]),
    };
    this.#cloud = cloud;
  }

  /**
   * Draw the shape.
   * @param {ArrayLike<number>|null} shades (3 V) colours of the surface, 0..255
   * @param {Object} marks `points`, their `colors` and `names`, whether names are shown (`numbered`), and
   *   `ring`, the index of the point with a ring or null
   */
  async show(shades, { points, colors, names, numbered, ring } = NOTHING) {
    this.#plotly ??= await plotly();
    if (this.#signal.aborted) return;
    this.#points = points;
    const vertexcolor = Array.from(this.#brightness, (light, v) =>
      css([0, 1, 2].map((k) => Math.round(light * (shades === null ? SKIN : shades[3 * v + k])))));
    const painted = this.#cloud ? { marker: { size: DOT, color: vertexcolor, line: { width: 0 } } } : { vertexcolor };
    const surface = { ...this.#surface, ...painted };
    const marks = {
      type: "scatter3d", mode: numbered ? "markers+text" : "markers", ...columnsOf(points),
      text: names, hoverinfo: "none", textposition: "top center",
      textfont: { size: 11, color: colorOf("ink") },
      marker: { size: 6, color: colors.map(css), line: { color: "white", width: 1 } },
    };
    const first = this.#node.data === undefined;
    await this.#plotly.react(this.#node, [surface, marks, this.#ring(ring)], this.#layout(), CONFIG);
    if (first) this.#signal.addEventListener("abort", () => this.#plotly.purge(this.#node));
  }

  /** Draw the shape, without points, with its vertices elsewhere; it stays within the drawing. */
  async reshape(positions) {
    this.#size = Math.max(this.#size, extent(positions));
    this.#mesh = { ...this.#mesh, positions };
    this.#brightness = brightness(positions, this.#mesh.faces);
    this.#surface = { ...this.#surface, ...columns(positions, ["x", "y", "z"]) };
    await this.show(null);
  }

  /** Draw a ring round one of the points, or round none. */
  async ring(pair) {
    if (this.#node.data === undefined) return;
    const { x, y, z } = this.#ring(pair);
    await this.#plotly.restyle(this.#node, { x: [x], y: [y], z: [z] }, [RING]);
  }

  /** Move the points, and draw a ring round one of them, or round none. */
  async move(points, pair) {
    this.#points = points;
    if (this.#node.data === undefined) return;
    const [marks, ring] = [columnsOf(points), this.#ring(pair)];
    const both = Object.fromEntries(["x", "y", "z"].map((name) => [name, [marks[name], ring[name]]]));
    await this.#plotly.restyle(this.#node, both, [POINTS, RING]);
  }

  #ring(pair) {
    this.#node.dataset.pair = pair ?? "";
    return {
      type: "scatter3d", mode: "markers", hoverinfo: "skip",
      ...columnsOf(pair === null ? [] : [this.#points[pair]]),
      marker: { size: 16, symbol: "circle-open", color: colorOf("mark"), line: { width: 5 } },
    };
  }

  #layout() {
    const axis = { visible: false, showspikes: false, range: [-this.#size, this.#size] };
    return {
      scene: {
        aspectmode: "manual", aspectratio: ZOOM, xaxis: axis, yaxis: axis, zaxis: axis, dragmode: "orbit",
        camera: {
          eye: { x: 0, y: 0, z: 2 }, up: { x: 0, y: 1, z: 0 }, projection: { type: "orthographic" },
        },
      },
      margin: { l: 0, r: 0, t: 0, b: 0 }, showlegend: false, uirevision: "kept",
      paper_bgcolor: "rgba(0,0,0,0)",
    };
  }

  /** After `show`: report the point under the pointer, null when it leaves, and the point that is clicked. */
  watch(hover, click) {
    const pairOf = (event) => event.points.find((point) => point.curveNumber === POINTS)?.pointNumber;
    // plotly.js reports pointers while it draws; the drawing must not be changed before it is done.
    const later = (pair) => setTimeout(() => hover(pair));
    this.#node.on("plotly_hover", (event) => later(pairOf(event) ?? null));
    this.#node.on("plotly_unhover", () => later(null));
    this.#node.on("plotly_click", (event) => {
      const pair = pairOf(event);
      if (pair !== undefined) setTimeout(() => click(pair));
    });
  }

  /** After `show`: report the drawn vertex that is clicked; turning the shape is not a click. */
  pick(tell) {
    let [vertex, pressed] = [null, null];
    const look = ({ points }) => {
      vertex = points.find((point) => point.curveNumber === SURFACE)?.pointNumber ?? null;
    };
    const known = () => vertex !== null && tell(vertex);
    this.#node.on("plotly_hover", look);
    this.#node.on("plotly_click", look);
    this.#node.on("plotly_unhover", () => { vertex = null; });
    this.#node.addEventListener("pointerdown", (event) => { pressed = event; }, true);
    this.#node.addEventListener("pointerup", (event) => {
      if (Math.hypot(event.clientX - pressed?.clientX, event.clientY - pressed?.clientY) > STILL) return;
      setTimeout(known, vertex === null || event.pointerType === "touch" ? TOUCH : 0);
    }, true);
  }

  /** After `show`: let points be dragged; `tell` is that of `dragPoints`. */
  drag(tell) {
    dragPoints(this.#node, this.#mesh, () => this.#points, tell);
  }

  /** Unit vectors to the right and up on the screen. */
  get axes() {
    return screenAxes(this.#node);
  }

  /** Report the camera whenever the user has moved it. */
  follow(tell) {
    this.#node.on("plotly_relayout", (change) => {
      const camera = change["scene.camera"];
      if (camera) tell(camera);
    });
  }

  async look(camera) {
    await this.#plotly.relayout(this.#node, { "scene.camera": camera });
  }
}

/** Greatest coordinate of any vertex. */
export const extent = (positions) => positions.reduce((most, value) => Math.max(most, Math.abs(value)), 0);

function columns(values, names) {
  return Object.fromEntries(names.map((name, k) =>
    [name, Array.from({ length: values.length / 3 }, (_, v) => values[3 * v + k])]));
}

// Brightness of each vertex, lit from the upper left; the light turns with the shape.
function brightness(positions, faces) {
  const across = normals(positions, faces);
  return Float32Array.from({ length: positions.length / 3 }, (_, v) => {
    const normal = [0, 1, 2].map((k) => across[3 * v + k]);
    const length = Math.hypot(...normal) || 1;
    const cosine = normal.reduce((sum, value, k) => sum + value * LIGHT[k], 0) / length;
    return DARKEST + (1 - DARKEST) * (0.5 + 0.5 * cosine);
  });
}

const columnsOf = (points) =>
  Object.fromEntries(["x", "y", "z"].map((name, k) => [name, points.map((point) => point[k])]));
