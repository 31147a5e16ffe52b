// The board's API as TypeScript: docs/api.md in types. Page, mock board and tests share this one file.

export type Role = "Nobody" | "Watch" | "Operate" | "Own";
export type MachineKind = "printer" | "mill" | "lathe" | "laser";
export type Mode = "Idle" | "Run" | "Hold" | "Jog" | "Alarm" | "Door" | "Check" | "Home" | "Sleep";
export type Axis = "x" | "y" | "z" | "a" | "b" | "c";
export type Level = "info" | "warning" | "error";

/** Nothing to hand over, nothing to tell. */
export type Nothing = Record<string, never>;
export type Ok = "ok";

export interface Webhooks { state: "startup" | "ready" | "error" | "shutdown"; state_message: string }
export interface Toolhead {
  position: number[];
  homed_axes: string;
  axis_minimum: number[];
  axis_maximum: number[];
  max_velocity: number;
  max_accel: number;
  extruder?: string;
}
export interface GcodeMove {
  speed_factor: number;
  extrude_factor: number;
  speed: number;
  gcode_position: number[];
  homing_origin: number[];
  absolute_coordinates: boolean;
  absolute_extrude: boolean;
}
export interface MotionReport { live_position: number[]; live_velocity: number; live_extruder_velocity?: number }
export interface Heater { temperature: number; target: number; power: number; can_extrude?: boolean; max_temp?: number }
export interface Heaters { available_heaters: string[]; available_sensors: string[] }
export interface Fan { speed: number; rpm: number | null }
export interface PrintStats {
  filename: string;
  state: "standby" | "printing" | "paused" | "complete" | "cancelled" | "error";
  print_duration: number;
  total_duration: number;
  filament_used: number;
  message: string;
  info: { current_layer: number | null; total_layer: number | null };
}
export interface VirtualSdcard {
  file_path: string | null;
  progress: number;
  is_active: boolean;
  file_position: number;
  file_size: number;
}
export interface DisplayStatus { progress: number; message: string | null }
export interface BedMesh {
  profile_name: string;
  mesh_min: number[];
  mesh_max: number[];
  probed_matrix: number[][];
  mesh_matrix: number[][];
}
export interface IdleTimeout { state: "Idle" | "Printing" | "Ready"; printing_time: number }

export interface Fault { code: string; text: string; remedy: string; since?: number }
export interface Offset { name: string; at: number[] }
export interface Tool { number: number; name: string; length: number }
export interface Spindle { rpm: number; target: number; direction: "off" | "clockwise" | "counterclockwise"; max_rpm: number }
/** Time in seconds since the board's start; the remedy is empty where nothing is to be done. */
export interface Message { time: number; level: Level; text: string; remedy: string }
/** What Moonraker has no words for. */
export interface Velvet {
  machine: MachineKind;
  mode: Mode;
  fault: Fault | null;
  axes: Axis[];
  work_position: number[];
  coordinates: { active: string; offsets: Offset[] };
  tool: Tool | null;
  spindle: Spindle | null;
  /** Power that comes out now, a share of full power; the code in force; why it burns beside a path; interlocks that are open. */
  laser: { power: number; mode: "off" | "M3" | "M4"; on: boolean; test: boolean; framing: boolean; open: string[] } | null;
  coolant: { flood: boolean; mist: boolean } | null;
  overrides: { feed: number; rapid: number; spindle: number };
  limits: Record<string, boolean>;
  probe: { is_triggered: boolean; last: number[] | null } | null;
  /** Number of the list of macros: another one when they were read anew. */
  macros: number;
}

/** Every object by name. Heaters, fans and sensors beyond these are named by a prefix: `heater_generic chamber`. */
export interface Objects {
  webhooks: Webhooks;
  toolhead: Toolhead;
  gcode_move: GcodeMove;
  motion_report: MotionReport;
  extruder: Heater;
  heater_bed: Heater;
  heaters: Heaters;
  fan: Fan;
  print_stats: PrintStats;
  virtual_sdcard: VirtualSdcard;
  display_status: DisplayStatus;
  bed_mesh: BedMesh;
  idle_timeout: IdleTimeout;
  velvet: Velvet;
  velvet_messages: { messages: Message[] };
}
export type ObjectName = keyof Objects;
export type Status = { [name: string]: object };

export interface FileEntry { filename: string; size: number; modified: number; permissions: string }
export interface FolderEntry { dirname: string; size: number; modified: number; permissions: string }
export interface Directory {
  dirs: FolderEntry[];
  files: FileEntry[];
  /** Null until the board has counted it. */
  disk_usage: { total: number; used: number; free: number } | null;
  root_info: { name: string; permissions: string };
}
export interface Thumbnail { width: number; height: number; size: number; relative_path: string }
export interface Metadata {
  filename: string;
  size: number;
  modified: number;
  slicer?: string;
  estimated_time?: number;
  layer_height?: number;
  object_height?: number;
  filament_total?: number;
  filament_type?: string;
  first_layer_extr_temp?: number;
  first_layer_bed_temp?: number;
  thumbnails?: Thumbnail[];
}
export interface Series { temperatures: number[]; targets?: number[]; powers?: number[] }
/** A line of the console, with its Unix time; the board tells the time since its start, with the present one as `eventtime`. */
export interface StoreLine { message: string; time: number; type: "command" | "response" }
export interface PathPiece { next: number; lost: boolean; points: number[][] }
export interface PasswordStep { state: "confirm"; shown_on: string; expires_s: number }
export interface AccessInfo { login_required: boolean; password_set: boolean; role: Role; default_source: string; available_sources: string[] }
/** A program's key: shown once when it is made, then known by its name. */
export interface ApiKey { name: string; role: Role }
export interface User { username: string | null; source: string; created_on: number; role: Role }

