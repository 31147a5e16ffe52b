// A machine that is simulated well enough to look at: heat, moves one after another, jobs, halts.
import type { Axis, Fault, Mode, Velvet } from "../src/api/types";
import type { Card } from "./files";
import { firstStatus, type World } from "./status";

interface Move { to: number[]; mm_per_s: number; byte: number; cuts: boolean; layer: number | null }
const AXES: Axis[] = ["x", "y", "z"];

export class Machine {
  readonly world: World;
  readonly card: Card;
  readonly isMill: boolean;
  readonly speed: number;
  path: number[][] = [];
  pathStart = 0;
  said: (text: string) => void = () => undefined;
  ended: (status: "completed" | "cancelled" | "error") => void = () => undefined;
  private moves: Move[] = [];
  private by: "job" | "hand" | null = null;
  private jog: { id: number; axis: number; mm_per_s: number; until: number } | null = null;
  private jogs = 0;
  private time = 0;

  constructor(card: Card, kind: "printer" | "mill", speed: number) {
    this.card = card;
    this.isMill = kind === "mill";
    this.speed = speed;
    this.world = firstStatus(kind);
  }

  get mode(): Mode { return this.world.velvet.mode; }

  private setMode(mode: Mode): void { this.world.velvet.mode = mode; }

  halt(fault: Omit<Fault, "since">): void {
    const { velvet, webhooks, print_stats, virtual_sdcard } = this.world;
    this.moves = [];
    this.jog = null;
    for (const heater of this.heaters()) { heater.target = 0; heater.power = 0; }
    if (velvet.spindle) velvet.spindle = { ...velvet.spindle, target: 0, direction: "off" };
    velvet.fault = { ...fault, since: Date.now() / 1000 };
    Object.assign(webhooks, { state: "shutdown", state_message: fault.text });
    if (this.by === "job") { print_stats.state = "error"; virtual_sdcard.is_active = false; this.ended("error"); }
    this.by = null;
    this.setMode("Alarm");
    this.said(`!! ${fault.text}`);
  }

  unlock(): void {
    this.world.velvet.fault = null;
    Object.assign(this.world.webhooks, { state: "ready", state_message: "" });
    this.world.print_stats.state = "standby";
    this.setMode("Idle");
    this.said("// unlocked; axes have to be homed");
    this.world.toolhead.homed_axes = "";
  }

  heaters() {
    return [this.world.extruder, this.world.heater_bed, this.world["heater_generic chamber"]].filter((one) => one !== undefined);
  }

  home(axes: string): void {
    this.setMode("Home");
    for (const axis of axes) {
      const at = AXES.indexOf(axis as Axis);
      const to = [...(this.lastTarget())];
      to[at] = this.isMill && axis === "z" ? 0 : this.world.toolhead.axis_minimum[at] ?? 0;
      this.push(to, 60);
    }
    this.by = "hand";
    this.world.toolhead.homed_axes = [...new Set(this.world.toolhead.homed_axes + axes)].sort().join("");
  }

  lastTarget(): number[] { return this.moves.at(-1)?.to ?? [...this.world.toolhead.position]; }

  push(to: number[], mm_per_s: number, extra?: Partial<Move>): void {
    this.moves.push({ to, mm_per_s, byte: 0, cuts: false, layer: null, ...extra });
  }

  moveBy(axis: Axis, mm: number, mm_per_min: number): string | null {
    const { toolhead } = this.world;
    const at = AXES.indexOf(axis);
    const to = [...this.lastTarget()];
    const place = (to[at] ?? 0) + mm;
    if (toolhead.homed_axes.includes(axis) && (place < toolhead.axis_minimum[at]! - 0.001 || place > toolhead.axis_maximum[at]! + 0.001)) {
      return `machine ${axis.toUpperCase()} ${place.toFixed(3)} is out of travel, which ends at ${mm < 0 ? toolhead.axis_minimum[at] : toolhead.axis_maximum[at]}`;
    }
    to[at] = place;
    this.push(to, mm_per_min / 60);
    this.by = "hand";
    this.setMode("Jog");
    return null;
  }

