// Files of landmarks: markups (.mrk.json) and fiducials (.fcsv) of 3D Slicer, and tables of points (.csv).
//
// A landmark has `label`, `position` (null if it is missing) and `remark`, its description in the file. Markups name
// their coordinate system, LPS or RAS, which differ by the sign of x and y; positions are converted to that of the mesh.

const SYSTEMS = { LPS: "LPS", RAS: "RAS", 1: "LPS", 0: "RAS" };
const STATES = ["defined", "undefined", "preview", "missing"];
const COLUMNS = "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID";
const SCHEMA = "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json#";
const AXES = [[["x", "y", "z"], null], [["l", "p", "s"], "LPS"], [["r", "a", "s"], "RAS"]];
const LABELS = ["label", "name", "landmark", "id"];
const MOST_NAMED = 10;
const NUMBER = /^[+-]?(\d+[.,]?\d*|[.,]\d+)(e[+-]?\d+)?$/i;

/** Endings of the files. */
export const FORMATS = ["mrk.json", "fcsv", "csv"];

/** A file that cannot be read. */
class LandmarkFileError extends Error {
  constructor(message, line = null) {
    super(line === null ? message : `line ${line}: ${message}`);
    this.title = "This file of landmarks cannot be read";
  }
}

/**
 * Read a file.
 * @param {string} name of the file; its ending is the format
 * @param {string} system coordinate system of the mesh
 * @param {string} mesh name of the mesh, whose landmarks are taken if the file has several specimens
 * @returns {Array<Object>} the landmarks, at least one
 */
export function readLandmarks(name, text, system, mesh) {
  const ending = name.toLowerCase().split(".").pop();
  const read = { json: readMarkups, fcsv: readFiducials, csv: readTable }[ending];
  if (read === undefined) throw new LandmarkFileError(`The name ends with none of .${FORMATS.join(", .")}.`);
  const found = ofSpecimen(read(text.replace(/^\uFEFF/, ""), system), mesh);
  if (found.length === 0) throw new LandmarkFileError("There are no landmarks in it.");
  return found.map(({ label, position, remark }, at) => ({ label: label || String(at + 1), position, remark }));
}

// The landmarks of one specimen; of several, as in the table of isomatch landmarks, those that bear the mesh's name.
function ofSpecimen(landmarks, mesh) {
  const names = [...new Set(landmarks.map(({ specimen }) => specimen))];
  if (names.length < 2) return landmarks;
  const found = names.filter((name) => stemOf(name) === stemOf(mesh));
  if (found.length !== 1) {
    const known = names.slice(0, MOST_NAMED).map((name) => `"${name}"`).join(", ");
    const more = names.length > MOST_NAMED ? ` and ${names.length - MOST_NAMED} more` : "";
    throw new LandmarkFileError(`It has several specimens, ${known}${more}, and not one called "${stemOf(mesh)}", like the mesh.`);
  }
  return landmarks.filter(({ specimen }) => specimen === found[0]);
}

/**
 * Write a file.
 * @param {string} format one of `FORMATS`
 * @param {string} name of the specimen
 * @param {string} system coordinate system of the positions
 */
export function writeLandmarks(format, name, landmarks, system) {
  if (format === "mrk.json") return writeMarkups(name, landmarks, system);
  const rows = format === "fcsv" ? landmarks.map(fiducialRow)
    : [["label", "x", "y", "z"], ...landmarks.map(({ label, position }) => [label, ...(position ?? ["", "", ""])])];
  const head = format === "fcsv"
    ? `# Markups fiducial file version = 4.13\n# CoordinateSystem = ${system}\n# columns = ${COLUMNS}\n` : "";
  return head + writeTable(rows);
}

/** A table as CSV; null is an empty entry. */
export const writeTable = (rows) => rows.map((row) => `${row.map((entry) => quoted(entry ?? "")).join(",")}\n`).join("");

/** The name of a specimen: that of its file without the ending. */
export const stemOf = (name) => name.replace(/\.[^.]*$/, "");

function systemOf(given, line = null) {
  const found = SYSTEMS[String(given).trim().toUpperCase()];
  if (found === undefined) throw new LandmarkFileError(`The coordinate system "${given}" is neither LPS nor RAS.`, line);
  return found;
}

const converted = (position, from, to) =>
  (position === null || from === to ? position : [-position[0], -position[1], position[2]]);

function readMarkups(text, system) {
  let document;
  try {
    document = JSON.parse(text);
  } catch (error) {
    throw new LandmarkFileError(`It is not JSON: ${error.message}`);
  }
  return list(document, "markups").flatMap((markup) => {
    const from = systemOf(markup?.coordinateSystem ?? "LPS");
    return list(markup, "controlPoints").map((point) => ({
      label: String(point?.label ?? ""), remark: String(point?.description ?? ""),
      position: converted(controlPoint(point), from, system),
    }));
  });
}

function list(object, name) {
  if (!Array.isArray(object?.[name])) throw new LandmarkFileError(`There is no list "${name}": it is no file of Slicer markups.`);
  return object[name];
}

function controlPoint(point) {
  const state = point?.positionStatus ?? "defined";
  if (!STATES.includes(state)) throw new LandmarkFileError(`A positionStatus is "${state}", none of ${STATES.join(", ")}.`);
  if (state !== "defined") return null;
  const position = list(point, "position");
  if (position.length !== 3 || !position.every(Number.isFinite)) throw new LandmarkFileError(`A position is not three numbers: ${position}`);
  return position;
}

