// The path as it is executed, in 3D: bed, tool and every segment, drawn only when something has changed.
import { Orbit, type Vec3 } from "./orbit";
import { Growing, PALETTE, program, rgb } from "./program";

const SEGMENT = `
layout(location=0) in vec4 a; layout(location=1) in vec4 b;
uniform mat4 m; uniform vec2 size; uniform float width, low, high, count; uniform vec3 accent;
out vec4 tint;
${PALETTE}
void main() {
  vec4 p = m * vec4(a.xyz, 1.), q = m * vec4(b.xyz, 1.);
  vec2 dir = normalize((q.xy / q.w - p.xy / p.w) * size + vec2(1e-6, 0.));
  float end = float(gl_VertexID & 1), side = float(gl_VertexID >> 1) * 2. - 1.;
  vec4 at = mix(p, q, end);
  float w = b.w > .5 ? width : width * .5;
  at.xy += (vec2(-dir.y, dir.x) * side + dir * (end * 2. - 1.) * .5) * w / size * at.w;
  gl_Position = at;
  vec3 along = normalize(b.xyz - a.xyz + vec3(1e-6));
  float light = .62 + .38 * abs(dot(normalize(cross(along, vec3(0., 0., 1.)) + vec3(1e-5)), normalize(vec3(.5, -.8, .3))));
  vec3 c = palette((b.z - low) / max(.2, high - low)) * light;
  float fresh = clamp(1. - (count - float(gl_InstanceID)) / 160., 0., 1.);
  c = mix(c, accent, fresh * .85);
  tint = b.w > .5 ? vec4(c, 1.) : vec4(.55, .52, .62, .16 + .3 * fresh);
  if (b.w < 0.) gl_Position = vec4(2., 2., 2., 1.);
}`;
const PLAIN = `
layout(location=0) in vec3 a; uniform mat4 m; uniform vec4 shade; out vec4 tint;
void main() { gl_Position = m * vec4(a, 1.); tint = shade; }`;
const PAINT = "in vec4 tint; out vec4 o; void main() { o = tint; }";

/** How wide a line is drawn, as what a nozzle of 0.4 mm lays. */
const WIDTH_MM = 0.45;

export interface Box { minimum: number[]; maximum: number[] }

export class Stage {
  readonly orbit: Orbit;
  private readonly gl: WebGL2RenderingContext;
  private readonly canvas: HTMLCanvasElement;
  private readonly segments: Growing;
  private readonly grid: Growing;
  private readonly tool: Growing;
  private readonly lines: WebGLProgram;
  private readonly plain: WebGLProgram;
  private readonly places = new Map<string, WebGLUniformLocation | null>();
  private range: [number, number] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
  private low: Vec3 = [Infinity, Infinity, Infinity];
  private high: Vec3 = [-Infinity, -Infinity, -Infinity];
  /** Whether the newest moves have the colour of the state. */
  hasTail = true;
  private share = 1;
  private framed = 0;
  private asked = 0;
  private colours: { grid: Vec3; accent: Vec3; ink: Vec3 } = { grid: [0.8, 0.8, 0.8], accent: [0.5, 0.1, 0.4], ink: [0, 0, 0] };
  private readonly watcher: ResizeObserver;