/** Parameters, result and role of each method: the table of docs/api.md. */
export interface Methods {
  "server.connection.identify": [{ client_name: string; version: string; type: string; url: string }, { connection_id: number }];
  "server.info": [Nothing, { klippy_connected: boolean; klippy_state: string; components: string[]; moonraker_version: string }];
  "printer.info": [Nothing, { state: string; state_message: string; hostname: string; software_version: string; app: string }];
  "printer.objects.list": [Nothing, { objects: string[] }];
  "printer.objects.query": [{ objects: Record<string, string[] | null> }, { eventtime: number; status: Status }];
  "printer.objects.subscribe": [{ objects: Record<string, string[] | null> }, { eventtime: number; status: Status }];
  "printer.gcode.script": [{ script: string }, Ok];
  "printer.gcode.help": [Nothing, Record<string, string>];
  "printer.emergency_stop": [Nothing, Ok];
  "printer.firmware_restart": [Nothing, Ok];
  "printer.print.start": [{ filename: string }, Ok];
  "printer.print.pause": [Nothing, Ok];
  "printer.print.resume": [Nothing, Ok];
  "printer.print.cancel": [Nothing, Ok];
  "server.files.list": [{ root: string }, { path: string; modified: number; size: number; permissions: string }[]];
  "server.files.get_directory": [{ path: string }, Directory];
  "server.files.metadata": [{ filename: string }, Metadata];
  "server.files.delete_file": [{ path: string }, { item: { root: string; path: string }; action: string }];
  "server.files.delete_directory": [{ path: string; force: boolean }, { item: { root: string; path: string }; action: string }];
  "server.files.move": [{ source: string; dest: string }, { item: { root: string; path: string }; action: string }];
  "server.files.post_directory": [{ path: string }, { item: { root: string; path: string }; action: string }];
  "server.temperature_store": [Nothing, Record<string, Series>];
  "server.gcode_store": [{ count?: number }, { gcode_store: StoreLine[]; eventtime?: number }];
  "access.info": [Nothing, AccessInfo];
  "access.get_user": [Nothing, User];
  "access.login": [{ username: string; password: string }, { username: string; role: Role; action: string }];
  "access.logout": [Nothing, { username: string; action: string }];
  "access.post_api_key": [{ name: string; role?: Role }, string];
  "velvet.keys.list": [Nothing, { keys: ApiKey[] }];
  "velvet.keys.revoke": [{ name: string }, Ok];
  "velvet.password.set": [{ password: string } | { code: string }, PasswordStep | Ok];
  "velvet.ask": [{ script: string }, Ok];
  "velvet.jog.step": [{ axis: Axis; mm: number; mm_per_min: number }, Ok];
  "velvet.jog.start": [{ axis: Axis; direction: 1 | -1; mm_per_min: number }, { id: number }];
  "velvet.jog.beat": [{ id: number }, Ok];
  "velvet.jog.stop": [{ id: number }, Ok];
  "velvet.home": [{ axes: string }, Ok];
  "velvet.override.set": [{ feed?: number; rapid?: number; spindle?: number }, Ok];
  "velvet.path.since": [{ seq: number }, PathPiece];
}
export type Method = keyof Methods;
export type Params<M extends Method> = Methods[M][0];
export type Result<M extends Method> = Methods[M][1];

/** Who may call a method: everybody with this role or a higher one. */
export const ROLES: { [M in Method]: Role } = {
  "server.connection.identify": "Nobody",
  "access.info": "Nobody",
  "access.login": "Nobody",
  "access.get_user": "Nobody",
  "access.logout": "Nobody",
  "velvet.password.set": "Nobody",
  "server.info": "Watch",
  "printer.info": "Watch",
  "printer.objects.list": "Watch",
  "printer.objects.query": "Watch",
  "printer.objects.subscribe": "Watch",
  "printer.gcode.help": "Watch",
  "printer.emergency_stop": "Watch",
  "server.files.list": "Watch",
  "server.files.get_directory": "Watch",
  "server.files.metadata": "Watch",
  "server.temperature_store": "Watch",
  "server.gcode_store": "Watch",
  "velvet.path.since": "Watch",
  "velvet.ask": "Watch",
  "printer.gcode.script": "Operate",
  "printer.firmware_restart": "Operate",
  "printer.print.start": "Operate",
  "printer.print.pause": "Operate",
  "printer.print.resume": "Operate",
  "printer.print.cancel": "Operate",
  "server.files.post_directory": "Operate",
  "velvet.home": "Operate",
  "velvet.override.set": "Operate",
  "velvet.jog.step": "Operate",
  "velvet.jog.start": "Operate",
  "velvet.jog.beat": "Operate",
  "velvet.jog.stop": "Operate",
  "server.files.delete_file": "Own",
  "server.files.delete_directory": "Own",
  "server.files.move": "Own",
  "access.post_api_key": "Own",
  "velvet.keys.list": "Own",
  "velvet.keys.revoke": "Own",
};

export interface Notifications {
  notify_status_update: [Status, number];
  notify_klippy_ready: [];
  notify_klippy_shutdown: [];
  notify_klippy_disconnected: [];
  notify_gcode_response: [string];
  notify_velvet_answer: [string];
  notify_filelist_changed: [{ action: string; item: { root: string; path: string }; source_item?: { root: string; path: string } }];
  notify_proc_stat_update: [{ system_cpu_usage?: { cpu: number }; cpu_temp?: number }];
}
export type Notification = keyof Notifications;

export interface RpcError { code: number; message: string }
