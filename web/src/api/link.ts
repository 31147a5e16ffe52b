// One WebSocket to the board: calls with answers, notifications, and a connection that comes back by itself.
import { signal } from "@preact/signals";
import type { Method, Notification, Notifications, Params, Result, RpcError } from "./types";

export type LinkState = "connecting" | "open" | "lost";

/** What the board refused, in its words. */
export class Refused extends Error {
  readonly code: number;
  constructor(error: RpcError) {
    super(error.message);
    this.code = error.code;
  }
  /** The board does not know the method: an older one, or a part that is not in it. */
  get isUnknown(): boolean {
    return this.code === -32601;
  }
}

export const linkState = signal<LinkState>("connecting");
/** When the last message came (performance.now), and when the connection will be tried again. */
export const lastHeard = signal(0);
export const retryAt = signal(0);

const BEAT_MS = 1000;
const SILENCE_MS = 8000;
const ANSWER_MS = 20000;
/** Those that end when the machine has done it, however long that takes. */
const UNHURRIED = new Set<Method>(["printer.gcode.script", "velvet.ask", "printer.print.cancel"]);

interface Waiting { done: (value: unknown) => void; failed: (error: Error) => void; timer: number }

let socket: WebSocket | null = null;
let lastId = 0;
let attempts = 0;
let retryTimer = 0;
const waiting = new Map<number, Waiting>();
const listeners = new Map<string, Set<(params: unknown[]) => void>>();
const openings = new Set<() => void>();

export function on<N extends Notification>(name: N, listener: (...params: Notifications[N]) => void): () => void {
  const all = listeners.get(name) ?? new Set();
  listeners.set(name, all);
  const wrapped = (params: unknown[]) => listener(...(params as Notifications[N]));
  all.add(wrapped);
  return () => all.delete(wrapped);
}

/** Calls `then` at each connection made. */
export function onOpen(then: () => void): void {
  openings.add(then);
}

export function call<M extends Method>(method: M, params: Params<M>): Promise<Result<M>> {
  return new Promise((done, failed) => {
    if (!socket || socket.readyState !== WebSocket.OPEN) {
      failed(new Error("There is no connection to the machine."));
      return;
    }
    const id = ++lastId;
    const timer = UNHURRIED.has(method) ? 0 : window.setTimeout(() => settle(id, undefined, new Error("The machine did not answer.")), ANSWER_MS);
    waiting.set(id, { done: done as (value: unknown) => void, failed, timer });
    socket.send(JSON.stringify({ jsonrpc: "2.0", method, params, id }));
  });
}

/** Sends what wants no answer: beats of a jog. */
export function tell<M extends Method>(method: M, params: Params<M>): void {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ jsonrpc: "2.0", method, params }));
}

function settle(id: number, value: unknown, error?: Error): void {
  const one = waiting.get(id);
  if (!one) return;
  waiting.delete(id);
  clearTimeout(one.timer);
  if (error) one.failed(error);
  else one.done(value);
}

function take(text: string): void {
  lastHeard.value = performance.now();
  const message: unknown = JSON.parse(text);
  for (const one of Array.isArray(message) ? message : [message]) {
    if (typeof one.method === "string") {
      for (const listener of listeners.get(one.method) ?? []) listener(one.params ?? []);
    } else if (typeof one.id === "number") {
      settle(one.id, one.result, one.error ? new Refused(one.error) : undefined);
    }
  }
}

function lost(): void {
  socket = null;
  for (const id of [...waiting.keys()]) settle(id, undefined, new Error("The connection broke off."));
  linkState.value = "lost";
  const wait = Math.min(5000, 300 * 1.6 ** Math.min(attempts++, 8));
  retryAt.value = performance.now() + wait;
  clearTimeout(retryTimer);
  retryTimer = window.setTimeout(connect, wait);
}

export function connect(): void {
  clearTimeout(retryTimer);
  if (socket) return;
  const made = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/websocket`);
  socket = made;
  made.onopen = () => {
    attempts = 0;
    lastHeard.value = performance.now();
    linkState.value = "open";
    for (const then of openings) then();
  };
  made.onmessage = (event) => { if (socket === made) take(String(event.data)); };
  made.onclose = () => { if (socket === made) lost(); };
}

/** Begins anew, with the cookies of now. */
export function reconnect(): void {
  const old = socket;
  socket = null;
  old?.close();
  for (const id of [...waiting.keys()]) settle(id, undefined, new Error("The connection was closed."));
  attempts = 0;
  connect();
}

/** The machine speaks once a second at least: silence means a link that died without a word. */
window.setInterval(() => {
  const silent = performance.now() - lastHeard.value;
  if (linkState.value === "open" && silent > SILENCE_MS) {
    const dead = socket;
    lost();
    dead?.close();
  }
}, BEAT_MS);
window.addEventListener("online", connect);
