// The methods of docs/api.md on the mock machine.
import type { ApiKey, Method, Params, Result, Role } from "../src/api/types";
import { ROLES } from "../src/api/types";
import { configSet, readCodes, sampleConfig } from "./data";
import type { Card } from "./files";
import { run } from "./gcode";
import type { Machine } from "./machine";

export class Failure extends Error {
  readonly code: number;
  constructor(code: number, text: string) { super(text); this.code = code; }
}
export interface Client { role: Role; watches: Set<string>; told: Map<string, string>; hear: (line: string) => void }

type Handlers = { [M in Method]?: (params: Params<M>, client: Client) => Result<M> | Promise<Result<M>> };
const ORDER: Role[] = ["Nobody", "Watch", "Operate", "Own"];

export class Api {
  readonly machine: Machine;
  readonly card: Card;
  private readonly web: string;
  readonly started = Date.now();
  /** Bytes of the next upload after which its link dies, and where the last one went on. */
  cutUploadAt = 0;
  uploadedFrom = 0;
  notify: (method: string, ...params: unknown[]) => void = () => undefined;
  private readonly codes: Record<string, string>;
  private lines: Result<"server.gcode_store">["gcode_store"] = [];
  private keys: ApiKey[] = [];
  private readonly store = new Map<string, { temperatures: number[]; targets: number[]; powers: number[] }>();
  private version = "0.9.2";
  /** Macros of the printer.cfg, with what they say of themselves. */
  macros: Record<string, string> = { PRINT_START: "Warms up, homes and cleans the nozzle", Load_Filament: "Pulls filament in", M600: "Changes filament", _PARK: "" };

  /** A bare board has the printer's methods and objects, and nothing else: what a page has to bear with. */
  private readonly isBare: boolean;

  constructor(machine: Machine, card: Card, web: string, isBare: boolean) {
    this.isBare = isBare;
    this.machine = machine;
    this.card = card;
    this.web = web;
    this.codes = readCodes(web);
    card.files.set("config.ini", { bytes: Buffer.from(sampleConfig(web, machine.isMill)), modified: Date.now() / 1000 });
    for (const name of ["flashme.bin", "firmware.previous"]) card.files.set(name, { bytes: Buffer.alloc(2048), modified: Date.now() / 1000 });
    this.fillStore();
    machine.said = (text) => this.say(text);
  }

  say(message: string): void {
    this.lines.push({ message, time: Date.now() / 1000, type: "response" });
    this.notify("notify_gcode_response", message);
    const [, begin = "", text = ""] = /^(!!|error:|WARNING:|\/\/|echo:) ?(.*)/.exec(message) ?? [];
    if (!begin) return;
    const level = begin === "WARNING:" ? "warning" : /!!|error/.test(begin) ? "error" : "info";
    const { fault } = this.machine.world.velvet;
    const one = { time: this.now(), level, text, remedy: fault?.text === text ? fault.remedy : "" } as const;
    this.machine.world.velvet_messages = { messages: [...this.machine.world.velvet_messages.messages, one].slice(-5) };
  }

  private fillStore(): void {
    for (const name of this.heaterNames()) {
      this.store.set(name, { temperatures: Array(240).fill(22), targets: Array(240).fill(0), powers: Array(240).fill(0) });
    }
    this.store.set("temperature_sensor board", { temperatures: Array(240).fill(38.4), targets: [], powers: [] });
  }
  private heaterNames(): string[] { return this.machine.world.heaters.available_heaters; }

  /** Once a second: one point more of each temperature. */
  keepTemperatures(): void {
    for (const [name, series] of this.store) {
      const heater = this.machine.world[name as "extruder"];
      if (!heater) continue;
      series.temperatures.push(Number(heater.temperature.toFixed(2)));
      series.targets.push(heater.target ?? 0);
      series.powers.push(heater.power ?? 0);
      for (const list of Object.values(series)) while (list.length > 600) list.shift();
    }
  }

  async answer(method: string, params: unknown, client: Client): Promise<unknown> {
    const role = ROLES[method as Method];
    const handler = this.handlers[method as Method] as ((params: unknown, client: Client) => unknown) | undefined;
    const isMissing = this.isBare && /^(velvet|server\.(history|temperature|gcode|files\.metadata)|printer\.gcode\.help)/.test(method);
    if (!role || !handler || isMissing) throw new Failure(-32601, `Method not found: ${method}`);
    if (ORDER.indexOf(client.role) < ORDER.indexOf(role)) throw new Failure(401, client.role === "Nobody" ? "Log in first." : "That is for who has logged in.");
    return await handler(params ?? {}, client);
  }

  pick(objects: Record<string, string[] | null>): Record<string, object> {
    const world = this.machine.world as unknown as Record<string, Record<string, unknown>>;
    const out: Record<string, object> = {};
    for (const [name, fields] of Object.entries(objects)) {
      const all = world[name];
      if (all) out[name] = fields ? Object.fromEntries(fields.map((field) => [field, all[field]])) : all;
    }
    return out;
  }
  now(): number { return (Date.now() - this.started) / 1000; }

