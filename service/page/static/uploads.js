// Uploads of files that are dropped or picked.

import { button } from "./actions.js";
import { Problem, upload } from "./api.js";
import { h, fill } from "./dom.js";
import { keepFocus } from "./focus.js";
import { problemBox } from "./problem.js";
import { percent, several } from "./format.js";
import { confirmed } from "./question.js";

/** Uploads up to which their list has no scroll bar. */
const MOST_UNSCROLLED = 5;
/** Uploads at a time: a browser has six connections to a service, and others need one meanwhile. */
const AT_ONCE = 4;
/** Milliseconds in which shapes arrive together. */
const TOGETHER = 250;
/** Endings of files that are landmarks and no mesh. */
const LANDMARKS = /\.(json|fcsv|tps)$/i;
const ENDINGS = ".off,.obj,.ply,.stl,.glb,.gltf,.las,.laz,.xyz,.txt,.csv,.zip";

/** Files that are being uploaded. */
let uploading = 0;
/** The question whether to leave them, while it is open. */
let asking = null;

/** Whether the start page may be left: if files are being uploaded, the user is asked. */
export const mayLeave = async () => uploading === 0 || (asking ??= confirmed("Leave this page?",
  `${stillUploading(uploading)} Those that are not sent yet would be lost.`, "Leave", "Stay").finally(() => { asking = null; }));

/** "4 files are still uploading." */
export const stillUploading = (number) => `${several(number, "file")} ${number === 1 ? "is" : "are"} still uploading.`;

/**
 * A drop zone.
 * @param {function(...Object)} arrived called with uploaded shapes, in the order of the files
 * @param {function()} complete called when all have arrived
 * @param {function(number)} pending called with the number of files that are being uploaded, at each change
 * @returns {Object} `node`; `take`, which uploads files; `begin`, from when on files dropped elsewhere are taken
 */
export function dropZone(arrived, complete, pending, signal) {
  const said = h("p", { class: "faint", role: "status" });
  const list = h("ul", { class: "uploads", "aria-label": "Uploads" });
  let [wanted, uploaded, refused, unsent] = [0, 0, 0, 0];
  const tell = () => {
    if (signal.aborted) return;
    uploading = wanted - uploaded - refused - unsent;
    pending(uploading);
    const over = uploading === 0;
    const parts = [`${uploaded} of ${wanted} files uploaded`, ...(refused > 0 ? [`${refused} refused`] : []),
      ...(unsent > 0 ? [`${unsent} not sent`] : [])];
    said.textContent = over && (uploaded === wanted || wanted === 1) ? "" : parts.join(", ");
    if (over) [wanted, uploaded, refused, unsent] = [0, 0, 0, 0];
    list.tabIndex = list.childElementCount > MOST_UNSCROLLED ? 0 : -1;
  };
  signal.addEventListener("abort", () => { uploading = 0; });
  const inTurn = limited(AT_ONCE);
  // Names of the files by the ids of their shapes.
  const first = new Map();
  const take = async (files) => {
    const named = [...files];
    wanted += named.length;
    const uploads = named.map(async (file) => {
      const { shape = null, problem } = await sent(file, list, inTurn, signal, { take, input });
      if (shape !== null) uploaded += 1;
      else if (problem?.passing) unsent += 1;
      else refused += 1;
      tell();
      return shape;
    });
    tell();
    const group = [];
    let timer = null;
    const arrive = () => {
      timer = null;
      if (group.length > 0) arrived(...group.splice(0));
    };
    for (const [at, shape] of uploads.entries()) {
      const found = await shape;
      if (found === null) continue;
      const same = first.get(found.id);
      if (same === undefined) first.set(found.id, named[at].name);
      else list.append(note(`${named[at].name} has the same content as ${same}: it is the same shape, and is used once.`));
      group.push(found);
      timer ??= setTimeout(arrive, TOGETHER);
    }
    clearTimeout(timer);
    arrive();
    await complete();
  };
  const zone = fileArea({ id: "files", accept: ENDINGS, multiple: true }, [h("strong", {}, "Choose meshes"), " or drop them here"],
    "OFF, OBJ, PLY, STL, GLB or GLTF; OBJ with its materials as one ZIP; points as PLY, XYZ, TXT, CSV, LAS or LAZ", take);
  const input = zone.querySelector("input");
  return {
    node: h("section", { "aria-label": "Upload" }, zone, said, list), take, begin: () => takeFromElsewhere(take, signal),
  };
}