function readFiducials(text, system) {
  let names = COLUMNS.split(",");
  let from = "RAS";
  const found = [];
  text.split(/\r?\n/).forEach((content, at) => {
    const line = at + 1;
    if (content.startsWith("#")) {
      const [key, value] = content.slice(1).split("=");
      if (key.trim() === "CoordinateSystem") from = systemOf(value, line);
      else if (key.trim() === "columns") names = value.split(",").map((name) => name.trim());
    } else if (content.trim() !== "") {
      const [[, entries]] = rowsOf(content, ",");
      if (entries.length < names.length - 3) throw new LandmarkFileError(`${entries.length} entries for ${names.length} columns`, line);
      const entry = (name) => entries[names.indexOf(name)] ?? "";
      // From version 4.13 on the status of the position follows the named columns; 2 is "defined".
      const defined = ["", "2"].includes(entries[names.length] ?? "");
      const position = defined ? positionOf(["x", "y", "z"].map(entry), line) : null;
      found.push({ label: entry("label"), remark: entry("desc"), position });
    }
  });
  return found.map((one) => ({ ...one, position: converted(one.position, from, system) }));
}

function readTable(text, system) {
  const first = text.split(/\r?\n/).find((line) => line.trim() !== "") ?? "";
  // Commas may be those of decimals.
  const delimiter = [";", "\t"].find((mark) => first.split(mark).length > 2) ?? ",";
  let rows = rowsOf(text, delimiter).filter(([, entries]) => entries.some((entry) => entry !== ""));
  if (rows.length === 0) return [];
  const head = rows[0][1].map((name) => name.toLowerCase());
  const named = AXES.some(([axes]) => axes.every((axis) => head.includes(axis)));
  if (named) rows = rows.slice(1);
  else if (isHeader(rows[0][1])) throw new LandmarkFileError("expected a header such as label,x,y,z", rows[0][0]);
  const names = named ? head : head.length === 3 ? ["x", "y", "z"] : ["label", "x", "y", "z"];
  const [axes, from] = AXES.find(([each]) => each.every((axis) => names.includes(axis)));
  const labels = LABELS.find((name) => names.includes(name)) ?? unnamedLabels(names, rows);
  return rows.map(([line, entries]) => {
    if (entries.length < names.length || entries.slice(names.length).some((one) => one !== "")) {
      const hint = entries.length > names.length ? "; with decimal commas delimit columns by semicolons" : "";
      throw new LandmarkFileError(`${entries.length} entries for ${names.length} columns${hint}`, line);
    }
    const entry = (name) => entries[names.indexOf(name)];
    const position = entry("defined") === "0" ? null : positionOf(axes.map(entry), line);
    const label = labels === undefined ? "" : entry(labels);
    return { label, remark: "", position: converted(position, from ?? system, system), specimen: entry("specimen") };
  });
}

// R and pandas write names of rows without a heading, and number rows that have none.
function unnamedLabels(names, rows) {
  const at = names.indexOf("");
  return at >= 0 && rows.some(([, entries]) => !NUMBER.test(entries[at])) ? "" : undefined;
}

const isMissing = (text) => ["", "na", "nan"].includes(text.toLowerCase());

// A row of points without a header has a number, or no position at all.
const isHeader = (entries) => !entries.some((entry) => NUMBER.test(entry)) && !entries.slice(-3).every(isMissing);

function positionOf(texts, line) {
  if (texts.every(isMissing)) return null;
  return texts.map((text) => {
    const number = Number(text.replace(",", "."));
    if (!NUMBER.test(text) || !Number.isFinite(number)) throw new LandmarkFileError(`"${text}" is not a finite number`, line);
    return number;
  });
}

// Line number and entries of each row; quoted entries may have delimiters, quotes and line ends in them.
function rowsOf(text, delimiter) {
  const rows = [];
  let [line, entries, entry, quoting] = [1, [], "", false];
  const end = () => {
    rows.push([line, [...entries, entry].map((one) => one.trim())]);
    [entries, entry] = [[], ""];
  };
  const plain = text.replaceAll("\r\n", "\n");
  for (let at = 0; at < plain.length; at++) {
    const letter = plain[at];
    if (quoting && letter === '"' && plain[at + 1] === '"') entry += plain[at++];
    else if (letter === '"' && (quoting || entry.trim() === "")) quoting = !quoting;
    else if (letter === delimiter && !quoting) [entries, entry] = [[...entries, entry], ""];
    else if (letter === "\n" && !quoting) end();
    else entry += letter;
    if (letter === "\n") line++;
  }
  if (quoting) throw new LandmarkFileError("A quotation does not end.", line);
  end();
  return rows;
}

const quoted = (entry) => (/[",\n\r]/.test(entry) ? `"${String(entry).replaceAll('"', '""')}"` : String(entry));
const oneLine = (text) => text.split(/\s+/).join(" ").trim();

const fiducialRow = ({ label, position, remark }, at) => [
  at + 1, ...(position ?? ["nan", "nan", "nan"]), 0, 0, 0, 1, 1, 1, 0, oneLine(label), oneLine(remark), "", position === null ? 3 : 2, 0,
];

function writeMarkups(name, landmarks, system) {
  const points = landmarks.map(({ label, position, remark }, at) => ({
    id: String(at + 1), label, description: remark, associatedNodeID: "", position: position ?? [0, 0, 0],
    selected: true, locked: false, visibility: position !== null, positionStatus: position === null ? "missing" : "defined",
  }));
  const markup = { name, type: "Fiducial", coordinateSystem: system, controlPoints: points };
  return `${JSON.stringify({ "@schema": SCHEMA, markups: [markup] }, null, 1)}\n`;
}
