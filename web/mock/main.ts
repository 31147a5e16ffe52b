// The mock board's server: dist/ as the board sends it, the API over HTTP and WebSocket, uploads to memory.
import { createServer, type IncomingMessage, type ServerResponse } from "node:http";
import { createHash, randomBytes } from "node:crypto";
import { existsSync, readFileSync } from "node:fs";
import { join } from "node:path";
import type { AddressInfo } from "node:net";
import { WebSocketServer, type WebSocket } from "ws";
import type { AccessInfo, PasswordStep, Role } from "../src/api/types";
import { Api, type Client, Failure } from "./api";
import { Card } from "./files";
import { run } from "./gcode";
import { Machine } from "./machine";

export interface Wanted { web: string; port: number; kind: "printer" | "mill"; entry: "open" | "login" | "watch" | "first"; speed: number; bare?: boolean }
export interface Board { port: number; machine: Machine; api: Api; code: () => string; close: () => Promise<void> }

const KINDS: Record<string, string> = { html: "text/html; charset=utf-8", js: "text/javascript; charset=utf-8", css: "text/css; charset=utf-8", svg: "image/svg+xml", json: "application/json", png: "image/png" };

class Doors {
  password: string | null;
  readonly openRole: Role;
  readonly tokens = new Set<string>();
  pending: { password: string; code: string } | null = null;
  lastCode = "";

  constructor(entry: Wanted["entry"]) {
    this.password = entry === "first" ? null : "velvet-test";
    this.openRole = entry === "open" ? "Own" : entry === "watch" ? "Watch" : "Nobody";
  }
  role(cookie: string | undefined): Role {
    const token = /velvet=(\w+)/.exec(cookie ?? "")?.[1];
    return token && this.tokens.has(token) ? "Own" : this.openRole;
  }
  info(role: Role): AccessInfo {
    return { login_required: this.openRole === "Nobody", password_set: this.password !== null, role, default_source: "moonraker", available_sources: ["moonraker"] };
  }
  set(params: { password?: string; code?: string }, show: (code: string) => void): PasswordStep | "ok" {
    if (params.password) {
      this.lastCode = String(100000 + Math.floor(Math.random() * 900000));
      this.pending = { password: params.password, code: this.lastCode };
      show(this.lastCode);
      return { state: "confirm", shown_on: "consoles", expires_s: 300 };
    }
    if (!this.pending || params.code !== this.pending.code) throw new Failure(400, "That is not the code which the machine shows.");
    this.password = this.pending.password;
    this.pending = null;
    return "ok";
  }
}

async function body(request: IncomingMessage): Promise<Buffer> {
  const parts: Buffer[] = [];
  for await (const part of request) parts.push(part as Buffer);
  return Buffer.concat(parts);
}

function json(response: ServerResponse, status: number, value: unknown, headers: Record<string, string> = {}): void {
  response.writeHead(status, { "Content-Type": "application/json", ...headers });
  response.end(JSON.stringify(value));
}

async function enter(doors: Doors, request: IncomingMessage, response: ServerResponse): Promise<void> {
  const given = JSON.parse((await body(request)).toString() || "{}") as { username?: string; password?: string };
  if (request.url === "/access/logout") {
    doors.tokens.delete(/velvet=(\w+)/.exec(request.headers.cookie ?? "")?.[1] ?? "");
    json(response, 200, { result: { username: "owner", action: "user_logged_out" } }, { "Set-Cookie": "velvet=; Max-Age=0; Path=/" });
  } else if (given.password === doors.password && doors.password) {
    const token = randomBytes(16).toString("hex");
    doors.tokens.add(token);
    json(response, 200, { result: { username: "owner", role: "Own", action: "user_logged_in" } }, { "Set-Cookie": `velvet=${token}; HttpOnly; SameSite=Strict; Path=/` });
  } else json(response, 401, { error: { code: 401, message: "That is not the password." } });
}

/** Parts of uploads that broke off, by their digests. */
const parts = new Map<string, Buffer>();

