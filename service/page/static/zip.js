// ZIP archives of texts, stored as they are.

const UTF8_NAMES = 0x0800;
const VERSION = 20;
/** The first of January 1980, the earliest date that archives know. */
const DATE = 0x0021;

const CRC = Uint32Array.from({ length: 256 }, (_, byte) => {
  let value = byte;
  for (let bit = 0; bit < 8; bit++) value = value & 1 ? 0xedb88320 ^ (value >>> 1) : value >>> 1;
  return value;
});

const checksum = (bytes) => (bytes.reduce((sum, byte) => CRC[(sum ^ byte) & 0xff] ^ (sum >>> 8), 0xffffffff) ^ 0xffffffff) >>> 0;

/**
 * @param {Array<Array<string>>} files name and text of each; no two have one name
 * @returns {Blob} the archive
 */
export function zipped(files) {
  const encoder = new TextEncoder();
  const entries = [];
  const parts = [];
  let start = 0;
  for (const [title, text] of files) {
    const [name, data] = [title, text].map((each) => encoder.encode(each));
    // Fields that the record before a file and its entry in the list have in common.
    const common = [[VERSION, 2], [UTF8_NAMES, 2], [0, 2], [0, 2], [DATE, 2],
      [checksum(data), 4], [data.length, 4], [data.length, 4], [name.length, 2], [0, 2]];
    const local = record([[0x04034b50, 4], ...common]);
    entries.push(record([[0x02014b50, 4], [VERSION, 2], ...common, [0, 2], [0, 2], [0, 2], [0, 4], [start, 4]]), name);
    parts.push(local, name, data);
    start += local.length + name.length + data.length;
  }
  const length = entries.reduce((sum, part) => sum + part.length, 0);
  const end = record([[0x06054b50, 4], [0, 2], [0, 2], [files.length, 2], [files.length, 2], [length, 4], [start, 4], [0, 2]]);
  return new Blob([...parts, ...entries, end], { type: "application/zip" });
}

// Little-endian numbers, each with its count of bytes.
function record(fields) {
  const view = new DataView(new ArrayBuffer(fields.reduce((sum, [, size]) => sum + size, 0)));
  let at = 0;
  for (const [value, size] of fields) {
    if (size === 2) view.setUint16(at, value, true);
    else view.setUint32(at, value, true);
    at += size;
  }
  return new Uint8Array(view.buffer);
}
