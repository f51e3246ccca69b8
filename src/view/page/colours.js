// What a colour means. Kinds are in the colours of Okabe and Ito (2008), quantities from dark blue to yellow as viridis is: both are
// told apart by colour-blind people. Beyond eight kinds the same hues come again, lighter and darker.

const KINDS = [[230, 159, 0], [86, 180, 233], [0, 158, 115], [240, 228, 66], [0, 114, 178], [213, 94, 0], [204, 121, 167], [150, 150, 150]];
const SCALE = [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37]];
const PLAIN = [150, 155, 162];
// A feature has the same colour in every file.
const FEATURES = ['outer wall', 'inner wall', 'infill', 'bridge', 'solid infill', 'overhanging wall', 'support', 'gap', 'ironing', 'skirt and brim', 'not stated'];

function kind(i) {
  const hue = KINDS[i % KINDS.length], round = Math.floor(i / KINDS.length) % 3;
  return hue.map((v) => Math.round(round === 1 ? v * 0.62 : round === 2 ? v + (255 - v) * 0.5 : v));
}

/** The colour of a share from 0 to 1. */
function onScale(share) {
  const at = Math.min(1, Math.max(0, share)) * (SCALE.length - 1), i = Math.min(Math.floor(at), SCALE.length - 2);
  return SCALE[i].map((v, k) => Math.round(v + (SCALE[i + 1][k] - v) * (at - i)));
}

/** The ways to colour a program: kinds have `of` (a number) and `name`, quantities `value` and a unit. */
function colourModes(replay, facts) {
  const styles = replay.facts.styles, prints = replay.facts.prints;
  const style = (i) => styles[replay.style[i]] ?? [null, 'not stated', 0, 0, 0];
  const print = (i) => prints[style(i)[0]] ?? [-1, -1];
  const seconds = (i) => replay.end[i] - (i ? replay.end[i - 1] : 0);
  const way = (i) => (i ? Math.hypot(...replay.at.map((axis) => axis[i] - axis[i - 1])) / XYZ : 0);
  const stated = (v) => (v > 0 ? v : NaN);
  const per = (amount, i) => (seconds(i) > 0 ? amount / seconds(i) : NaN);
  const { rooms, surveyed_mm: most } = replay.facts, starts = rooms.map(([from]) => from);
  const room = (i) => {
    const [, to, mm] = rooms[above(starts, i) - 1] ?? [0, 0, NaN];
    return i < to ? mm : NaN;
  };
  return {
    part: { title: 'Part', of: (i) => print(i)[0], name: (k) => facts.parts[k]?.name ?? 'none' },
    slot: { title: 'Slot', of: (i) => print(i)[1], name: (k) => (k < 0 ? 'none' : `slot ${k}`) },
    feature: { title: 'Feature', of: (i) => FEATURES.indexOf(style(i)[1]), name: (k) => FEATURES[k] },
    speed: { title: 'Speed', unit: 'mm/s', value: (i) => per(way(i), i) },
    flow: { title: 'Filament', unit: 'mm/s of filament', value: (i) => per(replay.e[i] / FILAMENT, i) },
    height: { title: 'Layer height', unit: 'mm', value: (i) => stated(style(i)[3]) },
    temperature: { title: 'Nozzle', unit: 'deg C', value: (i) => stated(replay.places[replay.place[i]].nozzle_c) },
    ...(rooms.length ? { clearance: { title: 'Clearance', unit: `mm (lower bound) to everything it does not print on (${most}: that or more)`, value: room } } : {}),
  };
}

/** The colour of every laying move, as bytes of red, green, blue (the fourth is left alone), and the legend that goes with them. */
function paint(mode, replay, bytes) {
  return mode.value ? paintScale(mode, replay, bytes) : paintKinds(mode, replay, bytes);
}

function paintKinds(mode, replay, bytes) {
  const colours = new Map();
  for (let i = 0; i < replay.count; i++) {
    if (!(replay.flags[i] & FLAG.lays)) continue;
    const k = mode.of(i);
    let colour = colours.get(k);
    if (!colour) colours.set(k, (colour = k < 0 ? PLAIN : kind(k)));
    bytes.set(colour, i * 4);
  }
  const kinds = [...colours.keys()].sort((a, b) => a - b);
  return { title: mode.title, kinds: kinds.map((k) => ({ name: mode.name(k), colour: colours.get(k) })) };
}

function paintScale(mode, replay, bytes) {
  const values = new Float32Array(replay.count);
  let low = Infinity, high = -Infinity;
  for (let i = 0; i < replay.count; i++) {
    if (!(replay.flags[i] & FLAG.lays)) continue;
    const value = (values[i] = mode.value(i));
    if (value < low) low = value;
    if (value > high) high = value;
  }
  const steps = Array.from({ length: 256 }, (_, i) => onScale(i / 255)), range = high > low ? high - low : 1;
  for (let i = 0; i < replay.count; i++) {
    if (!(replay.flags[i] & FLAG.lays)) continue;
    bytes.set(values[i] === values[i] ? steps[Math.round(((values[i] - low) / range) * 255)] : PLAIN, i * 4);
  }
  return { title: mode.title, unit: mode.unit, low, high };
}
