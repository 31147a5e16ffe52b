// What the mock understands of a typed line: enough that every control of the page does something.
import type { Axis, Spindle } from "../src/api/types";
import type { Machine } from "./machine";

type Words = Map<string, number>;
type Act = (machine: Machine, words: Words, line: string) => string | undefined;

function setHeater(machine: Machine, name: string, to: number): string | undefined {
  const heater = machine.world[name as "extruder"];
  if (!heater) return `error: there is no heater ${name}`;
  if (to > (heater.max_temp ?? 300)) return `error: ${to} C is more than max_temp, ${heater.max_temp} C`;
  heater.target = to;
  return undefined;
}

function spin(machine: Machine, change: Partial<Spindle>): string | undefined {
  const { spindle } = machine.world.velvet;
  if (!spindle) return "error: there is no spindle";
  machine.change({ spindle: { ...spindle, ...change } });
  return undefined;
}

function setOffset(machine: Machine, words: Words): undefined {
  const { coordinates } = machine.world.velvet;
  const index = (words.get("P") || coordinates.offsets.findIndex((one) => one.name === coordinates.active) + 1) - 1;
  const relative = words.get("L") === 20;
  const offsets = coordinates.offsets.map((one, at) => (at !== index ? one : {
    ...one, at: one.at.map((value, axis) => {
      const word = words.get("XYZ"[axis]!);
      return word === undefined ? value : relative ? machine.world.toolhead.position[axis]! - word : word;
    }),
  }));
  machine.change({ coordinates: { ...coordinates, offsets } });
}

function goTo(machine: Machine, words: Words, isMachine: boolean): string | undefined {
  const { gcode_move } = machine.world;
  const to = machine.lastTarget();
  const offset = machine.isMill && !isMachine ? machine.offset() : [0, 0, 0];
  "XYZ".split("").forEach((word, axis) => {
    const value = words.get(word);
    if (value !== undefined) to[axis] = gcode_move.absolute_coordinates ? value + offset[axis]! : to[axis]! + value;
  });
  machine.push(to, (words.get("F") ?? 3000) / 60);
  machine.change({ mode: "Jog" });
  (machine as unknown as { by: string }).by ??= "hand";
  return undefined;
}

function probe(machine: Machine, words: Words): undefined {
  const to = machine.lastTarget();
  const axis = "XYZ".split("").findIndex((word) => words.has(word));
  to[axis] = axis === 2 ? -18.25 : to[axis]! + 4;
  machine.push(to, 20);
  machine.change({ mode: "Run", probe: { is_triggered: true, last: to.slice(0, 3) } });
  (machine as unknown as { by: string }).by ??= "hand";
  machine.said(`[PRB:${to.slice(0, 3).map((value) => value.toFixed(3)).join(",")}:1]`);
}

