// Who looks at this page and what they may: login, first password, role.
import { computed, signal } from "@preact/signals";
import { call, connect, linkState, onOpen, reconnect } from "../api/link";
import type { AccessInfo, Method, Role } from "../api/types";
import { ROLES } from "../api/types";
import { subscribe } from "./machine";
import { say } from "./notices";

export const access = signal<AccessInfo | null>(null);
export const isReady = signal(false);
export const wantsLogin = signal(false);

const ORDER: Role[] = ["Nobody", "Watch", "Operate", "Own"];
export const role = computed<Role>(() => access.value?.role ?? "Nobody");
export function mayCall(method: Method): boolean {
  return ORDER.indexOf(role.value) >= ORDER.indexOf(ROLES[method]);
}
export const mayOperate = computed(() => mayCall("printer.gcode.script"));
export const isOwner = computed(() => mayCall("server.files.delete_file"));

const opened = new Set<() => void>();
/** Calls `then` whenever there is a connection that may watch. */
export function onReady(then: () => void): void {
  opened.add(then);
  if (isReady.peek()) then();
}

async function begin(): Promise<void> {
  try {
    await call("server.connection.identify", { client_name: "velvet-page", version: "1", type: "web", url: location.origin });
    access.value = await call("access.info", {});
    if (access.value.role === "Nobody") {
      isReady.value = false;
      return;
    }
    await subscribe();
    isReady.value = true;
    for (const then of opened) then();
  } catch (error) {
    say("error", error instanceof Error ? error.message : "The machine did not answer.");
    window.setTimeout(() => { if (linkState.peek() === "open") void begin(); }, 3000);
  }
}

interface LoginAnswer { result?: { role: Role }; error?: { message: string } }

async function post(path: string, body: object): Promise<LoginAnswer> {
  const answer = await fetch(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });
  return await answer.json() as LoginAnswer;
}

/** By HTTP, so that the cookie is one that no script can read; the socket then begins anew with it. */
export async function login(username: string, password: string): Promise<string | null> {
  try {
    const answer = await post("/access/login", { username, password });
    if (answer.error) return answer.error.message;
    wantsLogin.value = false;
    reconnect();
    return null;
  } catch {
    return "The machine does not answer.";
  }
}

export async function logout(): Promise<void> {
  await post("/access/logout", {}).catch(() => undefined);
  reconnect();
}

export function start(): void {
  onOpen(() => void begin());
  connect();
}
