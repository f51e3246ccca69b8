// Motions and projections. Matrices are 16 numbers, column by column, as WebGL takes them; points are three numbers.

const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

/** a b: first b, then a. */
function times(a, b) {
  const out = new Array(16);
  for (let column = 0; column < 16; column += 4) {
    for (let row = 0; row < 4; row++) {
      out[column + row] = a[row] * b[column] + a[row + 4] * b[column + 1] + a[row + 8] * b[column + 2] + a[row + 12] * b[column + 3];
    }
  }
  return out;
}

/** The matrix of a motion: nine numbers of the rotation row by row, then the translation. */
function ofMotion(m) {
  return [m[0], m[3], m[6], 0, m[1], m[4], m[7], 0, m[2], m[5], m[8], 0, m[9], m[10], m[11], 1];
}

/** The way back of a rigid motion. */
function inverted(m) {
  const back = (i) => -(m[i * 4] * m[12] + m[i * 4 + 1] * m[13] + m[i * 4 + 2] * m[14]);
  return [m[0], m[4], m[8], 0, m[1], m[5], m[9], 0, m[2], m[6], m[10], 0, back(0), back(1), back(2), 1];
}

/** Where a motion takes a point. */
function moved(m, [x, y, z]) {
  return [0, 1, 2].map((i) => m[i] * x + m[i + 4] * y + m[i + 8] * z + m[i + 12]);
}

/** Where a motion takes a direction. */
function turned(m, [x, y, z]) {
  return [0, 1, 2].map((i) => m[i] * x + m[i + 4] * y + m[i + 8] * z);
}

function shifted([x, y, z]) {
  return [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1];
}

const plus = (a, b, by = 1) => a.map((v, i) => v + b[i] * by);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const normal = (a) => plus([0, 0, 0], a, 1 / (Math.hypot(...a) || 1));

/** A perspective: `fov` (radians) from bottom to top. */
function perspective(fov, aspect, near, far) {
  const f = 1 / Math.tan(fov / 2), range = 1 / (near - far);
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (near + far) * range, -1, 0, 0, 2 * near * far * range, 0];
}

/** The right-handed turn by an angle (radians) about a unit vector, then a shift. */
function turnAbout([x, y, z], angle, shift) {
  const s = Math.sin(angle), c = Math.cos(angle), v = 1 - c;
  return [
    c + x * x * v, y * x * v + z * s, z * x * v - y * s, 0,
    x * y * v - z * s, c + y * y * v, z * y * v + x * s, 0,
    x * z * v + y * s, y * z * v - x * s, c + z * z * v, 0,
    ...shift, 1,
  ];
}

/** The table's motion at any two angles (radians), by the chain p = pivot + R_tilt(A) (offset + R_rotation(C) p_table). */
function tableAt(machine, tilt, rotation) {
  const turned = turnAbout(machine.rotation.along, rotation, machine.offset);
  return times(turnAbout(machine.tilt.along, tilt, machine.pivot), turned);
}

/** The right-handed turn by an angle (radians) about a unit vector through a point. */
function turnAround(along, angle, through) {
  return times(shifted(through), times(turnAbout(along, angle, [0, 0, 0]), shifted(plus([0, 0, 0], through, -1))));
}

/** Of a head that turns: the frame in which its axes do not, seen from the tip in the tool's frame. */
function unturned(machine, tilt, rotation) {
  const { yaws, tilt_from_tip: u, rotation_from_tip: v } = machine.swivel, lean = turnAround(machine.tilt.along, tilt, u);
  return yaws ? times(lean, turnAround(machine.rotation.along, rotation, v)) : lean;
}

/** Where X, Y and Z of such a machine stand, room. */
function linearAxes(machine, seen, tip) {
  const back = inverted(seen);
  return plus(plus(turned(back, tip), machine.swivel.table), moved(back, [0, 0, 0]), -1);
}

/** An orbit: looks at `target` from `distance` away, `yaw` about +Z and `pitch` above the horizon (radians). */
class Camera {
  constructor() {
    Object.assign(this, { target: [0, 0, 0], distance: 400, yaw: -0.9, pitch: 0.45, fov: 0.55 });
  }

  /** Towards the eye. */
  get back() {
    const c = Math.cos(this.pitch);
    return [c * Math.cos(this.yaw), c * Math.sin(this.yaw), Math.sin(this.pitch)];
  }

  get right() {
    return [-Math.sin(this.yaw), Math.cos(this.yaw), 0];
  }

  /** World to eye, and eye to clip space, for a picture of this shape. */
  matrices(aspect) {
    const back = this.back, right = this.right, up = cross(back, right);
    const eye = plus(this.target, back, this.distance);
    const to = (axis) => -dot(axis, eye);
    const view = [right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0, to(right), to(up), to(back), 1];
    const near = Math.max(this.distance / 200, 0.05);
    return { view, projection: perspective(this.fov, aspect, near, this.distance * 4 + 3000), eye };
  }

  /** Looks at a ball. */
  fit(centre, radius, aspect) {
    this.target = centre;
    this.distance = (radius * 1.08) / Math.sin((Math.min(1, aspect) * this.fov) / 2);
  }
}
