// The shapes of a match with landmarks on both, turned together.

import { behindNames, distinct } from "./colors.js";
import { Corrections } from "./corrections.js";
import { fill, h } from "./dom.js";
import { lifted } from "./drawn_shape.js";
import { caption, join, obstacle, toggle } from "./match_scenes.js";
import { Scene } from "./scene.js";
import { seenPoint } from "./surface_point.js";

const [SOURCE, TARGET] = [0, 1];
/** Height of landmarks above the surface, in units of half the shape's size: names are longer than numbers. */
const LIFT = 0.03;
/** Position of a missing landmark, which is not drawn. */
const NOWHERE = [NaN, NaN, NaN];

/** Both shapes with the landmarks on them; those on the target are dragged. */
export class LandmarkScenes {
  #place;
  #sides;
  #selection;
  #signal;
  #scenes = null;
  #options = { named: true, together: true };
  #landmarks = [];
  #source = [];
  #corrections = new Corrections([]);

  constructor(place, sides, selection, signal) {
    [this.#place, this.#sides, this.#selection, this.#signal] = [place, sides, selection, signal];
  }

  /** Draw the shapes, or say why they cannot be drawn. */
  async begin() {
    const reason = obstacle(this.#sides.map(({ shape }) => shape));
    if (reason !== null) {
      fill(this.#place, h("p", { class: "faint" }, reason));
      return;
    }
    const nodes = this.#sides.map(({ shape, end }) => h("div", {
      class: "scene", "data-side": end, "aria-label": `${shape.name} in three dimensions, with the landmarks`,
    }));
    fill(this.#place, h("div", { class: "pair" }, this.#sides.map(caption(nodes))), h("p", { class: "checks" },
      toggle("Names", this.#options, "named", () => this.#draw()),
      toggle("Turn both together", this.#options, "together", () => {})));
    const scenes = this.#sides.map(({ mesh }, at) => new Scene(nodes[at], mesh, this.#signal));
    this.#scenes = scenes;
    await this.#draw();
    if (this.#signal.aborted) return;
    join(scenes, this.#selection, this.#options);
    scenes[TARGET].drag((i, sight, released) => this.#dragged(i, sight, released));
    this.#place.dataset.ready = "true";
  }

  /** Draw landmarks, and again whenever one is moved. */
  async show(landmarks, source, corrections) {
    [this.#landmarks, this.#source, this.#corrections] = [landmarks, source, corrections];
    let [busy, again] = [false, false];
    corrections.addEventListener("change", async () => {
      again = true;
      if (busy || this.#scenes === null) return;
      busy = true;
      while (again) {
        again = false;
        await this.#scenes[TARGET].move(this.#points(TARGET), this.#selection.shown);
      }
      busy = false;
    });
    await this.#draw();
  }

  /** Unit vectors to the right and up, as the target is seen, or will be when it is drawn. */
  get axes() {
    return this.#place.dataset.ready === undefined ? [[1, 0, 0], [0, 1, 0]] : this.#scenes[TARGET].axes;
  }

  #dragged(i, sight, released) {
    if (sight === null || this.#selection.chosen !== i) this.#selection.choose(i);
    const point = sight === null ? null : seenPoint(this.#sides[TARGET].geometry, sight);
    if (point !== null) this.#corrections.drag(i, point);
    if (released) this.#corrections.drop();
  }

  #points(at) {
    const points = at === SOURCE ? this.#source : this.#corrections.points;
    return points.map((point) => (point === null ? NOWHERE : lifted(this.#sides[at], point.corners, point.weights, LIFT)));
  }

  async #draw() {
    await Promise.all((this.#scenes ?? []).map((scene, at) => scene.show(behindNames(this.#sides[at].mesh.colors, this.#options.named), {
      points: this.#points(at), colors: this.#landmarks.map((_, i) => distinct(i)),
      names: this.#landmarks.map(({ label }) => label), numbered: this.#options.named, ring: this.#selection.shown,
    })));
    if (this.#landmarks.length > 0) this.#place.dataset.drawn = String(this.#landmarks.length);
  }
}
