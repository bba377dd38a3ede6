// Specimens of a batch, and the landmarks of its template that are carried to them.

import { dropLandmarks, keepLandmarks, keptLandmarks } from "./kept_landmarks.js";
import { carryLandmarks, isOfLandmarks } from "./landmark_carrying.js";
import { stemOf } from "./landmark_files.js";

const SOURCE = 0;
/** Milliseconds until landmarks are carried again after a passing problem. */
const AGAIN = 4000;
/** Name of the table of all landmarks in an archive. */
export const TABLE = "landmarks.csv";

/** Specimens, to which landmarks are carried one after another. Dispatches "change". */
export class Specimens extends EventTarget {
  /** The landmarks that are carried, with the name of their `file`; null until there are some. */
  template = null;
  /** The specimens: the `match` of each, its `name`, `stem`, the beginning of its files' names, and its landmarks `carried`,
   *  or the `problem` why there are none; null until they are known. */
  all;
  /** Whether the tab could keep all landmarks. */
  fits = true;
  /** The passing problem, such as a busy service, after which carrying goes on a little later, or null. */
  pause = null;
  #batch;
  #signal;
  #newest = null;
  #busy = false;

  /** @param {Object} batch `job`, its id, and its `matches` */
  constructor({ job, matches }, signal) {
    super();
    [this.#batch, this.all, this.#signal] = [job, specimensOf(matches), signal];
    this.template = keptLandmarks(job);
  }

  /**
   * Carry other landmarks, to all specimens, unless others are chosen before they are known to be usable.
   * @param {Object} template `file`, `coordinates` and the landmarks `given`
   * @throws {Problem} none of the landmarks can be carried, if a specimen is matched yet
   */
  async begin(template) {
    const next = this.#newest = { ...template, end: SOURCE };
    const matched = this.all.find(({ match }) => match.state === "succeeded");
    const first = matched === undefined ? null : await this.#carried(matched, next).catch((problem) => {
      if (isOfLandmarks(problem)) throw problem;
      return null;
    });
    // Others may have been chosen meanwhile.
    if (this.#newest !== next) return;
    this.template = next;
    this.fits = keepLandmarks(this.#batch, this.template);
    for (const one of this.all) {
      [one.carried, one.problem] = [null, null];
      dropLandmarks(one.match.job);
    }
    if (first !== null) this.#take(matched, first);
    this.#tell();
    this.work();
  }

  /** Take over the states of the matches. */
  update(matches) {
    matches.forEach((match, at) => Object.assign(this.all[at], { match }));
    this.#tell();
    this.work();
  }

  /** Carry the landmarks to the specimens that are matched and have none yet. */
  async work() {
    if (this.#busy) return;
    this.#busy = true;
    for (let one = this.#next(); one !== undefined && !this.#signal.aborted; one = this.#next()) {
      const { template } = this;
      const found = await this.#carried(one, template).then((carried) => ({ carried }), (problem) => ({ problem }));
      // Others may have been chosen meanwhile.
      if (this.#signal.aborted || template !== this.template) continue;
      this.pause = found.problem?.passing ? found.problem : null;
      if (this.pause !== null) {
        this.#tell();
        await new Promise((resolve) => setTimeout(resolve, AGAIN));
        continue;
      }
      if (found.problem === undefined) this.#take(one, found.carried);
      else one.problem = found.problem;
      this.#tell();
    }
    this.#busy = false;
  }

  #take(one, carried) {
    one.carried = carried;
    if (!keepLandmarks(one.match.job, carried)) this.fits = false;
  }

  #next() {
    return this.template === null ? undefined
      : this.all.find(({ match, carried, problem }) => match.state === "succeeded" && carried === null && problem === null);
  }

  #carried({ match }, template) {
    return carryLandmarks(match.job, template, this.#signal);
  }

  #tell() {
    this.dispatchEvent(new Event("change"));
  }
}

// Specimens with the landmarks that the tab has of them; `stem` begins the name of a file, and no two are the same.
function specimensOf(matches) {
  const taken = new Set([stemOf(TABLE)]);
  return matches.map((match) => {
    const name = match.target_name ?? match.target.slice(0, 8);
    const usable = stemOf(name).replace(/[\\/]/g, "_");
    let stem = usable;
    for (let number = 2; taken.has(stem); number++) stem = `${usable}-${number}`;
    taken.add(stem);
    return { match, name, stem, carried: keptLandmarks(match.job), problem: null };
  });
}
