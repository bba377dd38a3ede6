// A shape in three dimensions, with its matched points.

import { normals } from "./geometry.js";
import { colorOf, hideParts, plotly } from "./plotly.js";
import { screenAxes } from "./camera.js";
import { css } from "./colors.js";
import { dragPoints } from "./dragging.js";
import { isHidden } from "./surface_point.js";
import { ABOUT_KEYS, isSameView, viewAfter } from "./turning.js";

const FLAT = { lighting: { ambient: 1, diffuse: 0, specular: 0, roughness: 1, fresnel: 0 } };
const LIGHT = [-0.36, 0.56, 0.75];
const DARKEST = 0.55;
const SKIN = 218;
/** Depth, in units of the shape's greatest coordinate, that nothing of it exceeds: √3 at a corner of its box. */
const IN_FRONT = 1.75;
/** Reach of the axes in the same units, so that a ring at this depth is within. */
const ROOM = 2.5;
/** Size of the shape in the drawing: the aspect ratio, as the projection is orthographic. */
const ZOOM = 1.75;
const CAMERA = {
  eye: { x: 0, y: 0, z: 2 }, center: { x: 0, y: 0, z: 0 }, up: { x: 0, y: 1, z: 0 }, projection: { type: "orthographic" },
};
const CONFIG = { displaylogo: false, responsive: true, displayModeBar: false, doubleClick: false };
/** Size of the points of a cloud, in pixels. */
const DOT = 2;
const SURFACE = 0;
const POINTS = 1;
const RING = 2;
const LABELS = 3;
/** Depth, in units of the shape's greatest coordinate, by which names are drawn in front of their points: so the surface covers none. */
const LIFT = 0.6;
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
  #names = [];
  #far = [];
  #size;
  #brightness;
  #pair = null;
  #view;
  #first;
  #followers = [];

  constructor(node, { positions, faces, cloud = false }, signal, { picked = false, reach = 0 } = {}) {
    this.#node = node;
    this.#signal = signal;
    this.#resize(Math.max(reach, extent(positions)));
    // A picture that keys turn is none for screen readers, which would keep the keys to themselves.
    const about = { tabindex: "0", role: "application", "aria-roledescription": "drawing", "aria-description": ABOUT_KEYS };
    for (const [name, value] of Object.entries(about)) node.setAttribute(name, value);
    node.addEventListener("keydown", (event) => this.#press(event), { signal });
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
    // Each scene is drawn in a task of its own, so that the page answers between two.
    await new Promise((resolve) => setTimeout(resolve));
    if (this.#signal.aborted) return;
    this.#points = points;
    this.#names = numbered ? names : [];
    this.#look();
    const vertexcolor = Array.from(this.#brightness, (light, v) =>
      css([0, 1, 2].map((k) => Math.round(light * (shades === null ? SKIN : shades[3 * v + k])))));
    const painted = this.#cloud ? { marker: { size: DOT, color: vertexcolor, line: { width: 0 } } } : { vertexcolor };
    const surface = { ...this.#surface, ...painted };
    const marks = {
      type: "scatter3d", mode: "markers", ...columnsOf(points), text: names, hoverinfo: "none",
      marker: { size: 6, color: colors.map(css), line: { color: "white", width: 1 } },
    };
    const first = this.#node.data === undefined;
    await this.#plotly.react(this.#node, [surface, marks, this.#ring(ring), this.#labels()], this.#layout(), CONFIG);
    if (!first) return;
    hideParts(this.#node);
    this.#signal.addEventListener("abort", () => this.#plotly.purge(this.#node));
    this.#node.on("plotly_relayout", (change) => this.#turned(change));
  }

  /** Draw the shape, without points, with its vertices elsewhere; it stays within the drawing. */
  async reshape(positions) {
    if (extent(positions) > this.#size) this.#resize(extent(positions));
    this.#mesh = { ...this.#mesh, positions };
    this.#brightness = brightness(positions, this.#mesh.faces);
    this.#surface = { ...this.#surface, ...columns(positions, ["x", "y", "z"]) };
    await this.show(null);
  }

  /** Draw a ring round one of the points, or round none. */
  async ring(pair) {
    if (this.#node.data === undefined) return;
    const { x, y, z, marker } = this.#ring(pair);
    await this.#plotly.restyle(this.#node, { x: [x], y: [y], z: [z], "marker.symbol": marker.symbol }, [RING]);
  }

  /** Move the points, and draw a ring round one of them, or round none. */
  async move(points, pair) {
    this.#points = points;
    if (this.#node.data === undefined) return;
    if (pair !== null) this.#far[pair] = this.hides(pair);
    const [marks, ring, labels] = [columnsOf(points), this.#ring(pair), this.#labels()];
    const all = Object.fromEntries(["x", "y", "z", "text"].map((name) => [name, [marks[name], ring[name], labels[name]]]));
    await this.#plotly.restyle(this.#node, all, [POINTS, RING, LABELS]);
  }

  // Find out which points are on the far side.
  #look() {
    this.#far = this.#names.map((_, i) => this.hides(i));
  }

  // The names of the points that are seen, in front of the surface.
  #labels() {
    const shown = this.#names.flatMap((_, i) => (this.#far[i] ? [] : [i]));
    const towards = this.#towards;
    return {
      type: "scatter3d", mode: "text", hoverinfo: "skip", textposition: "top center",
      textfont: { size: 11, color: colorOf("label") }, text: shown.map((i) => this.#names[i]),
      ...columnsOf(shown.map((i) => this.#points[i].map((value, k) => value + LIFT * this.#size * towards[k]))),
    };
  }

  async #relabel() {
    this.#look();
    const { x, y, z, text } = this.#labels();
    await this.#plotly.restyle(this.#node, { x: [x], y: [y], z: [z], text: [text] }, [LABELS]);
  }

  // On the far side, the ring is drawn in front of the surface; the projection leaves it where it is on the screen.
  #ring(pair) {
    this.#pair = pair;
    this.#node.dataset.pair = pair ?? "";
    const hidden = pair !== null && this.hides(pair);
    const front = (point) => {
      const towards = this.#towards;
      const depth = point.reduce((sum, value, k) => sum + value * towards[k], 0);
      return point.map((value, k) => value + (IN_FRONT * this.#size - depth) * towards[k]);
    };
    return {
      type: "scatter3d", mode: "markers", hoverinfo: "skip",
      ...columnsOf(pair === null ? [] : [hidden ? front(this.#points[pair]) : this.#points[pair]]),
      marker: { size: 16, symbol: hidden ? "diamond-open" : "circle-open", color: colorOf("ring"), line: { width: 5 } },
    };
  }

  /** Whether a point is on the far side of the shape, as it is seen. */
  hides(pair) {
    return this.#points[pair] !== undefined && isHidden(this.#mesh, this.#points[pair], this.#towards);
  }

  // Unit vector to the viewer.
  get #towards() {
    const { eye, center } = this.#view.camera;
    const sight = ["x", "y", "z"].map((name) => eye[name] - center[name]);
    return sight.map((value) => value / Math.hypot(...sight));
  }

  #resize(size) {
    this.#size = size;
    // Nothing is drawn outside the axes: there must be room for rings in front of the shape.
    const ratio = ZOOM * ROOM;
    this.#first = { camera: CAMERA, aspectratio: { x: ratio, y: ratio, z: ratio } };
    this.#view ??= this.#first;
  }

  #layout() {
    const reach = ROOM * this.#size;
    const axis = { visible: false, showspikes: false, range: [-reach, reach] };
    return {
      scene: { aspectmode: "manual", ...this.#view, xaxis: axis, yaxis: axis, zaxis: axis, dragmode: "orbit" },
      margin: { l: 0, r: 0, t: 0, b: 0 }, showlegend: false, paper_bgcolor: "rgba(0,0,0,0)",
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

  /** Report the view whenever the user has moved it. */
  follow(tell) {
    this.#followers.push(tell);
  }

  async look(view) {
    this.#view = view;
    if (this.#node.data === undefined) return;
    await this.#plotly.relayout(this.#node, { "scene.camera": view.camera, "scene.aspectratio": view.aspectratio });
    await this.#redraw();
  }

  // Draw again the marks that depend on the view.
  async #redraw() {
    if (this.#pair !== null) await this.ring(this.#pair);
    if (this.#names.length > 0) await this.#relabel();
  }

  async #press(event) {
    const view = event.ctrlKey || event.metaKey || event.altKey ? null : viewAfter(event.key, this.#view, this.#first);
    if (view === null || this.#node.data === undefined) return;
    event.preventDefault();
    await this.look(view);
    this.#followers.forEach((tell) => tell(view));
  }

  // plotly.js reports views that it was given as well.
  #turned(change) {
    const view = {
      camera: change["scene.camera"] ?? this.#view.camera, aspectratio: change["scene.aspectratio"] ?? this.#view.aspectratio,
    };
    if (isSameView(view, this.#view)) return;
    // plotly.js forgets a view that a mouse left, once it has drawn another layout, unless it is given the view.
    this.look(view);
    this.#followers.forEach((tell) => tell(view));
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
