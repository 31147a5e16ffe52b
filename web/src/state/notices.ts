// What the page tells its user for a moment: refusals and things done.
import { signal } from "@preact/signals";
import type { Method, Params, Result } from "../api/types";
import { call } from "../api/link";

export interface Notice { id: number; level: "done" | "info" | "error"; text: string; action?: { label: string; act: () => void } }
export const notices = signal<Notice[]>([]);
let lastId = 0;

export function say(level: Notice["level"], text: string, action?: Notice["action"]): void {
  if (notices.peek().some((one) => one.text === text && !action)) return;
  const id = ++lastId;
  notices.value = [...notices.peek().slice(-3), { id, level, text, ...(action ? { action } : {}) }];
  window.setTimeout(() => dismiss(id), level === "error" || action ? 9000 : 4000);
}

export function dismiss(id: number): void {
  notices.value = notices.peek().filter((one) => one.id !== id);
}

/** Calls, and shows a refusal in the board's own words. */
export async function ask<M extends Method>(method: M, params: Params<M>): Promise<Result<M> | undefined> {
  try {
    return await call(method, params);
  } catch (error) {
    say("error", error instanceof Error ? error.message : String(error));
    return undefined;
  }
}

/** Lines of G-code, as typed on a console. */
export function script(text: string): Promise<string | undefined> {
  return ask("printer.gcode.script", { script: text });
}
