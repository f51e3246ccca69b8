// Where everything is at any moment: between the ends of a move, along a straight line. Times in seconds, lengths in millimetres.

/** The first index whose value is above `wanted`, in an ascending list. */
function above(list, wanted, count = list.length) {
  let low = 0, high = count;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (list[middle] > wanted) high = middle;
    else low = middle + 1;
  }
  return low;
}

class Replay {
  constructor(program, machine) {
    Object.assign(this, program);
    this.machine = machine;
    this.places = program.facts.places;
    this.motions = this.places.map((place) => place.motion && ofMotion(place.motion));
    this.backs = this.motions.map((motion) => motion && inverted(motion));
    this.seconds = this.count ? this.end[this.count - 1] : 0;
    this.readRuns();
  }

  /** Runs of lines: where each begins, in lines and in kept lines, and whether it is written anew. */
  readRuns() {
    const reader = new Reader(this.runs);
    this.run = { line: [], kept: [], anew: [] };
    for (let line = 1, kept = 0, anew = true; !reader.done; anew = !anew) {
      const length = reader.unsigned();
      if (length) {
        this.run.line.push(line);
        this.run.kept.push(kept);
        this.run.anew.push(anew);
      }
      line += length;
      kept += anew ? 0 : length;
    }
    this.starts = [0];
    for (let i = 0; i < this.kept.length; i++) if (this.kept[i] === 10) this.starts.push(i + 1);
  }

  /** Line `number` of the file (from 1), or null where the page does not hold it. */
  text(number) {
    if (!this.facts.has_text || number < 1 || number > this.facts.lines) return null;
    const run = above(this.run.line, number) - 1;
    if (this.run.anew[run]) return this.spelt(above(this.line, number) - 1);
    const kept = this.run.kept[run] + number - this.run.line[run];
    return new TextDecoder().decode(this.kept.subarray(this.starts[kept], this.starts[kept + 1] - 1));
  }

  /** A move as its line says it. */
  spelt(i) {
    const digits = (units, decimals) => {
      const text = String(Math.abs(units)).padStart(decimals + 1, '0');
      const fraction = text.slice(-decimals).replace(/0+$/, '');
      return (units < 0 ? '-' : '') + text.slice(0, -decimals) + (fraction && '.' + fraction);
    };
    let out = 'G1';
    'XYZ'.split('').forEach((letter, axis) => {
      const to = this.at[axis][i], from = i ? this.at[axis][i - 1] : 0;
      if (to !== from) out += ` ${letter}${digits(to, 3)}`;
    });
    if (this.e[i]) out += ` ${this.facts.extruder}${digits(this.e[i], 5)}`;
    const feed = this.feed[i];
    if (feed !== (i ? this.feed[i - 1] : 0)) out += ` F${digits(Math.round(this.facts.feeds[feed] * 1000), 3)}`;
    return out;
  }

  /** The move under way at `time`, and how much of it is done. */
  whenAt(time) {
    const move = Math.min(above(this.end, time), this.count - 1);
    const from = move ? this.end[move - 1] : 0, took = this.end[move] - from;
    return { move, share: took > 0 ? Math.min(1, Math.max(0, (time - from) / took)) : 1 };
  }

  timeOf(move, share) {
    const from = move ? this.end[move - 1] : 0;
    return from + (this.end[move] - from) * share;
  }

  /** The move on line `number`, or the last one before it. */
  moveOfLine(number) {
    return Math.max(0, above(this.line, number) - 1);
  }

  /** The layer (from 0) that move `i` belongs to. */
  layerOf(i) {
    return Math.max(0, above(this.layers, i) - 1);
  }

  /** The end of move `i` in the machine's frame; an unknown coordinate is null. */
  tipAfter(i) {
    return this.at.map((axis, k) => (this.flags[i] & (1 << k) ? null : axis[i] / XYZ));
  }

  tipBefore(i) {
    return this.at.map((axis, k) => (!i || this.flags[i] & (8 << k) ? null : axis[i - 1] / XYZ));
  }

  /** Tip, angles (radians) and the table's motion with `share` of move `i` done; what the file has not said yet is null. */
  frame(i, share) {
    const from = this.tipBefore(i), to = this.tipAfter(i);
    const between = (a, b) => (b === null ? null : a === null ? b : a + (b - a) * share);
    const tip = to.map((end, axis) => between(from[axis], end));
    const place = this.places[this.place[i]], before = i ? this.places[this.place[i - 1]] : place;
    const tilt = between(before.tilt, place.tilt), rotation = between(before.rotation, place.rotation);
    const turns = before.tilt !== place.tilt || before.rotation !== place.rotation;
    const known = tilt !== null && rotation !== null;
    const motion = turns || !known ? tableAt(this.machine, tilt ?? 0, rotation ?? 0) : this.motions[this.place[i]];
    if (turns && known && this.machine.swivel && this.motions[this.place[i - 1]] && ![...from, ...to].includes(null)) {
      // Its head turns: what goes evenly is the tip over the table.
      const [a, b] = [[i - 1, from], [i, to]].map(([k, end]) => moved(this.backs[this.place[k]], end));
      return { tip: moved(motion, a.map((v, k) => v + (b[k] - v) * share)), tilt, rotation, known, motion, place };
    }
    return { tip, tilt, rotation, known, motion, place };
  }
}