async function upload(api: Api, request: IncomingMessage, response: ServerResponse): Promise<void> {
  const digest = String(request.headers["upload-checksum"] ?? "");
  const from = Number(request.headers["upload-offset"] ?? 0);
  if (from !== (from ? parts.get(digest)?.length : 0)) { json(response, 409, { error: { code: 409, message: "this is not where what has come of the file ends: ask where it does" } }); return; }
  if (api.cutUploadAt) {
    // The link dies, with so much of the file on the card, until the page asks how much that is: browsers try once more by themselves.
    const cut = api.cutUploadAt;
    const come: Buffer[] = [];
    request.on("data", (piece: Buffer) => {
      come.push(piece);
      const all = Buffer.concat(come);
      const file = all.indexOf("\r\n\r\n", all.indexOf('name="file"')) + 4;
      if (all.length < file + cut) return;
      parts.set(digest, all.subarray(file, file + cut));
      request.socket.destroy();
    });
    return;
  }
  const form = await new Request("http://mock/", { method: "POST", headers: { "Content-Type": request.headers["content-type"] ?? "" }, body: new Uint8Array(await body(request)) }).formData();
  const file = form.get("file") as File | null;
  if (!file) { json(response, 400, { error: { code: 400, message: "There is no file in it." } }); return; }
  const folder = String(form.get("path") ?? "");
  const path = folder ? `${folder}/${file.name}` : file.name;
  const whole = Buffer.concat([from ? parts.get(digest)! : Buffer.alloc(0), Buffer.from(await file.arrayBuffer())]);
  if (digest && createHash("sha256").update(whole).digest("hex") !== digest) { json(response, 422, { error: { code: 422, message: "the file has another checksum than was said" } }); return; }
  parts.delete(digest);
  api.uploadedFrom = from;
  api.card.files.set(path, { bytes: whole, modified: Date.now() / 1000 });
  api.changed("create_file", path);
  json(response, 201, { item: { path, root: "gcodes", modified: Date.now() / 1000, size: file.size, permissions: "rw" }, print_started: false, print_queued: false, action: "create_file" });
}

function download(api: Api, path: string, request: IncomingMessage, response: ServerResponse): void {
  const picture = api.card.thumbnail(path);
  const bytes = picture ?? api.card.files.get(path)?.bytes;
  if (!bytes) { json(response, 404, { error: { code: 404, message: "There is no such file." } }); return; }
  const range = /bytes=(\d+)-(\d*)/.exec(request.headers.range ?? "");
  const from = range ? Number(range[1]) : 0;
  const to = range?.[2] ? Math.min(Number(range[2]), bytes.length - 1) : bytes.length - 1;
  response.writeHead(range ? 206 : 200, {
    "Content-Type": picture ? "image/png" : "text/plain; charset=utf-8", "Content-Length": to - from + 1, "X-Content-Type-Options": "nosniff",
    ...(range ? { "Content-Range": `bytes ${from}-${to}/${bytes.length}` } : {}), ...(picture ? {} : { "Content-Disposition": "attachment" }),
  });
  response.end(bytes.subarray(from, to + 1));
}

function page(web: string, url: string, response: ServerResponse): void {
  const name = url === "/" ? "index.html" : url.slice(1);
  const file = join(web, "dist", `${name}.gz`);
  if (!/^[\w.-]+$/.test(name) || !existsSync(file)) { json(response, 404, { error: { code: 404, message: "Not found" } }); return; }
  response.writeHead(200, {
    "Content-Type": KINDS[name.split(".").pop()!] ?? "text/plain", "Content-Encoding": "gzip", "Cache-Control": url === "/" ? "no-cache" : "public, max-age=31536000, immutable",
    "Content-Security-Policy": "default-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'self'", "X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer",
  });
  response.end(readFileSync(file));
}

