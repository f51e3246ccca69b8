// WebGL 2. Three programs: beads, solids, lines. While anything moves a quick picture is drawn (few beads); once all rests the whole
// one grows in a buffer beside it, piece by piece, so that the page stays answerable, and then takes its place.
//
// Beads are pulled out of textures by the number of their corner: drawn as instances each would cost software 17 microseconds, for
// it carries out instances one by one.

const PIECE = 96000; // beads drawn at once, at most
const ROW_OF = 4096; // texels in a row
const BEAD_SHADER = `#version 300 es
precision highp float; precision highp int; precision highp sampler2D; precision highp usampler2D;
uniform sampler2D points; uniform usampler2D sizes; uniform sampler2D colours;
uniform mat4 toEye; uniform mat4 toClip; uniform vec3 ups[${MOST_UPS}]; uniform int first; uniform int ends;
out vec3 shade; out vec3 tint;
ivec2 texel(int i) { return ivec2(i % ${ROW_OF}, i / ${ROW_OF}); }
void main() {
  int bead = first + gl_VertexID / ${SIDES * 2}, id = gl_VertexID % ${SIDES * 2}, side = id >> 1;
  vec2 size = vec2(texelFetch(sizes, texel(bead), 0).xy) * 1e-3;
  vec3 from = texelFetch(points, texel(bead * ends), 0).xyz, to = texelFetch(points, texel(bead * ends + 1), 0).xyz;
  vec4 colour = texelFetch(colours, texel(bead), 0);
  vec3 up = ups[int(colour.a * 255.0 + 0.5)], along = to - from;
  float way = length(along);
  if (size.x == 0.0 || way < 1e-6) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  along /= way;
  vec3 right = normalize(cross(along, up) + vec3(1e-9)), outward = side == 0 ? right : side == 1 ? up : side == 2 ? -right : -up;
  float reach = 0.5 * (side % 2 == 0 ? size.x : size.y), over = min(way, size.x) * 0.25;
  vec3 end = (id & 1) == 0 ? from - along * over : to + along * over;
  gl_Position = toClip * (toEye * vec4(end - up * size.y * 0.5 + outward * reach, 1.0));
  shade = mat3(toEye) * outward;
  tint = colour.rgb;
}`;
const SOLID_SHADER = `#version 300 es
in vec3 place; in vec3 normal;
uniform mat4 toEye; uniform mat4 toClip; uniform vec4 ink;
out vec3 shade; out vec3 tint;
void main() {
  gl_Position = toClip * (toEye * vec4(place, 1.0));
  shade = mat3(toEye) * normal;
  tint = ink.rgb;
}`;
const SHADED = `#version 300 es
precision mediump float;
in vec3 shade; in vec3 tint;
uniform float alpha;
out vec4 colour;
void main() {
  vec3 n = normalize(shade);
  float light = 0.5 + 0.44 * max(0.0, dot(n, vec3(0.35, 0.55, 0.76))) + 0.14 * max(0.0, dot(n, vec3(-0.8, 0.1, 0.55)));
  colour = vec4(tint * light * alpha, alpha);
}`;
const LINE_SHADER = `#version 300 es
in vec3 place;
uniform mat4 toEye; uniform mat4 toClip; uniform float lift;
void main() { gl_Position = toClip * (toEye * vec4(place, 1.0)); gl_Position.z -= lift * gl_Position.w; }`;
const FLAT = `#version 300 es
precision mediump float;
uniform vec4 ink;
out vec4 colour;
void main() { colour = vec4(ink.rgb * ink.a, ink.a); }`;

class Drawing {
  constructor(canvas) {
    const gl = canvas.getContext('webgl2', { antialias: false, alpha: true, preserveDrawingBuffer: true });
    if (!gl) throw new Error('this browser has no WebGL 2, so only the lists and the text are shown');
    Object.assign(this, { canvas, gl, whole: null });
    this.bead = this.program(BEAD_SHADER, SHADED, []);
    this.solid = this.program(SOLID_SHADER, SHADED, ['place', 'normal']);
    this.line = this.program(LINE_SHADER, FLAT, ['place']);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.polygonOffset(1, 1); // surfaces lie a little behind the lines on them
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    this.scratch = gl.createBuffer();
    this.corners = this.cornerOrder();
    const { program } = this.bead;
    gl.useProgram(program);
    ['points', 'sizes', 'colours'].forEach((name, unit) => gl.uniform1i(gl.getUniformLocation(program, name), unit));
    Object.assign(this.bead, { first: gl.getUniformLocation(program, 'first'), ends: gl.getUniformLocation(program, 'ends') });
  }