  startJog(axis: Axis, direction: 1 | -1, mm_per_min: number): number {
    this.jog = { id: ++this.jogs, axis: AXES.indexOf(axis), mm_per_s: direction * mm_per_min / 60, until: this.time + 0.1 };
    this.setMode("Jog");
    return this.jog.id;
  }
  beat(id: number): void { if (this.jog?.id === id) this.jog.until = this.time + 0.1; }
  stopJog(id: number): void { if (this.jog?.id === id) this.jog.until = 0; }

  startJob(path: string): string | null {
    const stored = this.card.files.get(path);
    if (!stored) return `there is no file ${path}`;
    if (this.by === "job") return "a job is running";
    this.moves = [];
    this.path = [];
    this.pathStart = 0;
    this.read(stored.bytes.toString("latin1"));
    const { print_stats, virtual_sdcard } = this.world;
    const layers = Math.max(0, ...this.moves.map((move) => move.layer ?? 0)) + 1;
    Object.assign(print_stats, { filename: path, state: "printing", print_duration: 0, total_duration: 0, filament_used: 0, message: "", info: { current_layer: this.isMill ? null : 0, total_layer: this.isMill ? null : layers } });
    Object.assign(virtual_sdcard, { file_path: path, progress: 0, is_active: true, file_position: 0, file_size: stored.bytes.length });
    this.world.toolhead.homed_axes = "xyz";
    if (!this.isMill) { this.world.extruder!.target = 215; this.world.heater_bed!.target = 60; this.world.fan.speed = 0.6; }
    else this.world.velvet.spindle = { ...this.world.velvet.spindle!, target: 12000, direction: "clockwise" };
    this.by = "job";
    this.setMode("Run");
    return null;
  }

  /** G0 and G1 with absolute coordinates, which is all that the mock's own files have. */
  private read(text: string): void {
    const at = [...this.world.toolhead.position];
    const offset = this.isMill ? this.offset() : [0, 0, 0];
    let feed = 60;
    let byte = 0;
    let layer: number | null = null;
    for (const line of text.split("\n")) {
      byte += line.length + 1;
      const layerHere = /^;LAYER:(\d+)/.exec(line);
      if (layerHere) layer = Number(layerHere[1]);
      if (!/^G[01]\b/.test(line)) continue;
      for (const [, word, value] of line.matchAll(/([XYZF])(-?[\d.]+)/g)) {
        if (word === "F") feed = Number(value) / 60;
        else at["XYZ".indexOf(word!)] = Number(value) + (offset["XYZ".indexOf(word!)] ?? 0);
      }
      this.push([...at], line.startsWith("G0") ? 100 : feed, { byte, layer, cuts: /E|^G1/.test(line) && line.startsWith("G1") && (this.isMill || line.includes("E")) });
    }
  }

  offset(): number[] {
    const { coordinates } = this.world.velvet;
    return coordinates.offsets.find((one) => one.name === coordinates.active)?.at ?? [0, 0, 0];
  }

  pause(): void { if (this.by === "job") { this.world.print_stats.state = "paused"; this.setMode("Hold"); } }
  resume(): void { if (this.by === "job") { this.world.print_stats.state = "printing"; this.setMode("Run"); } }
  cancel(): void {
    if (this.by !== "job") return;
    this.finish("cancelled");
  }

  private finish(how: "completed" | "cancelled"): void {
    this.moves = [];
    this.by = null;
    this.world.print_stats.state = how === "completed" ? "complete" : "cancelled";
    this.world.virtual_sdcard.is_active = false;
    for (const heater of this.heaters()) heater.target = 0;
    if (this.world.velvet.spindle) this.world.velvet.spindle = { ...this.world.velvet.spindle, target: 0, direction: "off" };
    this.setMode("Idle");
    this.ended(how);
  }