  private async script(text: string): Promise<"ok"> {
    for (const line of text.split("\n").filter((one) => one.trim())) {
      this.lines.push({ message: line, time: Date.now() / 1000, type: "command" });
      if (line.trim() === "MOCK_FAULT") {
        this.machine.halt({ code: "heater", text: "heater hotend: temperature fell by 24 C in a second while heating", remedy: "The sensor has come off, or its wire is broken. Let it cool, look at the thermistor of the hot end, then unlock." });
        continue;
      }
      if (line.trim() === "macros reload") {
        this.macros = { PRINT_END: "Cools down and parks" };
        this.machine.change({ macros: this.machine.world.velvet.macros + 1 });
        continue;
      }
      const [name = "", ...words] = line.trim().split(/\s+/);
      if (Object.keys(this.macros).some((one) => one.toUpperCase() === name.toUpperCase())) { this.say(`echo: ${name} got ${words.join(" ") || "nothing"}`); continue; }
      const said = run(this.machine, line);
      if (said.startsWith("error")) { this.say(`!! ${said.slice(7)}`); throw new Failure(400, said.slice(7)); }
      this.say(said);
    }
    return "ok";
  }

  changed(action: string, path: string, from?: string): { item: { root: string; path: string }; action: string } {
    const said = { action, item: { root: "gcodes", path }, ...(from ? { source_item: { root: "gcodes", path: from } } : {}) };
    this.notify("notify_filelist_changed", said);
    return said;
  }

  private file(path: string): string {
    const inner = path.replace(/^gcodes\/?/, "");
    if (!this.card.files.has(inner)) throw new Failure(404, `There is no file ${path}.`);
    return inner;
  }

  private move(source: string, dest: string) {
    const from = this.file(source);
    const to = dest.replace(/^gcodes\/?/, "");
    if (this.card.files.has(to)) throw new Failure(409, `There is a file ${to} already.`);
    this.card.files.set(to, this.card.files.get(from)!);
    this.card.files.delete(from);
    return this.changed("move_file", to, from);
  }

  /** Lines of `check`, as the board says them. */
  private check(path: string): string[] {
    const text = this.card.files.get(this.file(path))!.bytes.toString("latin1");
    const lines = text.split("\n");
    const found: string[] = [];
    const { axis_maximum } = this.machine.world.toolhead;
    lines.forEach((line, index) => {
      const x = Number(/X(-?[\d.]+)/.exec(line)?.[1] ?? 0);
      if (/^G[01]/.test(line) && x > axis_maximum[0]!) {
        found.push(`line ${index + 1}: stops: machine X ${x.toFixed(3)} is out of travel, which ends at ${axis_maximum[0]!.toFixed(3)} ([soft endstop] x_max) (place the part elsewhere, or correct x_max)`);
      }
    });
    const stops = found.length;
    if (lines.length > 4000) found.push("line 22: warning: Z is asked for 50.0 mm/s and limited to 15.0 mm/s (slice for that speed, or raise the limit)");
    return [...found, `${lines.length} lines: ${stops} stop the job, ${found.length - stops} warnings`, "time: 0:12:31 without heating (moving 745.2 s, 31 % of it changing speed; waiting 0.0 s; homing about 6.0 s)"];
  }

  /** A line whose answer is for the asker alone. */
  private inquire(line: string, hear: (text: string) => void): "ok" {
    const config = this.card.files.get("config.ini")!;
    if (line.startsWith("check ")) this.check(`gcodes/${/"\/sd\/(.*)"/.exec(line)?.[1] ?? ""}`).forEach(hear);
    else if (line === "version") [`STM32H745 on Prime. board_id: 00`, `Build version: ${this.version}`, "Firmware: came with flashme.bin, on trial: start 1 of 3"].forEach(hear);
    else if (line === "M78") ["jobs: 412 done, 9 broken off", "time: 750:12:40 in jobs (20:01:02 of it still), the longest 16:56:40"].forEach(hear);
    else if (line.startsWith("cp ")) this.card.files.set("flashme.bin", this.card.files.get("firmware.previous")!);
    else if (line === "flash") {
      this.version = "0.9.1";
      hear("looking at /sd/flashme.bin");
      hear("flashme.bin holds 0.9.1: it is installed in a second, which takes some 20 s; leave power on and the card in");
    } else if (line.startsWith("config-set ")) {
      const changed = configSet(this.web, config.bytes.toString(), line);
      if ("wrong" in changed) hear(`error:${changed.wrong}`);
      else config.bytes = Buffer.from(changed.file);
    } else throw new Failure(400, `Unsupported command - ${line}`);
    return "ok";
  }

