// The machine's objects as signals: one each, so that a change redraws only who shows it.
import { computed, type Signal, signal } from "@preact/signals";
import { call, lastHeard, linkState, on } from "../api/link";
import type { Heater, Mode, ObjectName, Objects, Status } from "../api/types";

const objects = new Map<string, Signal<object | undefined>>();

function slot(name: string): Signal<object | undefined> {
  let found = objects.get(name);
  if (!found) {
    found = signal<object | undefined>(undefined);
    objects.set(name, found);
  }
  return found;
}

/** An object as it was last told, or nothing where the machine has none. */
export function obj<N extends ObjectName>(name: N): Objects[N] | undefined {
  return slot(name).value as Objects[N] | undefined;
}

export function heaterNamed(name: string): Heater | undefined {
  return slot(name).value as Heater | undefined;
}

function merge(status: Status): void {
  for (const [name, changed] of Object.entries(status)) {
    const one = slot(name);
    one.value = { ...one.peek(), ...changed };
  }
}

/** Names of all objects that this machine has. */
export const objectNames = signal<string[]>([]);
export const hostname = signal("velvet");
export const softwareVersion = signal("");
export const eventTime = signal(0);
export const cpuLoad = signal<number | undefined>(undefined);

on("notify_status_update", (status, time) => {
  eventTime.value = time;
  merge(status);
});
on("notify_klippy_shutdown", () => merge({ webhooks: { state: "shutdown" } }));
on("notify_klippy_ready", () => merge({ webhooks: { state: "ready", state_message: "" } }));
on("notify_proc_stat_update", (stats) => { cpuLoad.value = stats.system_cpu_usage?.cpu; });

/** Asks for everything and for what changes from now on. */
export async function subscribe(): Promise<void> {
  const info = await call("printer.info", {});
  hostname.value = info.hostname;
  softwareVersion.value = info.software_version;
  const { objects: names } = await call("printer.objects.list", {});
  objectNames.value = names;
  for (const name of objects.keys()) if (!names.includes(name)) slot(name).value = undefined;
  const { status, eventtime } = await call("printer.objects.subscribe", { objects: Object.fromEntries(names.map((name) => [name, null])) });
  eventTime.value = eventtime;
  merge(status);
}

/** A clock for what depends on time alone. */
export const now = signal(performance.now());
window.setInterval(() => { now.value = performance.now(); }, 500);

/** Seconds since the machine was last heard, when that is too long for values to be called live. */
export const oldFor = computed(() => {
  const silent = (now.value - lastHeard.value) / 1000;
  if (linkState.value === "open" && silent < 3) return 0;
  return lastHeard.value ? Math.max(1, Math.round(silent)) : 0;
});
export const isLive = computed(() => linkState.value === "open" && oldFor.value === 0);

export const mode = computed<Mode>(() => {
  if (obj("webhooks")?.state === "shutdown") return "Alarm";
  const told = obj("velvet")?.mode;
  if (told) return told;
  const state = obj("print_stats")?.state;
  return state === "printing" ? "Run" : state === "paused" ? "Hold" : "Idle";
});
export const kind = computed(() => obj("velvet")?.machine ?? "printer");
export const isPrinter = computed(() => kind.value === "printer");
export const isPlaying = computed(() => {
  const state = obj("print_stats")?.state;
  return state === "printing" || state === "paused";
});
/** Jogging, homing and heating by hand are for a machine that does nothing else. */
export const isFree = computed(() => isLive.value && (mode.value === "Idle" || mode.value === "Jog") && obj("print_stats")?.state !== "printing");
export const heaterNames = computed(() => obj("heaters")?.available_heaters ?? []);
export const sensorNames = computed(() => (obj("heaters")?.available_sensors ?? []).filter((name) => !heaterNames.value.includes(name)));
