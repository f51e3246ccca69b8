// Bytes of the page to columns: base64, raw deflate, sections behind their lengths, LEB128 numbers. Nothing here draws.
//
// What the sections are, in which units, and what is left out because it follows from the rest, is said where they are written:
// the sources of `view` (pack, program, text, shapes).

const XYZ = 1e3; // units of a coordinate in a millimetre
const FILAMENT = 1e5; // units of filament in a millimetre
const FLAG = { unknown: 7, fromUnknown: 56, lays: 64, turns: 128 };

/** The bytes of base64 text; white space may stand around it. */
function fromBase64(text) {
  const letters = 'ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/';
  const values = new Uint8Array(128);
  for (let i = 0; i < 64; i++) values[letters.charCodeAt(i)] = i;
  text = text.trim();
  const pads = text.endsWith('==') ? 2 : text.endsWith('=') ? 1 : 0;
  const out = new Uint8Array((text.length / 4) * 3 - pads);
  for (let i = 0, at = 0; at < out.length; i += 4) {
    const bits = (values[text.charCodeAt(i)] << 18) | (values[text.charCodeAt(i + 1)] << 12)
      | (values[text.charCodeAt(i + 2)] << 6) | values[text.charCodeAt(i + 3)];
    out[at++] = bits >> 16;
    if (at < out.length) out[at++] = bits >> 8;
    if (at < out.length) out[at++] = bits;
  }
  return out;
}

/** The sections of the block. */
async function unpack(text) {
  const stream = new Blob([fromBase64(text)]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const view = new DataView(bytes.buffer);
  const sections = [];
  for (let at = 0; at < bytes.length;) {
    const length = view.getUint32(at, true);
    sections.push(bytes.subarray(at + 4, at + 4 + length));
    at += 4 + length;
  }
  return sections;
}

/** Reads one number after the other out of a section. */
class Reader {
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }

  get done() {
    return this.at >= this.bytes.length;
  }

  unsigned() {
    let value = 0, scale = 1;
    for (;;) {
      const byte = this.bytes[this.at++];
      value += (byte & 127) * scale;
      if (byte < 128) return value;
      scale *= 128;
    }
  }

  signed() {
    const value = this.unsigned();
    return value % 2 ? -(value + 1) / 2 : value / 2;
  }

  /** Four bytes, the lowest first, as a single-precision number. */
  single() {
    const view = new DataView(this.bytes.buffer, this.bytes.byteOffset + this.at, 4);
    this.at += 4;
    return view.getFloat32(0, true);
  }
}

/** Differences to running sums, into an array of `type`. */
function sums(bytes, count, type, signed) {
  const reader = new Reader(bytes), out = new type(count);
  for (let i = 0, last = 0; i < count; i++) {
    last += signed ? reader.signed() : reader.unsigned();
    out[i] = last;
  }
  return out;
}

/** The parts' corners (mm) and facets. */
function readShapes(parts, [vertices, facets]) {
  const corners = new Reader(vertices), indices = new Reader(facets);
  return parts.map((part) => {
    const points = new Float32Array(part.vertices * 3), faces = new Uint32Array(part.facets * 3);
    const last = [0, 0, 0];
    for (let i = 0; i < points.length; i++) points[i] = (last[i % 3] += corners.signed()) / XYZ;
    for (let i = 0, index = 0; i < faces.length; i++) faces[i] = index += indices.signed();
    return { points, faces };
  });
}

/** The smallest array that holds the numbers of a table's rows. */
const numbersOf = (table) => (table.length < 256 ? Uint8Array : table.length < 65536 ? Uint16Array : Uint32Array);

/** The program's columns; `end` is the time (s) at which each move ends. */
function readProgram(facts, sections) {
  const count = facts.moves;
  const [line, x, y, z, e, feed, style, place, flags, times, layers, runs, kept] = sections;
  const program = {
    count, facts, kept, runs,
    line: sums(line, count, Uint32Array, false),
    at: [x, y, z].map((column) => sums(column, count, Int32Array, true)),
    feed: sums(feed, count, numbersOf(facts.feeds), true),
    style: sums(style, count, numbersOf(facts.styles), true),
    place: sums(place, count, numbersOf(facts.places), true),
    flags, e: new Int32Array(count), end: new Float64Array(count), layers: [],
  };
  const starts = new Reader(layers);
  for (let at = 0; !starts.done;) program.layers.push(at += starts.unsigned());
  fillRest(program, new Reader(e), new Reader(times));
  return program;
}

/** Filament and time: expected from way, style and feed, and what differs from that. */
function fillRest(program, filament, times) {
  const { count, at: [x, y, z], flags, facts, e, end } = program;
  let listed = times.done ? Infinity : times.unsigned(), total = 0;
  for (let i = 0; i < count; i++) {
    const j = i - 1;
    const dx = i ? x[i] - x[j] : x[0], dy = i ? y[i] - y[j] : y[0], dz = i ? z[i] - z[j] : z[0];
    const length = Math.sqrt(dx * dx + dy * dy + dz * dz);
    const lays = flags[i] & FLAG.lays;
    e[i] = filament.signed() + (lays ? Math.floor(length * facts.styles[program.style[i]][4] + 0.5) : 0);
    if (i === listed) {
      total += times.single();
      listed = times.done ? Infinity : i + times.unsigned();
    } else {
      const way = length > 0 ? length / XYZ : Math.abs(e[i]) / FILAMENT, feed = facts.feeds[program.feed[i]];
      if (feed > 0) total += (way / feed) * 60;
    }
    end[i] = total;
  }
}
