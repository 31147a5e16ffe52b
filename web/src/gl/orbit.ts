// A camera that turns about a point: drag to turn, shift or two fingers to shift, wheel or pinch to come near.
export type Vec3 = [number, number, number];
export type Mat4 = Float32Array;

export function multiply(a: Mat4, b: Mat4): Mat4 {
  const out = new Float32Array(16);
  for (let column = 0; column < 4; column++) {
    for (let row = 0; row < 4; row++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += a[k * 4 + row]! * b[column * 4 + k]!;
      out[column * 4 + row] = sum;
    }
  }
  return out;
}

export class Orbit {
  target: Vec3 = [0, 0, 0];
  distance = 300;
  turn = -0.7;
  tilt = 0.55;
  isTouched = false;
  changed: () => void = () => undefined;
  private readonly held = new Map<number, [number, number]>();
  private readonly canvas: HTMLCanvasElement;

  constructor(canvas: HTMLCanvasElement) {
    this.canvas = canvas;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.held.set(event.pointerId, [event.clientX, event.clientY]);
    });
    canvas.addEventListener("pointermove", (event) => this.drag(event));
    for (const end of ["pointerup", "pointercancel"] as const) canvas.addEventListener(end, (event) => this.held.delete(event.pointerId));
    canvas.addEventListener("wheel", (event) => { event.preventDefault(); this.zoom(Math.exp(event.deltaY * 0.0012)); }, { passive: false });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  zoom(factor: number): void {
    this.isTouched = true;
    this.distance = Math.min(5000, Math.max(2, this.distance * factor));
    this.changed();
  }

  private drag(event: PointerEvent): void {
    const before = this.held.get(event.pointerId);
    if (!before) return;
    const [dx, dy] = [event.clientX - before[0], event.clientY - before[1]];
    const apart = this.apart();
    this.held.set(event.pointerId, [event.clientX, event.clientY]);
    if (this.held.size === 2) {
      const after = this.apart();
      if (apart && after) this.zoom(apart / after);
      this.shift(dx / 2, dy / 2);
    } else if (event.shiftKey || event.buttons & 6) this.shift(dx, dy);
    else this.rotate(-dx * 0.008, dy * 0.008);
  }

  private apart(): number {
    const [a, b] = [...this.held.values()];
    return a && b ? Math.hypot(a[0] - b[0], a[1] - b[1]) : 0;
  }

  rotate(by: number, up: number): void {
    this.isTouched = true;
    this.turn += by;
    this.tilt = Math.min(1.55, Math.max(-0.3, this.tilt + up));
    this.changed();
  }

  private shift(dx: number, dy: number): void {
    const scale = this.distance / Math.max(1, this.canvas.clientHeight);
    const [c, s] = [Math.cos(this.turn), Math.sin(this.turn)];
    const up = Math.sin(this.tilt);
    this.target[0] -= (c * dx + s * up * dy) * scale;
    this.target[1] -= (s * dx - c * up * dy) * scale;
    this.target[2] += Math.cos(this.tilt) * dy * scale;
    this.changed();
  }

  private key(event: KeyboardEvent): void {
    const step = 0.12;
    const acts: Record<string, () => void> = {
      ArrowLeft: () => this.rotate(-step, 0), ArrowRight: () => this.rotate(step, 0), ArrowUp: () => this.rotate(0, step), ArrowDown: () => this.rotate(0, -step),
      "+": () => this.zoom(0.85), "-": () => this.zoom(1.18),
    };
    const act = acts[event.key];
    if (act) { event.preventDefault(); event.stopPropagation(); act(); }
  }

  eye(): Vec3 {
    const flat = Math.cos(this.tilt) * this.distance;
    return [this.target[0] + Math.sin(this.turn) * flat, this.target[1] - Math.cos(this.turn) * flat, this.target[2] + Math.sin(this.tilt) * this.distance];
  }

  /** From the machine's millimetres to the screen. */
  matrix(aspect: number): Mat4 {
    const near = Math.max(0.5, this.distance / 100);
    const far = this.distance * 10 + 2000;
    const f = 1 / Math.tan(0.35) * Math.min(1, aspect);
    const lens = new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0]);
    const eye = this.eye();
    const back: Vec3 = [(eye[0] - this.target[0]) / this.distance, (eye[1] - this.target[1]) / this.distance, (eye[2] - this.target[2]) / this.distance];
    const right: Vec3 = [Math.cos(this.turn), Math.sin(this.turn), 0];
    const up: Vec3 = [back[1] * right[2] - back[2] * right[1], back[2] * right[0] - back[0] * right[2], back[0] * right[1] - back[1] * right[0]];
    const dot = (v: Vec3) => -(v[0] * eye[0] + v[1] * eye[1] + v[2] * eye[2]);
    const look = new Float32Array([right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0, dot(right), dot(up), dot(back), 1]);
    return multiply(lens, look);
  }
}
