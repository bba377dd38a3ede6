// Arrays of NPZ files, which are ZIP archives of NPY files; each array is unpacked when it is asked for.

const END = 0x06054b50;
/** Bytes of the ZIP records, without names, extra fields and comments. */
const [END_LENGTH, ENTRY_LENGTH, LOCAL_LENGTH] = [22, 46, 30];
const DEFLATED = 8;

/**
 * Open an NPZ file.
 * @param {ArrayBuffer} buffer
 * @returns {function(string): Promise<Object|null>} the array of a name: `shape`, and `data` in C order;
 *   integers of 64 bits are returned as 32, texts as strings. Null if there is none
 */
export function openNpz(buffer) {
  const entries = entriesOf(new DataView(buffer));
  return async (name) => {
    const entry = entries.get(`${name}.npy`);
    return entry === undefined ? null : readNpy(await unpacked(buffer, entry));
  };
}

function entriesOf(view) {
  let end = view.byteLength - END_LENGTH;
  while (end >= 0 && view.getUint32(end, true) !== END) end--;
  if (end < 0) throw new Error("These arrays are not an NPZ file; reload the page.");
  const entries = new Map();
  let at = view.getUint32(end + 16, true);
  for (let left = view.getUint16(end + 10, true); left > 0; left--) {
    const [name, extra, comment] = [28, 30, 32].map((place) => view.getUint16(at + place, true));
    const text = new TextDecoder().decode(new Uint8Array(view.buffer, at + ENTRY_LENGTH, name));
    entries.set(text, {
      method: view.getUint16(at + 10, true), packed: view.getUint32(at + 20, true), start: view.getUint32(at + 42, true),
    });
    at += ENTRY_LENGTH + name + extra + comment;
  }
  return entries;
}

async function unpacked(buffer, { method, packed, start }) {
  const [name, extra] = [26, 28].map((place) => new DataView(buffer).getUint16(start + place, true));
  const first = start + LOCAL_LENGTH + name + extra;
  if (method !== DEFLATED) return buffer.slice(first, first + packed);
  const bytes = new Blob([new Uint8Array(buffer, first, packed)]);
  return new Response(bytes.stream().pipeThrough(new DecompressionStream("deflate-raw"))).arrayBuffer();
}

const KINDS = { "<f8": Float64Array, "<f4": Float32Array, "<i8": Int32Array, "<i4": Int32Array };

function readNpy(buffer) {
  const view = new DataView(buffer);
  const [at, length] = view.getUint8(6) === 1 ? [10, view.getUint16(8, true)] : [12, view.getUint32(8, true)];
  const head = new TextDecoder().decode(new Uint8Array(buffer, at, length));
  const dtype = head.match(/'descr': '([^']*)'/)?.[1];
  const isText = dtype?.startsWith("<U");
  if (!isText && !(dtype in KINDS)) throw new Error(`This page does not read arrays of ${dtype ?? "several types"}.`);
  const shape = [...head.match(/'shape': \(([^)]*)\)/)[1].matchAll(/\d+/g)].map(Number);
  if (isText) return { shape, data: texts(buffer.slice(at + length), Number(dtype.slice(2)), shape.reduce((product, side) => product * side, 1)) };
  let data = new KINDS[dtype](buffer.slice(at + length));
  // The low halves of 64 bits: numbers of vertices are small.
  if (dtype === "<i8") data = data.filter((_, place) => place % 2 === 0);
  return { shape, data: head.includes("'fortran_order': True") ? inCOrder(data, shape) : data };
}

// Texts of `width` code points of four bytes each, filled up with zeros.
function texts(buffer, width, count) {
  const points = new Uint32Array(buffer);
  return Array.from({ length: count }, (_, row) =>
    String.fromCodePoint(...points.subarray(width * row, width * (row + 1)).filter((point) => point > 0)));
}

// In Fortran order the first index varies fastest.
function inCOrder(data, shape) {
  const size = data.length;
  return data.map((_, place) => {
    let [rest, step, from, block] = [place, 1, 0, size];
    for (const length of shape) {
      block /= length;
      from += Math.floor(rest / block) * step;
      rest %= block;
      step *= length;
    }
    return data[from];
  });
}