  private readonly handlers: Handlers = {
    "server.connection.identify": () => ({ connection_id: 1 }),
    "server.info": () => ({ klippy_connected: true, klippy_state: this.machine.world.webhooks.state, components: ["file_manager", "history", "authorization"], moonraker_version: "v0.10.0-0-velvet" }),
    "printer.info": () => ({ state: this.machine.world.webhooks.state, state_message: "", hostname: this.machine.isMill ? "velvet-mill" : "velvet", software_version: "velvet-0.9.2", app: "Velvet" }),
    "printer.objects.list": () => ({
      objects: this.isBare ? Object.keys(this.machine.world).filter((name) => !/^(velvet|bed_mesh|motion_report|fan|temperature_sensor.*|display_status)$/.test(name))
        : [...Object.keys(this.machine.world), ...Object.keys(this.macros).map((name) => `gcode_macro ${name}`)],
    }),
    "printer.objects.query": ({ objects }) => ({ eventtime: this.now(), status: this.pick(objects) }),
    "printer.objects.subscribe": ({ objects }, client) => {
      client.watches = new Set(Object.keys(objects));
      client.told.clear();
      return { eventtime: this.now(), status: this.pick(objects) };
    },
    "printer.gcode.script": ({ script }) => this.script(script),
    "printer.gcode.help": () => ({ ...Object.fromEntries(Object.entries(this.macros).map(([name, help]) => [name.toUpperCase(), help || "macro"])), ...this.codes }),
    "printer.emergency_stop": () => { run(this.machine, "M112"); return "ok"; },
    "printer.firmware_restart": () => { this.machine.unlock(); return "ok"; },
    "printer.print.start": ({ filename }) => {
      const refused = this.machine.mode === "Alarm" ? "the machine is halted; unlock it first" : this.machine.startJob(filename);
      if (refused) throw new Failure(400, refused);
      return "ok";
    },
    "printer.print.pause": () => { this.machine.pause(); return "ok"; },
    "printer.print.resume": () => { this.machine.resume(); return "ok"; },
    "printer.print.cancel": () => { this.machine.cancel(); return "ok"; },
    "server.files.list": () => [...this.card.files].map(([path, one]) => ({ path, modified: one.modified, size: one.bytes.length, permissions: "rw" })),
    "server.files.get_directory": ({ path }) => this.card.list(path.replace(/^gcodes\/?/, "")),
    "server.files.metadata": ({ filename }) => this.card.metadata(this.file(filename))!,
    "server.files.delete_file": ({ path }) => { const inner = this.file(path); this.card.files.delete(inner); return this.changed("delete_file", inner); },
    "server.files.delete_directory": ({ path }) => {
      const inner = path.replace(/^gcodes\/?/, "");
      for (const name of [...this.card.files.keys()]) if (name.startsWith(`${inner}/`)) this.card.files.delete(name);
      this.card.folders.delete(inner);
      return this.changed("delete_dir", inner);
    },
    "server.files.move": ({ source, dest }) => this.move(source, dest),
    "server.files.post_directory": ({ path }) => { const inner = path.replace(/^gcodes\/?/, ""); this.card.folders.add(inner); return this.changed("create_dir", inner); },
    "server.temperature_store": () => Object.fromEntries(this.store),
    "server.gcode_store": ({ count }) => ({ gcode_store: this.lines.slice(-(count ?? 1000)) }),
    "access.post_api_key": ({ name, role }) => {
      if (this.keys.some((key) => key.name === name)) throw new Failure(409, "another key has this name: revoke that one first");
      this.keys.push({ name, role: role ?? "Operate" });
      return "4f1c8e0a9b7d4c55a2e3f6b1d0987c24";
    },
    "velvet.keys.list": () => ({ keys: this.keys }),
    "velvet.keys.revoke": ({ name }) => {
      if (!this.keys.some((key) => key.name === name)) throw new Failure(404, "there is no key of this name");
      this.keys = this.keys.filter((key) => key.name !== name);
      return "ok";
    },
    "velvet.jog.step": ({ axis, mm, mm_per_min }) => {
      const refused = this.machine.moveBy(axis, mm, mm_per_min);
      if (refused) throw new Failure(400, refused);
      return "ok";
    },
    "velvet.jog.start": ({ axis, direction, mm_per_min }) => ({ id: this.machine.startJog(axis, direction, mm_per_min) }),
    "velvet.jog.beat": ({ id }) => { this.machine.beat(id); return "ok"; },
    "velvet.jog.stop": ({ id }) => { this.machine.stopJog(id); return "ok"; },
    "velvet.home": ({ axes }) => { this.machine.home(axes || "xyz"); return "ok"; },
    "velvet.override.set": (given) => {
      const overrides = { ...this.machine.world.velvet.overrides, ...given };
      this.machine.change({ overrides });
      this.machine.world.gcode_move.speed_factor = overrides.feed;
      return "ok";
    },
    "velvet.path.since": ({ seq }) => {
      const { path, pathStart } = this.machine;
      const from = Math.max(0, seq - pathStart);
      const points = path.slice(from, from + 1500);
      return { next: pathStart + from + points.length, lost: seq < pathStart, points };
    },
    "velvet.ask": ({ script }, client) => this.inquire(script, client.hear),
  };
}
