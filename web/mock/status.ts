// The objects of the machine as it is switched on.
import type { Heater, Objects } from "../src/api/types";

export type World = Omit<Objects, "extruder" | "heater_bed"> & {
  extruder?: Heater; heater_bed?: Heater; "heater_generic chamber"?: Heater; "temperature_sensor board": { temperature: number };
};

function mesh() {
  const rows: number[][] = [];
  for (let y = 0; y < 7; y++) {
    const row: number[] = [];
    for (let x = 0; x < 7; x++) row.push(Number((0.18 * Math.sin(x / 2.1) + 0.12 * Math.cos(y / 1.7 + x / 4) - 0.02 * x + 0.015 * ((x * 7 + y * 3) % 5 - 2)).toFixed(3)));
    rows.push(row);
  }
  return { profile_name: "default", mesh_min: [15, 15], mesh_max: [205, 205], probed_matrix: rows, mesh_matrix: rows };
}

const heater = (max: number): Heater => ({ temperature: 22, target: 0, power: 0, max_temp: max });

export function firstStatus(kind: "printer" | "mill"): World {
  const isMill = kind === "mill";
  const offsets = ["G54", "G55", "G56", "G57", "G58", "G59"].map((name, index) => ({ name, at: index === 0 ? [42.5, 31, -18.25] : index === 1 ? [160, 31, -18.25] : [0, 0, 0] }));
  const world: World = {
    webhooks: { state: "ready", state_message: "" },
    toolhead: {
      position: isMill ? [42.5, 31, 0, 0] : [110, 110, 12, 0], homed_axes: isMill ? "xyz" : "", axis_minimum: isMill ? [0, 0, -80, 0] : [0, 0, 0, 0],
      axis_maximum: isMill ? [400, 300, 0, 0] : [220, 220, 250, 0], max_velocity: 300, max_accel: 3000, ...(isMill ? {} : { extruder: "extruder" }),
    },
    gcode_move: { speed_factor: 1, extrude_factor: 1, speed: 3000, gcode_position: [0, 0, 0, 0], homing_origin: [0, 0, 0, 0], absolute_coordinates: true, absolute_extrude: false },
    motion_report: { live_position: [0, 0, 0, 0], live_velocity: 0 },
    heaters: { available_heaters: isMill ? [] : ["extruder", "heater_bed", "heater_generic chamber"], available_sensors: ["temperature_sensor board"] },
    fan: { speed: 0, rpm: null },
    print_stats: { filename: "", state: "standby", print_duration: 0, total_duration: 0, filament_used: 0, message: "", info: { current_layer: null, total_layer: null } },
    virtual_sdcard: { file_path: null, progress: 0, is_active: false, file_position: 0, file_size: 0 },
    display_status: { progress: 0, message: null },
    bed_mesh: isMill ? { profile_name: "", mesh_min: [], mesh_max: [], probed_matrix: [], mesh_matrix: [] } : mesh(),
    idle_timeout: { state: "Ready", printing_time: 0 },
    "temperature_sensor board": { temperature: 38.4 },
    velvet: {
      machine: kind, mode: "Idle", fault: null, axes: ["x", "y", "z"], work_position: [0, 0, 0], coordinates: { active: "G54", offsets },
      tool: isMill ? { number: 1, name: "6 mm end mill", length: 41.2 } : null,
      spindle: isMill ? { rpm: 0, target: 0, direction: "off", max_rpm: 24000 } : null,
      laser: null, coolant: isMill ? { flood: false, mist: false } : null, overrides: { feed: 1, rapid: 1, spindle: 1 },
      limits: { x_min: false, y_min: false, z_max: false }, probe: { is_triggered: false, last: null }, macros: 1,
    },
    velvet_messages: { messages: [] },
  };
  if (!isMill) Object.assign(world, { extruder: { ...heater(300), can_extrude: false }, heater_bed: heater(120), "heater_generic chamber": heater(70) });
  return world;
}