const NAMED: Record<string, Act> = {
  G28: (machine, words) => { machine.home("XYZ".split("").filter((axis) => words.has(axis)).join("").toLowerCase() || "xyz"); return undefined; },
  G29: (machine) => { machine.said("// probing 7 by 7 points"); return undefined; },
  G90: (machine) => { machine.world.gcode_move.absolute_coordinates = true; return undefined; },
  G91: (machine) => { machine.world.gcode_move.absolute_coordinates = false; return undefined; },
  M105: (machine) => `ok ${machine.heaters().map((one, index) => `${["T", "B", "C"][index]}:${one.temperature.toFixed(1)} /${one.target.toFixed(1)} @${Math.round(one.power * 255)}`).join(" ")}`,
  M104: (machine, words) => setHeater(machine, "extruder", words.get("S") ?? 0),
  M109: (machine, words) => setHeater(machine, "extruder", words.get("S") ?? 0),
  M140: (machine, words) => setHeater(machine, "heater_bed", words.get("S") ?? 0),
  M141: (machine, words) => setHeater(machine, "heater_generic chamber", words.get("S") ?? 0),
  M106: (machine, words) => { machine.world.fan.speed = (words.get("S") ?? 255) / 255; return undefined; },
  M107: (machine) => { machine.world.fan.speed = 0; return undefined; },
  M220: (machine, words) => {
    const factor = (words.get("S") ?? 100) / 100;
    machine.world.gcode_move.speed_factor = factor;
    machine.change({ overrides: { ...machine.world.velvet.overrides, feed: factor } });
    return undefined;
  },
  M221: (machine, words) => { machine.world.gcode_move.extrude_factor = (words.get("S") ?? 100) / 100; return undefined; },
  M223: (machine, words) => { machine.change({ overrides: { ...machine.world.velvet.overrides, spindle: (words.get("S") ?? 100) / 100 } }); return undefined; },
  M3: (machine, words) => spin(machine, { direction: "clockwise", target: words.get("S") ?? machine.world.velvet.spindle?.target ?? 0 }),
  M4: (machine, words) => spin(machine, { direction: "counterclockwise", target: words.get("S") ?? 0 }),
  M5: (machine) => spin(machine, { direction: "off", target: 0 }),
  M7: (machine) => { machine.change({ coolant: { flood: false, mist: true } }); return undefined; },
  M8: (machine) => { machine.change({ coolant: { flood: true, mist: false } }); return undefined; },
  M9: (machine) => { machine.change({ coolant: { flood: false, mist: false } }); return undefined; },
  M112: (machine) => { machine.halt({ code: "halt", text: "M112: the machine was told to halt", remedy: "Look at the machine, then unlock it. Axes have to be homed again." }); return undefined; },
  M117: (machine, _, line) => { machine.world.display_status.message = line.slice(4).trim(); return undefined; },
  M999: (machine) => { machine.unlock(); return undefined; },
  M18: (machine) => { machine.world.toolhead.homed_axes = ""; return undefined; },
  M115: () => "ok FIRMWARE_NAME:Velvet, MACHINE_TYPE:mock",
  M290: (machine, words) => { machine.world.gcode_move.homing_origin = machine.world.gcode_move.homing_origin.map((v, i) => (i === 2 ? Number((v + (words.get("Z") ?? 0)).toFixed(3)) : v)); return undefined; },
  G10: (machine, words) => setOffset(machine, words),
  G0: (machine, words, line) => goTo(machine, words, line.includes("G53")),
  G1: (machine, words, line) => goTo(machine, words, line.includes("G53")),
  "G38.2": (machine, words) => probe(machine, words),
};

function byName(machine: Machine, what: string, name: string, value: number): string | undefined {
  if (what === "SET_FAN_SPEED") machine.world.fan.speed = value;
  else if (what === "TURN_OFF_HEATERS") for (const heater of machine.heaters()) heater.target = 0;
  else return setHeater(machine, name === "chamber" ? "heater_generic chamber" : name, value);
  return undefined;
}

export function run(machine: Machine, text: string): string {
  const line = text.trim().toUpperCase();
  if (!line) return "ok";
  const name = /^(G53\s+)?([GMT]\d+(?:\.\d+)?)/.exec(line)?.[2]?.replace(/^([GM])0+(\d)/, "$1$2");
  if (machine.mode === "Alarm" && name !== "M999" && name !== "M105" && name !== "M115") return "error: the machine is halted; unlock it first";
  if (name && /^G5[4-9]$/.test(name)) { machine.change({ coordinates: { ...machine.world.velvet.coordinates, active: name } }); return "ok"; }
  if (name?.startsWith("T")) { machine.change({ tool: { number: Number(name.slice(1)), name: "", length: 0 } }); return "ok"; }
  const named = /^(SET_HEATER_TEMPERATURE|SET_FAN_SPEED|TURN_OFF_HEATERS)(?: (?:HEATER|FAN)=(\S+) (?:TARGET|SPEED)=(\S+))?/.exec(line);
  if (named) return byName(machine, named[1]!, (named[2] ?? "").toLowerCase(), Number(named[3])) ?? "ok";
  const words: Words = new Map([...line.matchAll(/([A-Z])(-?\d*\.?\d+)/g)].slice(1).map((one) => [one[1]!, Number(one[2])]));
  for (const axis of line.matchAll(/\b([XYZ])(?=\s|$)/g)) words.set(axis[1]!, 0);
  const act = name ? NAMED[name] : undefined;
  if (act) return act(machine, words, line) ?? "ok";
  return /^[GM]\d/.test(line) ? `ok - ${name} ignored` : `error: unknown command ${text.trim().split(" ")[0]}`;
}

export const AXES: Axis[] = ["x", "y", "z"];
