// Arrays of a NumPy archive: .npy files in a ZIP.

const END = 0x06054b50;
const END_LENGTH = 22;
const ENTRY_LENGTH = 46;
const HEADER_LENGTH = 30;
const KINDS = { "<f8": Float64Array, "<f4": Float32Array, "<i8": BigInt64Array, "<i4": Int32Array };

/**
 * Read arrays of an archive.
 * @param {ArrayBuffer} buffer
 * @param {Array<string>} names those that are wanted
 * @returns {Promise<Object>} values of each that there is, row by row, as plain numbers
 */
export async function readArrays(buffer, names) {
  const view = new DataView(buffer);
  const found = {};
  for (const entry of entries(view)) {
    if (names.includes(entry.name)) found[entry.name] = values(await unpacked(view, entry));
  }
  return found;
}

// What is at the archive's end lists what is in it.
function* entries(view) {
  let end = view.byteLength - END_LENGTH;
  while (end >= 0 && view.getUint32(end, true) !== END) end--;
  if (end < 0) throw new Error("This is no NumPy archive.");
  const count = view.getUint16(end + 10, true);
  let at = view.getUint32(end + 16, true);
  for (let i = 0; i < count; i++) {
    const [name, extra, comment] = [28, 30, 32].map((k) => view.getUint16(at + k, true));
    yield {
      name: text(view, at + ENTRY_LENGTH, name).replace(/\.npy$/, ""),
      packed: view.getUint16(at + 10, true) !== 0,
      size: view.getUint32(at + 20, true),
      start: view.getUint32(at + 42, true),
    };
    at += ENTRY_LENGTH + name + extra + comment;
  }
}

async function unpacked(view, { packed, size, start }) {
  const at = start + HEADER_LENGTH + view.getUint16(start + 26, true) + view.getUint16(start + 28, true);
  const data = new Blob([new Uint8Array(view.buffer, at, size)]);
  if (!packed) return data.arrayBuffer();
  return new Response(data.stream().pipeThrough(new DecompressionStream("deflate-raw"))).arrayBuffer();
}

function values(buffer) {
  const view = new DataView(buffer);
  const [start, length] = view.getUint8(6) === 1 ? [10, view.getUint16(8, true)] : [12, view.getUint32(8, true)];
  const header = text(view, start, length);
  const kind = KINDS[header.match(/'descr': '([^']+)'/)?.[1]];
  if (kind === undefined) throw new Error("This array is of a kind that this page does not read.");
  const found = Array.from(new kind(buffer, start + length), Number);
  const [, rows, columns] = header.match(/'fortran_order': True, 'shape': \((\d+), (\d+)\)/) ?? [];
  return rows === undefined ? found : byRows(found, Number(rows), Number(columns));
}

const byRows = (values, rows, columns) =>
  Array.from(values, (_, at) => values[(at % columns) * rows + Math.floor(at / columns)]);

const text = (view, at, length) => new TextDecoder().decode(new Uint8Array(view.buffer, view.byteOffset + at, length));