/** An area on which files are dropped or chosen; `attributes` are those of the input. */
export function fileArea(attributes, label, about, take) {
  const input = h("input", {
    type: "file", class: "files", "aria-describedby": `about-${attributes.id}`, ...attributes,
    onchange: async () => {
      const files = [...input.files];
      input.value = "";
      await take(files);
    },
  });
  const zone = h("div", { class: "drop" },
    input, h("label", { for: attributes.id }, label), h("p", { class: "faint", id: `about-${attributes.id}` }, about));
  droppable(zone, take);
  return zone;
}

function droppable(zone, take) {
  const over = (event) => {
    event.preventDefault();
    zone.classList.add("over");
  };
  zone.addEventListener("dragover", over);
  zone.addEventListener("dragenter", over);
  zone.addEventListener("dragleave", () => zone.classList.remove("over"));
  zone.addEventListener("drop", (event) => {
    event.preventDefault();
    zone.classList.remove("over");
    take(event.dataTransfer.files);
  });
}

// Files that are dropped outside an area are for the start page, which takes them when it is shown.
const elsewhere = { take: null, waiting: [] };

/** Take files that are dropped anywhere: a browser would leave the page and show them instead. Also ask before it is closed. */
export function takeDroppedAnywhere() {
  window.addEventListener("beforeunload", (event) => uploading > 0 && event.preventDefault());
  window.addEventListener("dragover", (event) => event.preventDefault());
  window.addEventListener("drop", (event) => {
    if (event.defaultPrevented) return;
    event.preventDefault();
    const files = [...event.dataTransfer.files];
    if (files.length === 0) return;
    if (elsewhere.take !== null) {
      elsewhere.take(files);
    } else {
      elsewhere.waiting.push(...files);
      location.hash = "#/";
    }
  });
}

function takeFromElsewhere(take, signal) {
  elsewhere.take = take;
  signal.addEventListener("abort", () => {
    elsewhere.take = null;
  });
  const files = elsewhere.waiting.splice(0);
  if (files.length > 0) take(files);
}

/** A function that awaits the results of others, at most some at a time. */
function limited(atOnce) {
  const waiting = [];
  let running = 0;
  const next = () => {
    if (running === atOnce || waiting.length === 0) return;
    running += 1;
    waiting.shift()();
  };
  return async (work) => {
    await new Promise((begin) => {
      waiting.push(begin);
      next();
    });
    try {
      return await work();
    } finally {
      running -= 1;
      next();
    }
  };
}

async function sent(file, list, inTurn, signal, { take, input }) {
  const bar = h("progress", { max: 1, value: 0, "aria-label": `Upload of ${file.name}` });
  const said = h("span", { class: "faint" }, "waiting");
  const line = h("li", {}, h("span", { class: "name" }, file.name), " ", bar, " ", said);
  list.append(line);
  try {
    if (LANDMARKS.test(file.name)) {
      throw new Problem(415, { title: "This is a file of landmarks, no mesh",
        detail: "Match two meshes with a dense map, and open the landmarks of that match: they take this file." });
    }
    const shape = await inTurn(() => upload("/v1/shapes", file, (share, job) => {
      bar.value = share;
      said.textContent = stage(share, job);
    }, signal));
    line.remove();
    for (const warning of shape.warnings) list.append(note(`${shape.name}: ${warning}`));
    return { shape };
  } catch (error) {
    if (error.name === "AbortError") return {};
    const remove = () => keepFocus(list.parentElement, () => line.remove());
    const act = (text, action) => button(text, () => {
      remove();
      action();
    }, { class: "small" });
    fill(line, h("span", { class: "name" }, file.name), error.passing ? h("span", { class: "faint" }, " not sent") : null,
      problemBox(error), h("p", { class: "actions" },
      error.passing ? act("Try again", () => take([file])) : act("Choose another file", () => input.click()),
      act("Dismiss", () => {})));
    return { problem: error };
  }
}

const stage = (share, job) => (share < 1 ? percent(share)
  : job?.waiting_for === "worker" ? "waiting: no worker is alive" : "validating");

const note = (text) => h("li", { class: "faint" }, text);
