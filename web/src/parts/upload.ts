// Uploads, one after another, with what has gone and how fast. XMLHttpRequest, as fetch does not tell of progress.
// A large file goes with its digest: where the link dies, it goes on from where it stopped when the link is back.
import { signal } from "@preact/signals";
import { linkState } from "../api/link";
import { say } from "../state/notices";
import { go } from "../state/route";
import { Sha256 } from "./sha256";

export interface Upload { id: number; name: string; size: number; sent: number; rate: number; state: "going" | "done" | "failed"; reason: string }
export const uploads = signal<Upload[]>([]);
/** The file whose window is open. */
export const openedFile = signal<string | null>(null);

interface Sending { id: number; file: File; folder: string; digest: string; isStopped: boolean; request?: XMLHttpRequest }
/** Size from which a digest is worth its time, bytes; and bytes that are read for it together. */
const LARGE = 100_000;
const PIECE = 1 << 20;
/** How often a file is sent again of which nothing more comes through, how long after, and how long nothing may go, ms. */
const AGAIN = 30;
const REST = 2000;
const STALLED = 20_000;
const queue: Sending[] = [];
let current: Sending | null = null;
let lastId = 0;

function change(id: number, fields: Partial<Upload>): void {
  uploads.value = uploads.peek().map((one) => (one.id === id ? { ...one, ...fields } : one));
}

export function putFiles(files: File[], folder: string): void {
  for (const file of files) {
    const id = ++lastId;
    uploads.value = [...uploads.peek(), { id, name: file.name, size: file.size, sent: 0, rate: 0, state: "going", reason: "" }];
    queue.push({ id, file, folder, digest: "", isStopped: false });
  }
  void next();
}

async function next(): Promise<void> {
  if (current) return;
  current = queue.shift() ?? null;
  if (!current) return;
  const one = current;
  const failed = await put(one).catch((error: Error) => error.message);
  if (failed) change(one.id, { state: "failed", reason: failed });
  else {
    change(one.id, { state: "done", sent: one.file.size });
    say("done", `${one.file.name} is on the card.`, { label: "Look", act: () => { openedFile.value = one.folder ? `${one.folder}/${one.file.name}` : one.file.name; go("files"); } });
  }
  current = null;
  void next();
}

/** Sends a file, in as many goes as it takes. Gives why it did not go. */
async function put(one: Sending): Promise<string> {
  if (one.file.size >= LARGE) one.digest = await digestOf(one);
  let from = 0;
  for (let again = AGAIN; ; again--) {
    if (one.isStopped) return "It was broken off.";
    const { status, reason } = await send(one, from);
    if (status === 201 || status === 200) return "";
    // 409: the part that was there is gone. 503: the connection that died still has its place.
    if (status && !(one.digest && (status === 409 || status === 503))) return reason;
    if (one.isStopped || !again) return "It was broken off.";
    change(one.id, { rate: 0, reason: "waits for the connection" });
    do await new Promise((done) => { setTimeout(done, REST); }); while (linkState.peek() !== "open" && !one.isStopped);
    const offset = one.digest ? await partOf(one.digest) : 0;
    if (offset > from) again = AGAIN;
    from = offset;
    change(one.id, { sent: from, reason: "" });
  }
}

async function digestOf(one: Sending): Promise<string> {
  const hash = new Sha256();
  for (let at = 0; at < one.file.size && !one.isStopped; at += PIECE) hash.add(new Uint8Array(await one.file.slice(at, at + PIECE).arrayBuffer()));
  return hash.hex();
}

/** How much of a file is on the board. */
async function partOf(digest: string): Promise<number> {
  try {
    const answer = await fetch("/server/files/upload", { headers: { "Upload-Checksum": digest } });
    return ((await answer.json()) as { result: { offset: number } }).result.offset;
  } catch {
    return 0;
  }
}

function send(one: Sending, from: number): Promise<{ status: number; reason: string }> {
  const form = new FormData();
  form.append("root", "gcodes");
  if (one.folder) form.append("path", one.folder);
  form.append("file", from ? one.file.slice(from) : one.file, one.file.name);
  const request = new XMLHttpRequest();
  one.request = request;
  const began = performance.now();
  let timer = 0;
  const watch = () => { clearTimeout(timer); timer = window.setTimeout(() => request.abort(), STALLED); };
  request.upload.onprogress = (event) => {
    watch();
    change(one.id, { sent: Math.min(from + event.loaded, one.file.size), rate: event.loaded / Math.max(0.2, (performance.now() - began) / 1000) });
  };
  // The board may take its time with what is whole.
  request.upload.onload = () => clearTimeout(timer);
  request.open("POST", "/server/files/upload");
  if (one.digest) {
    request.setRequestHeader("Upload-Checksum", one.digest);
    request.setRequestHeader("Upload-Offset", String(from));
  }
  return new Promise((done) => {
    request.onloadend = () => { clearTimeout(timer); done({ status: request.status, reason: reasonOf(request) }); };
    watch();
    request.send(form);
  });
}

function reasonOf(request: XMLHttpRequest): string {
  try {
    return (JSON.parse(request.responseText) as { error: { message: string } }).error.message;
  } catch {
    return request.status ? `The machine refused it (${request.status}).` : "It was broken off.";
  }
}

export function cancelUpload(id: number): void {
  const waiting = queue.findIndex((one) => one.id === id);
  if (waiting >= 0) { queue.splice(waiting, 1); change(id, { state: "failed", reason: "It was broken off." }); }
  if (current?.id === id) { current.isStopped = true; current.request?.abort(); }
}
export function clearUploads(): void { uploads.value = uploads.peek().filter((one) => one.state === "going"); }
