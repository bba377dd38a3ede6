// Colours of carried values: of labels, of a scale of numbers, or the values themselves.

import { distinct } from "./colors.js";

/** Colours of the least to the greatest number, those of the heat maps: Viridis. */
const SCALE = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
/** Colour of what has no value. */
const NONE = [200, 200, 200];

/** Choices to draw of carried attributes: each attribute, or each of its columns, by its `text`. */
export function drawable({ what, attributes }) {
  return attributes.flatMap(({ name, columns }) => (isPainted(what) || columns.length === 0
    ? [{ name, at: null, text: name }]
    : columns.map((column, k) => ({ name, at: k, text: `${attributes.length > 1 ? `${name}: ` : ""}${column}` }))));
}

/** Whether values are colours themselves. */
const isPainted = (what) => what === "colors" || what === "texture";

/**
 * Colour the rows of arrays that are drawn beside one another: by one scale, or with one colour of each label.
 * @param {string} what kind of the values
 * @param {Array<Object>} arrays `shape` and `data` of an attribute, on each shape
 * @param {number|null} column of them; null for their only one, or for colours
 * @returns {Object} `colors` of each array, one for each row; of labels `legend`, each with its color; of numbers `range`
 */
export function carriedColors(what, arrays, column) {
  if (isPainted(what)) return { colors: arrays.map(ownColors) };
  const values = arrays.map(({ shape: [rows, width = 1], data }) => Array.from({ length: rows }, (_, row) => data[width * row + (column ?? 0)]));
  return what === "labels" ? ofLabels(values) : ofNumbers(values);
}

const ownColors = ({ shape: [rows, width], data }) => Array.from({ length: rows }, (_, row) => (Number.isNaN(data[width * row]) ? NONE
  : [0, 1, 2].map((k) => 255 * Math.min(1, Math.max(0, data[width * row + k])))));

const isLabel = (value) => value !== "" && value !== -1 && !Number.isNaN(value);

function ofLabels(arrays) {
  const known = [...new Set(arrays.flatMap((values) => values.filter(isLabel)))]
    .sort((a, b) => (typeof a === "number" ? a - b : a < b ? -1 : 1));
  const color = new Map(known.map((label, i) => [label, distinct(i)]));
  return {
    colors: arrays.map((values) => values.map((value) => color.get(value) ?? NONE)),
    legend: known.map((label) => [String(label), color.get(label)]),
  };
}

function ofNumbers(arrays) {
  const range = arrays.flat().reduce(([low, high], value) => (Number.isNaN(value) ? [low, high] : [Math.min(low, value), Math.max(high, value)]),
    [Infinity, -Infinity]);
  const [low, high] = range;
  const colorOf = (value) => (Number.isNaN(value) ? NONE : scaleColor(high > low ? (value - low) / (high - low) : 0.5));
  return { colors: arrays.map((values) => values.map(colorOf)), range: low <= high ? range : null };
}

/** Colour of a share of the scale, 0 to 1. */
export function scaleColor(share) {
  const place = share * (SCALE.length - 1);
  const below = Math.min(Math.floor(place), SCALE.length - 2);
  return SCALE[below].map((value, k) => Math.round(value + (place - below) * (SCALE[below + 1][k] - value)));
}

/** (3 V) colours of vertices by the rows of their file. */
export const shadesOfVertices = (colors, { numbers }) =>
  Float64Array.from({ length: 3 * numbers.length }, (_, at) => (colors[numbers[Math.floor(at / 3)]] ?? NONE)[at % 3]);

/** (3 V) colours of vertices, each the mean of those of its faces. */
export function shadesOfFaces(colors, { numbers, faces }) {
  const sums = new Float64Array(3 * numbers.length);
  const counts = new Uint32Array(numbers.length);
  faces.forEach((v, at) => {
    counts[v]++;
    for (let k = 0; k < 3; k++) sums[3 * v + k] += colors[Math.floor(at / 3)][k];
  });
  return sums.map((sum, at) => sum / Math.max(1, counts[Math.floor(at / 3)]));
}
