// What was laid, as it is drawn: bead i runs from point i to point i + 1 in the table's frame. Travels have no width and are not
// drawn as beads, so that a bead's number is its move's and "as printed so far" is a count.
//
// While something moves on the screen, few longer and higher beads stand for all (`few`): layers are left out, neighbours joined.

const SIDES = 4; // a bead is a diamond in cross-section, shaded as if it were round
const FEW = [10000, 3000]; // beads that software draws ten times a second, and what is drawn where it does not
const MOST_UPS = 64; // directions of building; what comes beyond is drawn as the last one
const JOINED_MM = 0.25; // a joined bead leaves its lines by less
const INSIDE = new Set(['infill', 'inner wall', 'gap']);

class Beads {
  constructor(replay) {
    const { count, flags } = replay;
    this.replay = replay;
    this.points = new Float32Array((count + 1) * 3);
    this.sizes = new Uint16Array(count * 2); // width and height, micrometres
    this.colours = new Uint8Array(count * 4); // red, green, blue, number of its up
    this.ups = [];
    this.box = { low: [Infinity, Infinity, Infinity], high: [-Infinity, -Infinity, -Infinity] };
    const upOf = replay.motions.map((motion) => (motion ? this.upNumber(turned(inverted(motion), [0, 0, 1])) : 0));
    for (let i = 0; i < count; i++) {
      const back = replay.backs[replay.place[i]], known = back && !(flags[i] & (FLAG.unknown | FLAG.fromUnknown));
      if (known) this.put(i, back);
      this.colours[i * 4 + 3] = upOf[replay.place[i]];
      if (known && flags[i] & FLAG.lays) this.size(i);
    }
    if (this.box.low[0] > this.box.high[0]) this.box = { low: [-50, -50, 0], high: [50, 50, 50] };
  }

  /** Directions of building are few; their number goes with the colour. */
  upNumber(up) {
    const known = this.ups.findIndex((other) => dot(up, other) > 1 - 1e-9);
    return known >= 0 ? known : Math.min(this.ups.push(up), MOST_UPS) - 1;
  }

  put(i, m) {
    const [x, y, z] = this.replay.at.map((axis) => axis[i] / XYZ), to = (i + 1) * 3;
    for (let k = 0; k < 3; k++) this.points[to + k] = m[k] * x + m[k + 4] * y + m[k + 8] * z + m[k + 12];
  }

  size(i) {
    const [, , width, stated] = this.replay.facts.styles[this.replay.style[i]];
    const height = stated > 0 ? stated : 0.2, p = this.points, at = i * 3;
    const length = Math.hypot(p[at + 3] - p[at], p[at + 4] - p[at + 1], p[at + 5] - p[at + 2]);
    // Where no width is stated: that of 1.75 mm filament pressed to a rectangle with round ends.
    const area = ((this.replay.e[i] / FILAMENT) * 2.405) / (length || 1);
    const mm = width > 0 ? width : Math.min(Math.max(area / height + height * 0.215, 0.1), 3);
    this.sizes[i * 2] = mm * 1000;
    this.sizes[i * 2 + 1] = height * 1000;
    for (let k = 0; k < 3; k++) {
      this.box.low[k] = Math.min(this.box.low[k], p[at + 3 + k]);
      this.box.high[k] = Math.max(this.box.high[k], p[at + 3 + k]);
    }
  }

  /** A set of `most` that stands for all: `of` says which move each ends with. */
  few(most) {
    const inside = this.replay.facts.styles.map((style) => INSIDE.has(style[1]));
    for (let step = 1; ;) {
      const { made, share } = this.fewOf(step, inside, most);
      if (share === 1) return made;
      // Too many after that share of the moves: so many times fewer layers.
      step = Math.max(step + 1, Math.ceil((step / share) * 0.9));
    }
  }

  /** Every `step`th layer's of each print (prints of one setup take turns); or how far it came before there were too many. */
  fewOf(step, inside, most) {
    const { flags, style, place, layers, count, facts } = this.replay, { points, sizes } = this, nth = new Map();
    const made = { from: [], to: [], size: [], of: [] };
    let layer = 0, open = -1, reach = 0;
    const close = (last) => {
      if (open >= 0) {
        made.from.push(open);
        made.to.push(last + 1);
        made.size.push(sizes[open * 2], Math.min(65535, sizes[open * 2 + 1] * step));
        made.of.push(last);
      }
      open = -1;
    };
    // Of a print the how manieth layer this is.
    const turnOf = (print) => {
      const own = nth.get(print) ?? { layer: -1, count: -1 };
      if (own.layer !== layer) nth.set(print, Object.assign(own, { layer, count: own.count + 1 }));
      return own.count;
    };
    for (let i = 0; i < count; i++) {
      while (layers[layer + 1] <= i) layer++;
      const laid = flags[i] & FLAG.lays && sizes[i * 2] && !inside[style[i]], lays = laid && turnOf(facts.styles[style[i]][0]) % step === 0;
      if (open >= 0 && (!lays || style[i] !== style[open] || place[i] !== place[open] || !this.straight(open, i, reach))) close(i - 1);
      if (lays && open < 0) [open, reach] = [i, 0];
      if (lays) reach = Math.max(reach, i - open);
      if (made.of.length > most && step < this.replay.layers.length) return { share: i / count };
    }
    close(count - 1);
    return { made: this.gathered(made, points), share: 1 };
  }

  /** Whether beads `open` to `i` run along one line, judged at the one in the middle and at the last corner. */
  straight(open, i, reach) {
    if (reach > 40) return false;
    const p = this.points, a = open * 3, c = (i + 1) * 3;
    const way = [p[c] - p[a], p[c + 1] - p[a + 1], p[c + 2] - p[a + 2]], length = Math.hypot(...way) || 1;
    for (const k of [i, (open + i + 1) >> 1]) {
      const to = [p[k * 3] - p[a], p[k * 3 + 1] - p[a + 1], p[k * 3 + 2] - p[a + 2]];
      if (Math.hypot(...cross(way, to)) / length > JOINED_MM || dot(way, to) < 0) return false;
    }
    return true;
  }

  /** Both ends of each beside each other. */
  gathered({ from, to, size, of }, points) {
    const ends = new Float32Array(from.length * 6);
    from.forEach((a, i) => ends.set(points.subarray(a * 3, a * 3 + 3), i * 6));
    to.forEach((b, i) => ends.set(points.subarray(b * 3, b * 3 + 3), i * 6 + 3));
    return { points: ends, sizes: Uint16Array.from(size), of: Uint32Array.from(of) };
  }

  /** Travels as pairs of points, table frame; a turn is the arc that the tip draws over the table. */
  travels() {
    const { count, flags, place, replay } = { ...this.replay, replay: this.replay };
    const points = [], of = [];
    for (let i = 0; i < count; i++) {
      if (flags[i] & (FLAG.unknown | FLAG.fromUnknown) || flags[i] & FLAG.lays) continue;
      const turns = flags[i] & FLAG.turns && replay.motions[place[i]] && i && replay.motions[place[i - 1]];
      const steps = turns ? 24 : 1;
      if (!turns && replay.at.every((axis) => i && axis[i] === axis[i - 1])) continue;
      let last = null;
      for (let k = 0; k <= steps; k++) {
        const frame = replay.frame(i, k / steps);
        const at = moved(inverted(frame.motion), frame.tip);
        if (last) {
          points.push(...last, ...at);
          of.push(i);
        }
        last = at;
      }
    }
    return { points: new Float32Array(points), of: Uint32Array.from(of) };
  }
}
