// Shaders and buffers of WebGL2, as little as two pictures need.
export function program(gl: WebGL2RenderingContext, vertex: string, fragment: string): WebGLProgram {
  const made = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]] as const) {
    const shader = gl.createShader(kind)!;
    gl.shaderSource(shader, `#version 300 es\nprecision highp float;\n${source}`);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made) ?? "the shader does not link");
  return made;
}

/** Low to high as in the report: night, plum, ember, gold. */
export const PALETTE = `
vec3 palette(float t) {
  t = clamp(t, 0., 1.);
  vec3 a = vec3(.16, .08, .42), b = vec3(.56, .14, .50), c = vec3(.90, .36, .36), d = vec3(.99, .80, .36);
  return t < .33 ? mix(a, b, t / .33) : t < .66 ? mix(b, c, (t - .33) / .33) : mix(c, d, (t - .66) / .34);
}`;

/** Floats that only grow, kept on the card of the graphics in pieces that double. */
export class Growing {
  readonly buffer: WebGLBuffer;
  private room = 4096;
  private data = new Float32Array(4096);
  private sent = 0;
  length = 0;
  private readonly gl: WebGL2RenderingContext;

  constructor(gl: WebGL2RenderingContext) {
    this.gl = gl;
    this.buffer = gl.createBuffer()!;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, this.room * 4, gl.DYNAMIC_DRAW);
  }

  push(...values: number[]): void {
    if (this.length + values.length > this.data.length) {
      const larger = new Float32Array(this.data.length * 2);
      larger.set(this.data);
      this.data = larger;
    }
    this.data.set(values, this.length);
    this.length += values.length;
  }
  clear(): void { this.length = 0; this.sent = 0; }

  /** Only what has come since the last picture goes to the card. */
  send(): void {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    if (this.data.length > this.room) {
      this.room = this.data.length;
      gl.bufferData(gl.ARRAY_BUFFER, this.room * 4, gl.DYNAMIC_DRAW);
      this.sent = 0;
    }
    if (this.sent < this.length) gl.bufferSubData(gl.ARRAY_BUFFER, this.sent * 4, this.data, this.sent, this.length - this.sent);
    this.sent = this.length;
  }
}

export function rgb(text: string): [number, number, number] {
  const found = /rgba?\(([\d.]+)[, ]+([\d.]+)[, ]+([\d.]+)/.exec(text);
  if (found) return [Number(found[1]) / 255, Number(found[2]) / 255, Number(found[3]) / 255];
  const share = /color\(srgb ([\d.]+) ([\d.]+) ([\d.]+)/.exec(text);
  return share ? [Number(share[1]), Number(share[2]), Number(share[3])] : [0.5, 0.5, 0.5];
}
