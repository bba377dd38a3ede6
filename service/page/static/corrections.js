// Positions of landmarks that are corrected by hand, with what they were before.

/** Dispatches "change" whenever a position changes. Positions are points of a surface, or null where one is missing. */
export class Corrections extends EventTarget {
  #original;
  #history;
  #dragged = null;

  /** @param {Array<Array>} moves index and position of each landmark that was moved before: see `moves` */
  constructor(points, moves = []) {
    super();
    this.#original = points;
    this.#history = [points];
    if (moves.length > 0) this.#history.push(moves.reduce((moved, [i, point]) => moved.with(i, point), points));
  }

  /** The positions, that of a landmark being dragged included. */
  get points() {
    return this.#dragged ?? this.#history.at(-1);
  }

  get dragging() {
    return this.#dragged !== null;
  }

  /** Index and position of each landmark that is moved. */
  get moves() {
    return this.points.flatMap((point, i) => (this.moved(i) ? [[i, point]] : []));
  }

  get canUndo() {
    return this.#history.length > 1;
  }

  moved(i) {
    return this.points[i] !== this.#original[i];
  }

  get anyMoved() {
    return this.points.some((_, i) => this.moved(i));
  }

  /** Show a position on the way, which `undo` does not return to. */
  drag(i, point) {
    this.#dragged = this.points.with(i, point);
    this.#tell();
  }

  /** End a drag where it is. */
  drop() {
    if (this.#dragged !== null) this.#set(this.#dragged);
  }

  move(i, point) {
    this.#set(this.points.with(i, point));
  }

  reset(i) {
    this.move(i, this.#original[i]);
  }

  resetAll() {
    this.#set(this.#original);
  }

  undo() {
    if (!this.canUndo) return;
    this.#dragged = null;
    this.#history.pop();
    this.#tell();
  }

  #set(points) {
    this.#dragged = null;
    this.#history.push(points);
    this.#tell();
  }

  #tell() {
    this.dispatchEvent(new Event("change"));
  }
}