function attach(api: Api, doors: Doors, clients: Map<WebSocket, Client>, socket: WebSocket, cookie: string | undefined): void {
  const client: Client = { role: doors.role(cookie), watches: new Set(), told: new Map(), hear: (line) => socket.send(JSON.stringify({ jsonrpc: "2.0", method: "notify_velvet_answer", params: [line] })) };
  clients.set(socket, client);
  socket.on("close", () => clients.delete(socket));
  socket.on("message", async (data) => {
    const asked = JSON.parse(data.toString());
    const { id, method, params } = asked;
    try {
      const result = method === "access.info" ? doors.info(client.role)
        : method === "access.get_user" ? { username: "owner", source: "moonraker", created_on: 0, role: client.role }
        : method === "velvet.password.set" ? doors.set(params, (code) => { api.say(`// the code for the new password is ${code}`); console.log(`code ${code}`); })
        : await api.answer(method, params, client);
      if (id !== undefined) socket.send(JSON.stringify({ jsonrpc: "2.0", result, id }));
    } catch (error) {
      const code = error instanceof Failure ? error.code : 500;
      if (id !== undefined) socket.send(JSON.stringify({ jsonrpc: "2.0", error: { code, message: (error as Error).message }, id }));
    }
  });
}

/** What has changed since a client was told, field by field. */
function changes(api: Api, client: Client): Record<string, object> {
  const out: Record<string, Record<string, unknown>> = {};
  for (const [name, all] of Object.entries(api.machine.world as unknown as Record<string, Record<string, unknown>>)) {
    if (!client.watches.has(name)) continue;
    for (const [field, value] of Object.entries(all)) {
      const text = JSON.stringify(value);
      if (client.told.get(`${name}.${field}`) === text) continue;
      client.told.set(`${name}.${field}`, text);
      out[name] ??= {};
      out[name][field] = value;
    }
  }
  return out;
}

export async function serve(wanted: Wanted): Promise<Board> {
  const card = new Card(wanted.kind);
  const machine = new Machine(card, wanted.kind, wanted.speed);
  const api = new Api(machine, card, wanted.web, wanted.bare ?? false);
  const doors = new Doors(wanted.entry);
  const clients = new Map<WebSocket, Client>();
  const send = (socket: WebSocket, method: string, params: unknown[]) => socket.send(JSON.stringify({ jsonrpc: "2.0", method, params }));
  api.notify = (method, ...params) => { for (const [socket, client] of clients) if (client.role !== "Nobody") send(socket, method, params); };

  const server = createServer((request, response) => {
    const url = decodeURIComponent((request.url ?? "/").split("?")[0]!);
    const allowed = doors.role(request.headers.cookie) !== "Nobody";
    if (request.method === "POST" && url.startsWith("/access/")) void enter(doors, request, response);
    else if (request.method === "POST" && url === "/printer/emergency_stop") json(response, allowed ? 200 : 401, { result: allowed ? run(machine, "M112") : "" });
    else if (url.startsWith("/server/files/") && !allowed) json(response, 401, { error: { code: 401, message: "Log in first." } });
    else if (request.method === "POST" && url === "/server/files/upload") void upload(api, request, response);
    else if (url === "/server/files/upload") {
      api.cutUploadAt = 0;
      json(response, 200, { result: { offset: parts.get(String(request.headers["upload-checksum"]))?.length ?? 0 } });
    }
    else if (url.startsWith("/server/files/gcodes/")) download(api, url.slice(21), request, response);
    else page(wanted.web, url, response);
  });
  const sockets = new WebSocketServer({ server, path: "/websocket" });
  sockets.on("connection", (socket, request) => attach(api, doors, clients, socket, request.headers.cookie));
  const timers = [
    setInterval(() => machine.tick(0.05), 50),
    setInterval(() => {
      for (const [socket, client] of clients) {
        const changed = client.watches.size ? changes(api, client) : {};
        if (Object.keys(changed).length) send(socket, "notify_status_update", [changed, api.now()]);
      }
    }, 250),
    setInterval(() => { api.keepTemperatures(); api.notify("notify_proc_stat_update", { system_cpu_usage: { cpu: 4.2 + Math.random() }, cpu_temp: 44 }); }, 1000),
  ];
  await new Promise<void>((done) => { server.listen(wanted.port, "127.0.0.1", done); });
  return {
    port: (server.address() as AddressInfo).port, machine, api, code: () => doors.lastCode,
    close: async () => { timers.forEach(clearInterval); for (const socket of clients.keys()) socket.terminate(); server.closeAllConnections(); await new Promise((done) => { server.close(done); }); },
  };
}