  tick(seconds: number): void {
    this.time += seconds;
    this.heat(seconds * this.speed);
    this.jogOn(seconds);
    const { print_stats, velvet, motion_report } = this.world;
    const hot = this.isMill || (this.world.extruder!.temperature > this.world.extruder!.target - 4);
    const goes = this.mode !== "Hold" && this.mode !== "Alarm" && this.mode !== "Door" && (this.by !== "job" || hot);
    if (this.by === "job") { print_stats.total_duration += seconds; if (goes) print_stats.print_duration += seconds; }
    const gone = goes ? this.advance(seconds * this.speed) : 0;
    motion_report.live_velocity = this.jog ? Math.abs(this.jog.mm_per_s) : gone / seconds / this.speed;
    if (velvet.spindle) {
      const spindle = velvet.spindle;
      velvet.spindle = { ...spindle, rpm: Math.round(spindle.rpm + (spindle.target * velvet.overrides.spindle - spindle.rpm) * Math.min(1, seconds * 2)) };
    }
    this.place();
  }

  private place(): void {
    const { toolhead, gcode_move, motion_report, velvet } = this.world;
    const offset = this.isMill ? this.offset() : this.world.gcode_move.homing_origin;
    motion_report.live_position = toolhead.position.map((value) => value);
    gcode_move.gcode_position = toolhead.position.map((value, index) => value - (offset[index] ?? 0));
    velvet.work_position = gcode_move.gcode_position.slice(0, 3);
  }

  private heat(seconds: number): void {
    for (const heater of this.heaters()) {
      const strong = heater === this.world.extruder ? 320 : 130;
      const want = heater.target ? Math.min(1, Math.max(0, (heater.target - heater.temperature) * 0.12 + (heater.target - 22) / strong)) : 0;
      heater.power = Number((this.mode === "Alarm" ? 0 : want).toFixed(2));
      const tau = heater === this.world.extruder ? 26 : 60;
      if (heater.can_extrude !== undefined) heater.can_extrude = heater.temperature > 170;
      heater.temperature += ((22 + heater.power * strong * (1 + 0.02 * Math.sin(this.time * 2)) - heater.temperature) / tau) * seconds;
    }
  }

  private jogOn(seconds: number): void {
    const jog = this.jog;
    if (!jog) return;
    const { position, axis_minimum, axis_maximum } = this.world.toolhead;
    position[jog.axis] = Math.min(axis_maximum[jog.axis]!, Math.max(axis_minimum[jog.axis]!, position[jog.axis]! + jog.mm_per_s * seconds));
    if (this.time > jog.until) { this.jog = null; if (this.mode === "Jog") this.setMode("Idle"); }
  }

  private advance(seconds: number): number {
    const { toolhead, virtual_sdcard, print_stats, velvet, gcode_move } = this.world;
    const factor = this.by === "job" ? (this.isMill ? velvet.overrides.feed : gcode_move.speed_factor) : 1;
    let left = seconds;
    let gone = 0;
    while (left > 0 && this.moves.length) {
      const move = this.moves[0]!;
      const distance = Math.hypot(...AXES.map((_, index) => move.to[index]! - toolhead.position[index]!));
      const reach = move.mm_per_s * factor * left;
      const part = distance > reach ? reach / distance : 1;
      for (let axis = 0; axis < 3; axis++) toolhead.position[axis]! += (move.to[axis]! - toolhead.position[axis]!) * part;
      gone += distance * part;
      if (this.by === "job" && distance > 0) this.record([...toolhead.position.slice(0, 3), move.cuts ? 1 : 0]);
      if (part < 1) break;
      left -= distance / (move.mm_per_s * factor) + 1e-6;
      this.moves.shift();
      if (this.by === "job") {
        Object.assign(virtual_sdcard, { file_position: move.byte, progress: move.byte / virtual_sdcard.file_size });
        if (move.layer !== null) print_stats.info = { ...print_stats.info, current_layer: move.layer + 1 };
        if (move.cuts && !this.isMill) print_stats.filament_used += distance * 0.03;
      }
    }
    if (!this.moves.length && !this.jog) {
      if (this.by === "job") this.finish("completed");
      else if (this.by === "hand") { this.by = null; this.setMode("Idle"); }
    }
    return gone;
  }

  private record(point: number[]): void {
    this.path.push(point.map((value) => Number(value.toFixed(3))));
    if (this.path.length > 40000) { this.path.shift(); this.pathStart++; }
  }

  /** Sets in the object of Velvet what is only there on a mill. */
  change(fields: Partial<Velvet>): void { Object.assign(this.world.velvet, fields); }
}