  /** Nothing where the browser has no WebGL2. */
  static on(canvas: HTMLCanvasElement): Stage | null {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, premultipliedAlpha: false });
    return gl ? new Stage(canvas, gl) : null;
  }

  private constructor(canvas: HTMLCanvasElement, gl: WebGL2RenderingContext) {
    this.canvas = canvas;
    this.gl = gl;
    this.lines = program(gl, SEGMENT, PAINT);
    this.plain = program(gl, PLAIN, PAINT);
    this.segments = new Growing(gl);
    this.grid = new Growing(gl);
    this.tool = new Growing(gl);
    this.orbit = new Orbit(canvas);
    this.orbit.changed = () => this.ask();
    this.watcher = new ResizeObserver(() => this.ask());
    this.watcher.observe(canvas);
  }

  end(): void {
    this.watcher.disconnect();
    cancelAnimationFrame(this.asked);
    this.gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  paint(grid: string, accent: string, ink: string): void {
    this.colours = { grid: rgb(grid), accent: rgb(accent), ink: rgb(ink) };
    this.ask();
  }

  /** The travel of the machine: a grid on its floor and the corners of its room. */
  bed({ minimum, maximum }: Box): void {
    this.grid.clear();
    const [x0 = 0, y0 = 0, z0 = 0] = minimum;
    const [x1 = 200, y1 = 200, z1 = 0] = maximum;
    const floor = Math.min(z0, 0);
    const step = Math.max(x1 - x0, y1 - y0) > 500 ? 50 : 20;
    for (let x = x0; x <= x1 + 0.01; x += step) this.grid.push(x, y0, floor, x, y1, floor);
    for (let y = y0; y <= y1 + 0.01; y += step) this.grid.push(x0, y, floor, x1, y, floor);
    this.grid.push(x1, y0, floor, x1, y1, floor, x0, y1, floor, x1, y1, floor);
    for (const [x, y] of [[x0, y0], [x1, y0], [x0, y1], [x1, y1]] as const) this.grid.push(x, y, floor, x, y, Math.min(z1, floor + 40));
    if (!this.segments.length) this.frame([x0, y0, floor], [x1, y1, floor + 20]);
    this.ask();
  }

  private frame(low: Vec3, high: Vec3): void {
    this.orbit.target = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2];
    this.orbit.distance = Math.max(25, Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]) * 1.42);
    this.framed = Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
  }

  /** Follows a part that grows, until somebody has turned the picture as they like it. */
  follow(): void {
    const size = Math.hypot(...this.low.map((value, axis) => this.high[axis]! - value));
    if (!this.orbit.isTouched && Number.isFinite(size) && (size > this.framed * 1.08 || this.framed > size * 3)) this.fit();
  }

  /** Brings the part into view, or the bed where there is none yet. */
  fit(): void {
    if (this.high[0] > this.low[0]) this.frame([...this.low], [...this.high]);
    this.ask();
  }

  clear(): void {
    this.segments.clear();
    this.range = [Infinity, -Infinity];
    this.low = [Infinity, Infinity, Infinity];
    this.high = [-Infinity, -Infinity, -Infinity];
    this.ask();
  }

  /** Points x, y, z and whether the move that ends there cuts or lays material (1), goes through the air (0), or is unknown (-1). */
  add(points: number[][]): void {
    for (const [x = 0, y = 0, z = 0, kind = 1] of points) {
      this.segments.push(x, y, z, this.segments.length ? kind : -1);
      if (kind <= 0) continue;
      this.range = [Math.min(this.range[0], z), Math.max(this.range[1], z)];
      [x, y, z].forEach((value, axis) => {
        this.low[axis] = Math.min(this.low[axis]!, value);
        this.high[axis] = Math.max(this.high[axis]!, value);
      });
    }
    if (points.length) this.ask();
  }
  /** Shows only the first part of what is there. */
  upTo(share: number): void { this.share = share; this.ask(); }
  get points(): number { return this.segments.length / 4; }

  toolAt([x = 0, y = 0, z = 0]: number[]): void {
    const r = this.orbit.distance / 60;
    this.tool.clear();
    for (let at = 0; at < 12; at++) {
      const [p, q] = [(at / 12) * 2 * Math.PI, ((at + 1) / 12) * 2 * Math.PI];
      const h = z + r * 2.6;
      this.tool.push(x, y, z, x + r * Math.cos(p), y + r * Math.sin(p), h, x + r * Math.cos(q), y + r * Math.sin(q), h);
      this.tool.push(x, y, h, x + r * Math.cos(p), y + r * Math.sin(p), h, x + r * Math.cos(q), y + r * Math.sin(q), h);
    }
    this.ask();
  }

  private ask(): void {
    this.asked ||= requestAnimationFrame(() => { this.asked = 0; this.draw(); });
  }

  private place(of: WebGLProgram, name: string): WebGLUniformLocation | null {
    const key = `${of === this.lines ? "l" : "p"}${name}`;
    if (!this.places.has(key)) this.places.set(key, this.gl.getUniformLocation(of, name));
    return this.places.get(key) ?? null;
  }

  private draw(): void {
    const { gl, canvas } = this;
    const scale = Math.min(2, devicePixelRatio);
    const [w, h] = [Math.round(canvas.clientWidth * scale), Math.round(canvas.clientHeight * scale)];
    if (!w || !h || gl.isContextLost()) return;
    if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
    gl.viewport(0, 0, w, h);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    const m = this.orbit.matrix(w / h);
    this.drawPlain(m, this.grid, gl.LINES, this.colours.grid);
    this.drawSegments(m, w, h, scale);
    this.drawPlain(m, this.tool, gl.TRIANGLES, this.colours.accent);
  }

  private drawPlain(m: Float32Array, what: Growing, how: number, shade: Vec3): void {
    const { gl } = this;
    what.send();
    gl.useProgram(this.plain);
    gl.uniformMatrix4fv(this.place(this.plain, "m"), false, m);
    gl.uniform4f(this.place(this.plain, "shade"), ...shade, how === gl.LINES ? 0.55 : 1);
    gl.bindBuffer(gl.ARRAY_BUFFER, what.buffer);
    gl.enableVertexAttribArray(0);
    gl.disableVertexAttribArray(1);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 12, 0);
    gl.vertexAttribDivisor(0, 0);
    gl.drawArrays(how, 0, what.length / 3);
  }

  /** One instance a segment: both ends are read from the same buffer, a point apart. */
  private drawSegments(m: Float32Array, w: number, h: number, scale: number): void {
    const { gl, lines } = this;
    const count = Math.round((this.segments.length / 4 - 1) * this.share);
    if (count < 1) return;
    this.segments.send();
    gl.useProgram(lines);
    gl.uniformMatrix4fv(this.place(lines, "m"), false, m);
    gl.uniform2f(this.place(lines, "size"), w, h);
    gl.uniform1f(this.place(lines, "width"), Math.max(1.4 * scale, (WIDTH_MM * h) / (2 * Math.tan(0.35) * this.orbit.distance)));
    gl.uniform1f(this.place(lines, "low"), this.range[0]);
    gl.uniform1f(this.place(lines, "high"), this.range[1]);
    gl.uniform1f(this.place(lines, "count"), this.hasTail ? count : 1e9);
    gl.uniform3fv(this.place(lines, "accent"), this.colours.accent);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.segments.buffer);
    for (const index of [0, 1]) {
      gl.enableVertexAttribArray(index);
      gl.vertexAttribPointer(index, 4, gl.FLOAT, false, 16, index * 16);
      gl.vertexAttribDivisor(index, 1);
    }
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
  }
}
