// A mesh of the bed in 3D: its heights exaggerated, coloured from low to high, over a grid.
import { Orbit } from "./orbit";
import { PALETTE, program, rgb } from "./program";

const VERTEX = `
layout(location=0) in vec4 a; uniform mat4 m; out vec3 place; out float part;
void main() { gl_Position = m * vec4(a.xyz, 1.); place = a.xyz; part = a.w; }`;
const FRAGMENT = `
in vec3 place; in float part; out vec4 o; uniform vec4 shade;
${PALETTE}
void main() {
  if (shade.a > 0.) { o = shade; return; }
  vec3 n = normalize(cross(dFdx(place), dFdy(place)));
  o = vec4(palette(part) * (.72 + .34 * abs(dot(n, normalize(vec3(-.4, -.5, .8))))), 1.);
}`;

export interface Mesh { heights: number[][]; minimum: number[]; maximum: number[] }
const FINER = 4;

/** A height between the points of a mesh. */
function between(heights: number[][], u: number, v: number): number {
  const [x, y] = [Math.min(Math.floor(u), heights[0]!.length - 2), Math.min(Math.floor(v), heights.length - 2)];
  const [fx, fy] = [u - x, v - y];
  const at = (row: number, column: number) => heights[row]?.[column] ?? 0;
  return (at(y, x) * (1 - fx) + at(y, x + 1) * fx) * (1 - fy) + (at(y + 1, x) * (1 - fx) + at(y + 1, x + 1) * fx) * fy;
}

export class Surface {
  readonly orbit: Orbit;
  private readonly gl: WebGL2RenderingContext;
  private readonly canvas: HTMLCanvasElement;
  private readonly paintProgram: WebGLProgram;
  private readonly faces: WebGLBuffer;
  private readonly wires: WebGLBuffer;
  private faceCount = 0;
  private wireCount = 0;
  private shade: [number, number, number] = [0.6, 0.6, 0.6];
  private asked = 0;
  private readonly watcher: ResizeObserver;

  static on(canvas: HTMLCanvasElement): Surface | null {
    const gl = canvas.getContext("webgl2", { antialias: true, premultipliedAlpha: false });
    return gl ? new Surface(canvas, gl) : null;
  }
  private constructor(canvas: HTMLCanvasElement, gl: WebGL2RenderingContext) {
    this.canvas = canvas;
    this.gl = gl;
    this.paintProgram = program(gl, VERTEX, FRAGMENT);
    this.faces = gl.createBuffer()!;
    this.wires = gl.createBuffer()!;
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
  paint(grid: string): void { this.shade = rgb(grid); this.ask(); }

  show({ heights, minimum, maximum }: Mesh, times: number): void {
    const { gl } = this;
    const all = heights.flat();
    const [low, high] = [Math.min(...all), Math.max(...all)];
    const [x0 = 0, y0 = 0] = minimum;
    const [x1 = 200, y1 = 200] = maximum;
    const middle = (low + high) / 2;
    const [nx, ny] = [(heights[0]!.length - 1) * FINER, (heights.length - 1) * FINER];
    const point = (i: number, j: number) => {
      const z = between(heights, i / FINER, j / FINER);
      return [x0 + (x1 - x0) * i / nx, y0 + (y1 - y0) * j / ny, (z - middle) * times, (z - low) / Math.max(1e-6, high - low)];
    };
    const faces: number[] = [];
    const wires: number[] = [];
    for (let j = 0; j < ny; j++) for (let i = 0; i < nx; i++) faces.push(...point(i, j), ...point(i + 1, j), ...point(i, j + 1), ...point(i + 1, j), ...point(i + 1, j + 1), ...point(i, j + 1));
    const floor = (low - middle) * times - 12;
    for (let k = 0; k <= 10; k++) {
      const [x, y] = [x0 + (x1 - x0) * k / 10, y0 + (y1 - y0) * k / 10];
      wires.push(x, y0, floor, 0, x, y1, floor, 0, x0, y, floor, 0, x1, y, floor, 0);
    }
    this.faceCount = faces.length / 4;
    this.wireCount = wires.length / 4;
    for (const [buffer, values] of [[this.faces, faces], [this.wires, wires]] as const) {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(values), gl.STATIC_DRAW);
    }
    this.orbit.target = [(x0 + x1) / 2, (y0 + y1) / 2, (floor + (high - middle) * times) / 2];
    const wide = this.canvas.clientWidth / Math.max(1, this.canvas.clientHeight);
    if (!this.orbit.isTouched) this.orbit.distance = Math.hypot(x1 - x0, y1 - y0, (high - low) * times) * (wide > 1 ? 1.5 : 1.8);
    this.ask();
  }

  private ask(): void { this.asked ||= requestAnimationFrame(() => { this.asked = 0; this.draw(); }); }

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
    gl.useProgram(this.paintProgram);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.paintProgram, "m"), false, this.orbit.matrix(w / h));
    const shade = gl.getUniformLocation(this.paintProgram, "shade");
    for (const [buffer, count, how, alpha] of [[this.wires, this.wireCount, gl.LINES, 1], [this.faces, this.faceCount, gl.TRIANGLES, 0]] as const) {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 4, gl.FLOAT, false, 16, 0);
      gl.uniform4f(shade, ...this.shade, alpha);
      gl.drawArrays(how, 0, count);
    }
  }
}
