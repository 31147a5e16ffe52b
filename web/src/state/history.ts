// Temperatures of the last minutes and the lines of the console: filled from the board's stores, then from what comes.
import { signal } from "@preact/signals";
import { call, on } from "../api/link";
import type { StoreLine } from "../api/types";
import { heaterNamed, heaterNames, isLive, sensorNames } from "./machine";
import { onReady } from "./session";

export interface Trace { temperatures: number[]; targets: number[] }
const LENGTH = 600;
export const times: number[] = [];
export const traces = new Map<string, Trace>();
/** Counts up with each second of temperatures. */
export const traceTurn = signal(0);

function trace(name: string): Trace {
  let found = traces.get(name);
  if (!found) {
    found = { temperatures: times.map(() => Number.NaN), targets: times.map(() => Number.NaN) };
    traces.set(name, found);
  }
  return found;
}

async function fillTemperatures(): Promise<void> {
  const store = await call("server.temperature_store", {});
  const length = Math.min(LENGTH, Math.max(0, ...Object.values(store).map((one) => one.temperatures.length)));
  const end = Date.now() / 1000;
  times.length = 0;
  traces.clear();
  for (let at = 0; at < length; at++) times.push(end - (length - at));
  for (const [name, series] of Object.entries(store)) {
    const one = trace(name);
    for (let at = 0; at < length; at++) {
      one.temperatures[at] = series.temperatures[series.temperatures.length - length + at] ?? Number.NaN;
      one.targets[at] = series.targets?.[series.targets.length - length + at] ?? Number.NaN;
    }
  }
  traceTurn.value += 1;
}

function sample(): void {
  if (!isLive.peek() || times.length === 0 && heaterNames.peek().length === 0) return;
  const names = [...heaterNames.peek(), ...sensorNames.peek()];
  times.push(Date.now() / 1000);
  for (const name of names) {
    const one = trace(name);
    const heater = heaterNamed(name);
    one.temperatures[times.length - 1] = heater?.temperature ?? Number.NaN;
    one.targets[times.length - 1] = heater?.target ?? Number.NaN;
  }
  while (times.length > LENGTH) {
    times.shift();
    for (const one of traces.values()) { one.temperatures.shift(); one.targets.shift(); }
  }
  traceTurn.value += 1;
}

export const consoleLines = signal<StoreLine[]>([]);
const KEPT = 500;
/** A refusal, a fault or a halt, by how the machine begins such lines. */
export const isBad = (message: string) => /^(!!|error:|ALARM|ERROR)/.test(message);

export function addLine(line: StoreLine): void {
  consoleLines.value = [...consoleLines.peek().slice(1 - KEPT), line];
}
on("notify_gcode_response", (message) => addLine({ message, time: Date.now() / 1000, type: "response" }));

/** Codes, commands and macros with their help, for completion. */
export const codes = signal<[string, string][]>([]);
export const loadHelp = () => call("printer.gcode.help", {}).then((help) => { codes.value = Object.entries(help).sort(); }).catch(() => undefined);

export function startHistory(): void {
  onReady(() => {
    void fillTemperatures().catch(() => undefined);
    void call("server.gcode_store", { count: 200 }).then(({ gcode_store, eventtime }) => {
      const start = eventtime === undefined ? 0 : Date.now() / 1000 - eventtime;
      consoleLines.value = gcode_store.map((line) => ({ ...line, time: line.time + start }));
    }).catch(() => undefined);
    void loadHelp();
  });
  window.setInterval(sample, 1000);
}
