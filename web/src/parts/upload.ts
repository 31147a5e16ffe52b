// Uploads, one after another, with what has gone and how fast. XMLHttpRequest, as fetch does not tell of progress.
import { signal } from "@preact/signals";
import { say } from "../state/notices";
import { go } from "../state/route";

export interface Upload { id: number; name: string; size: number; sent: number; rate: number; state: "going" | "done" | "failed"; reason: string }
export const uploads = signal<Upload[]>([]);
/** The file whose window is open. */
export const openedFile = signal<string | null>(null);
/** How often a file is sent again whose link died, and how long after, ms. */
const AGAIN = 3;
const REST = 2000;
const queue: { id: number; file: File; folder: string; again: number }[] = [];
const requests = new Map<number, XMLHttpRequest>();
let lastId = 0;
let isBusy = false;

function change(id: number, fields: Partial<Upload>): void {
  uploads.value = uploads.peek().map((one) => (one.id === id ? { ...one, ...fields } : one));
}

export function putFiles(files: File[], folder: string): void {
  for (const file of files) {
    const id = ++lastId;
    uploads.value = [...uploads.peek(), { id, name: file.name, size: file.size, sent: 0, rate: 0, state: "going", reason: "" }];
    queue.push({ id, file, folder, again: AGAIN });
  }
  next();
}

function next(): void {
  const one = isBusy ? undefined : queue.shift();
  if (!one) return;
  isBusy = true;
  const form = new FormData();
  form.append("root", "gcodes");
  if (one.folder) form.append("path", one.folder);
  form.append("file", one.file, one.file.name);
  const request = new XMLHttpRequest();
  requests.set(one.id, request);
  const began = performance.now();
  request.upload.onprogress = (event) => change(one.id, { sent: Math.min(event.loaded, one.file.size), rate: event.loaded / Math.max(0.2, (performance.now() - began) / 1000) });
  let isStopped = false;
  request.onabort = () => { isStopped = true; };
  request.onloadend = () => {
    requests.delete(one.id);
    isBusy = false;
    if (!request.status && !isStopped && one.again > 0) {
      // The board keeps nothing of half a file: all of it goes again.
      change(one.id, { sent: 0, rate: 0 });
      queue.unshift({ ...one, again: one.again - 1 });
      setTimeout(next, REST);
      return;
    }
    if (request.status === 201 || request.status === 200) { change(one.id, { state: "done", sent: one.file.size }); say("done", `${one.file.name} is on the card.`, { label: "Look", act: () => { openedFile.value = one.folder ? `${one.folder}/${one.file.name}` : one.file.name; go("files"); } }); }
    else change(one.id, { state: "failed", reason: reasonOf(request) });
    next();
  };
  request.open("POST", "/server/files/upload");
  request.send(form);
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
  requests.get(id)?.abort();
}
export function clearUploads(): void { uploads.value = uploads.peek().filter((one) => one.state === "going"); }