  /** Eight corners a bead, two triangles a side, for a piece of beads; the ends stay open. */
  cornerOrder() {
    const gl = this.gl, order = new Uint32Array(PIECE * SIDES * 6);
    for (let bead = 0, at = 0; bead < PIECE; bead++) {
      for (let side = 0; side < SIDES; side++) {
        const [a, b] = [bead * SIDES * 2 + side * 2, bead * SIDES * 2 + ((side + 1) % SIDES) * 2];
        order.set([a, a + 1, b, b, a + 1, b + 1], at);
        at += 6;
      }
    }
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, order, gl.STATIC_DRAW);
    return buffer;
  }

  /** A texture of `texels` (each so many numbers), filled row by row; `texture` where there is one already. */
  table(kind, data, texture = this.gl.createTexture()) {
    const gl = this.gl;
    const [inside, format, type, each] = {
      points: [gl.RGB32F, gl.RGB, gl.FLOAT, 3], sizes: [gl.RG16UI, gl.RG_INTEGER, gl.UNSIGNED_SHORT, 2], colours: [gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, 4],
    }[kind];
    const rows = Math.max(1, Math.ceil(data.length / each / ROW_OF)), padded = new data.constructor(rows * ROW_OF * each);
    padded.set(data);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, inside, ROW_OF, rows, 0, format, type, padded);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    return texture;
  }

  /** Beads as textures: `ends` is 1 where each begins at the end of the one before, 2 where it has two points of its own. */
  beadSet(points, sizes, colours, ends) {
    return { points: this.table('points', points), sizes: this.table('sizes', sizes), colours: this.table('colours', colours), ends };
  }

  program(vertex, fragment, names) {
    const gl = this.gl, program = gl.createProgram();
    [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]].forEach(([kind, source]) => {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    });
    names.forEach((name, i) => gl.bindAttribLocation(program, i, name));
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    const at = (name) => gl.getUniformLocation(program, name);
    return { program, toEye: at('toEye'), toClip: at('toClip'), ups: at('ups'), ink: at('ink'), alpha: at('alpha'), lift: at('lift') };
  }

  buffer(data) {
    const gl = this.gl, buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    return buffer;
  }

  refill(buffer, data) {
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, buffer);
    this.gl.bufferData(this.gl.ARRAY_BUFFER, data, this.gl.DYNAMIC_DRAW);
  }

  /** Attribute `at`: three numbers a corner, from byte `offset` on. */
  attribute(at, buffer, stride, offset) {
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, 3, gl.FLOAT, false, stride, offset);
  }

  /** No attributes but the first so many. */
  bare(count) {
    for (let i = count; i < 2; i++) this.gl.disableVertexAttribArray(i);
  }

  /** Takes the picture's size from the page's; true where it changed. */
  resize() {
    const scale = Math.min(window.devicePixelRatio || 1, 2);
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight].map((v) => Math.max(1, Math.round(v * scale)));
    if (this.canvas.width === width && this.canvas.height === height) return false;
    Object.assign(this.canvas, { width, height });
    return true;
  }

  begin(back) {
    const gl = this.gl;
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.disable(gl.BLEND);
    gl.depthMask(true);
    gl.clearColor(...back, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  use(program, eye) {
    const gl = this.gl;
    gl.useProgram(program.program);
    gl.uniformMatrix4fv(program.toEye, false, eye.toEye);
    gl.uniformMatrix4fv(program.toClip, false, eye.toClip);
  }

  /** Beads `first` to `last` of a set. */
  beads(set, first, last, ups, eye) {
    const gl = this.gl;
    if (last <= first) return;
    this.use(this.bead, eye);
    const flat = new Float32Array(MOST_UPS * 3);
    ups.slice(0, MOST_UPS).forEach((up, i) => flat.set(up, i * 3));
    gl.uniform3fv(this.bead.ups, flat);
    gl.uniform1f(this.bead.alpha, 1);
    gl.uniform1i(this.bead.ends, set.ends);
    gl.enable(gl.CULL_FACE);
    this.bare(0);
    [set.points, set.sizes, set.colours].forEach((texture, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
    });
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.corners);
    for (; first < last; first += PIECE) {
      gl.uniform1i(this.bead.first, first);
      gl.drawElements(gl.TRIANGLES, Math.min(PIECE, last - first) * SIDES * 6, gl.UNSIGNED_INT, 0);
    }
    gl.activeTexture(gl.TEXTURE0);
    gl.disable(gl.CULL_FACE);
  }

  /** Triangles with normals, 24 bytes a corner; see-through below an `alpha` of 1. */
  solids(buffer, count, ink, alpha, eye) {
    const gl = this.gl;
    this.use(this.solid, eye);
    gl.uniform4f(this.solid.ink, ...ink.map((v) => v / 255), 1);
    gl.uniform1f(this.solid.alpha, alpha);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    this.bare(2);
    this.attribute(0, buffer, 24, 0);
    this.attribute(1, buffer, 24, 12);
    if (alpha < 1) {
      gl.enable(gl.BLEND);
      gl.depthMask(false);
      gl.enable(gl.CULL_FACE);
    }
    gl.drawArrays(gl.TRIANGLES, 0, count);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.disable(gl.BLEND);
    gl.depthMask(true);
    gl.disable(gl.CULL_FACE);
  }

  /** `count` ends of lines, from `first` on, a little nearer to the eye (`lift`) than they are. */
  lines(buffer, count, ink, alpha, eye, lift = 2e-6, first = 0) {
    const gl = this.gl;
    if (count <= 0) return;
    this.use(this.line, eye);
    gl.uniform4f(this.line.ink, ...ink.map((v) => v / 255), alpha);
    gl.uniform1f(this.line.lift, lift);
    this.bare(1);
    this.attribute(0, buffer, 12, 0);
    gl.enable(gl.BLEND);
    gl.drawArrays(gl.LINES, first, count);
    gl.disable(gl.BLEND);
  }

  /** Lines of the moment. */
  loose(points, ink, alpha, eye, lift) {
    this.refill(this.scratch, new Float32Array(points));
    this.lines(this.scratch, points.length / 3, ink, alpha, eye, lift);
  }

  /** The buffer in which the whole picture grows, smoothed where the driver can. */
  beside() {
    const gl = this.gl, { width, height } = this.canvas;
    if (this.whole?.width === width && this.whole.height === height) return this.whole.frame;
    if (this.whole) {
      gl.deleteFramebuffer(this.whole.frame);
      this.whole.stores.forEach((store) => gl.deleteRenderbuffer(store));
    }
    const frame = gl.createFramebuffer(), samples = Math.min(4, gl.getParameter(gl.MAX_SAMPLES));
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    const stores = [[gl.COLOR_ATTACHMENT0, gl.RGBA8], [gl.DEPTH_ATTACHMENT, gl.DEPTH_COMPONENT24]].map(([part, kind]) => {
      const store = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, store);
      gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, kind, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, part, gl.RENDERBUFFER, store);
      return store;
    });
    this.whole = { frame, stores, width, height };
    return frame;
  }

  /** What is drawn next goes to the buffer beside (true) or to the screen. */
  aim(beside) {
    this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, beside ? this.beside() : null);
  }

  /** The buffer beside becomes the picture. */
  show() {
    const gl = this.gl, { frame, width, height } = this.whole;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, frame);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  /** When all that was asked for is drawn; the page stays answerable meanwhile. */
  drawn() {
    const gl = this.gl, fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    return new Promise((resolve) => {
      const look = () => {
        if (!gl.isContextLost() && gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) return setTimeout(look, 2);
        gl.deleteSync(fence);
        return resolve();
      };
      look();
    });
  }
}
