// Files on the card: folders, pictures, uploads by button or drop, and a look at what a job asks before it starts.
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Directory, FileEntry, Metadata } from "../api/types";
import { inquire } from "../api/inquire";
import { call, on } from "../api/link";
import { Bar, Button, Card, Dialog, Empty } from "../shell/parts";
import { baseName, bytes, clock, duration, num } from "../shell/format";
import { Icon } from "../shell/icon";
import { isLive, isPlaying, mode, obj } from "../state/machine";
import { ask, say } from "../state/notices";
import { isOwner, mayOperate } from "../state/session";
import { thumbnailUrl } from "../parts/job";
import { type Preflight, readPreflight } from "../parts/preflight";
import { Preview } from "../parts/preview";
import { cancelUpload, clearUploads, openedFile, putFiles, uploads } from "../parts/upload";

const isJob = (name: string) => /\.(gcode|gco|g|ngc|nc|tap)$/i.test(name);
/** Pictures and figures of files, kept while the page is open. */
const known = new Map<string, Metadata>();

/** How often a question is asked again that the board has no room for, and how long after, ms. */
const AGAIN = 5;
const REST = 300;
async function patiently<T>(question: () => Promise<T>): Promise<T> {
  for (let again = AGAIN; ; again--) {
    try {
      return await question();
    } catch (error) {
      if ((error as { code?: number }).code !== 503 || !again) throw error;
      await new Promise((done) => { setTimeout(done, REST); });
    }
  }
}

/** One question at a time: the board reads a file's head and tail for each, and has other things to do. */
let lastQuestion: Promise<unknown> = Promise.resolve();
function metadataOf(path: string, isWanted: () => boolean): Promise<Metadata | undefined> {
  const mine = lastQuestion.then(() => (isWanted() ? patiently(() => call("server.files.metadata", { filename: path })) : undefined)).catch(() => undefined);
  lastQuestion = mine;
  return mine;
}

/** What is known of a file, asked for when its card comes into sight. */
function useMeta(path: string, modified: number) {
  const at = useRef<HTMLLIElement>(null);
  const meta = useSignal<Metadata | undefined>(known.get(`${path}@${modified}`));
  useEffect(() => {
    if (meta.peek() || !isJob(path)) return undefined;
    let isThere = true;
    const watcher = new IntersectionObserver((seen) => {
      if (!seen.some((one) => one.isIntersecting)) return;
      watcher.disconnect();
      void metadataOf(path, () => isThere).then((found) => { if (found) { known.set(`${path}@${modified}`, found); meta.value = found; } });
    }, { rootMargin: "200px" });
    if (at.current) watcher.observe(at.current);
    return () => { isThere = false; watcher.disconnect(); };
  }, [path, modified]);
  return { at, meta: meta.value };
}

function FileCard({ path, entry, onOpen }: { path: string; entry: FileEntry; onOpen: (path: string) => void }) {
  const { at, meta } = useMeta(path, entry.modified);
  const picture = meta && thumbnailUrl(meta, 180);
  const facts = [meta?.estimated_time && duration(meta.estimated_time), meta?.filament_total && `${num(meta.filament_total / 1000, 1)} m`, bytes(entry.size)].filter(Boolean);
  return (
    <li ref={at}>
      <button type="button" class="filecard" onClick={() => onOpen(path)}>
        <span class="picture">{picture ? <img src={picture} alt="" loading="lazy" /> : <Icon name={isJob(path) ? "job" : "files"} />}</span>
        <b>{entry.filename}</b>
        <small>{facts.join(" · ")}</small>
        <small>{clock(entry.modified)}</small>
      </button>
    </li>
  );
}

function Findings({ found }: { found: Preflight }) {
  return (
    <>
      {!found.findings.length && <p class="good row"><Icon name="check" /> Nothing stands in the way.</p>}
      <ul class="findings">
        {found.findings.map((one, at) => (
          <li key={at} class={one.stops ? "stops" : "warning"}>
            <span class={`tag ${one.stops ? "bad" : "warn"}`}>{one.file ? `${one.file}, ` : ""}line {one.line}</span>
            <span><b>{one.stops ? "Stops: " : ""}</b>{one.text} <small>({one.remedy})</small></span>
          </li>
        ))}
      </ul>
      {found.totals.map((one) => <p key={one} class="quiet">{one}</p>)}
    </>
  );
}

/** A button that asks once more, in its own place. */
function SureButton({ onSure, children }: { onSure: () => unknown; children: string }) {
  const isAsked = useSignal(false);
  return isAsked.value
    ? <Button icon="trash" kind="danger" onPress={onSure}>{`${children} for good`}</Button>
    : <Button icon="trash" kind="plain" onPress={() => { isAsked.value = true; }}>{children}</Button>;
}

/** What a file is, what the machine would say to it, and the button that starts it. */
function FileDialog({ path, onClose }: { path: string; onClose: () => void }) {
  const meta = useSignal<Metadata | undefined>(undefined);
  const found = useSignal<Preflight | null>(null);
  const failed = useSignal<string | null>(null);
  const name = useSignal<string | null>(null);
  const isSeen = useSignal(false);
  useEffect(() => {
    void call("server.files.metadata", { filename: path }).then((one) => { meta.value = one; }).catch(() => undefined);
    if (isJob(path)) void inquire(`check "/sd/${path}"`).then((lines) => { found.value = readPreflight(lines); }).catch((error: Error) => { failed.value = error.message; });
  }, [path]);
  const start = async () => { if (await ask("printer.print.start", { filename: path })) { onClose(); location.hash = "#/job"; } };
  const rename = async () => {
    const to = name.peek();
    if (to && to !== path && await ask("server.files.move", { source: `gcodes/${path}`, dest: `gcodes/${to}` })) onClose();
    else name.value = null;
  };
  const remove = async () => { if (await ask("server.files.delete_file", { path: `gcodes/${path}` })) { say("done", `${baseName(path)} is removed.`); onClose(); } };
  const one = meta.value;
  const picture = one && thumbnailUrl(one, 180);
  const stops = found.value?.findings.some((finding) => finding.stops);
  const facts: [string, string | undefined][] = [
    ["Size", bytes(one?.size)], ["Foreseen", one?.estimated_time ? duration(one.estimated_time) : undefined],
    ["Filament", one?.filament_total ? `${num(one.filament_total / 1000, 1)} m ${one.filament_type ?? ""}` : undefined], ["Layer", one?.layer_height ? `${one.layer_height} mm` : undefined], ["Made by", one?.slicer],
  ];
  return (
    <Dialog title={baseName(path)} onClose={onClose} wide>
      <div class="filedetail">
        {picture && <img src={picture} alt="" />}
        <dl class="facts">{facts.filter(([, value]) => value).map(([what, value]) => <div key={what}><dt>{what}</dt><dd>{value}</dd></div>)}</dl>
      </div>
      {isJob(path) && (
        <section class="sunk" aria-label="What the machine says to it" aria-busy={!found.value && !failed.value}>
          <h3>Preflight</h3>
          {found.value ? <Findings found={found.value} /> : failed.value ? <p class="wrong">{failed.value}</p> : <p class="quiet">The machine reads the file…</p>}
        </section>
      )}
      {isSeen.value && <Preview path={path} />}
      {name.value !== null && (
        <form class="row" onSubmit={(event) => { event.preventDefault(); void rename(); }}>
          <input type="text" aria-label="New name" value={name.value} onInput={(event) => { name.value = event.currentTarget.value; }} /><Button kind="main" submit>Rename</Button>
        </form>
      )}
      <div class="row wrap end">
        <a class="button plain" href={`/server/files/gcodes/${path.split("/").map(encodeURIComponent).join("/")}`} download={baseName(path)}><Icon name="download" /><span>Download</span></a>
        {isOwner.value && <Button icon="edit" kind="plain" onPress={() => { name.value = path; }}>Rename</Button>}
        {isOwner.value && <SureButton onSure={remove}>Remove</SureButton>}
        {isJob(path) && <Button icon="job" kind="plain" pressed={isSeen.value} onPress={() => { isSeen.value = !isSeen.peek(); }}>Path</Button>}
        <span class="grow" />
        {isJob(path) && <Button icon="play" kind={stops ? "danger" : "main"} class="big" disabled={!mayOperate.value || !isLive.value || isPlaying.value || mode.value === "Alarm"} onPress={start}>{stops ? "Start all the same" : "Start"}</Button>}
      </div>
      {isPlaying.value && <p class="note">Another job is running: {baseName(obj("print_stats")?.filename ?? "")}.</p>}
    </Dialog>
  );
}

function Uploads() {
  const all = uploads.value;
  if (!all.length) return null;
  return (
    <Card title="Uploads" aside={all.every((one) => one.state !== "going") && <Button kind="plain" onPress={clearUploads}>Clear</Button>}>
      <ul class="uploads">
        {all.map((one) => (
          <li key={one.id}>
            <span class="grow"><b>{one.name}</b> <small class={one.state === "failed" ? "wrong" : ""}>{one.state === "going" && !one.reason ? `${bytes(one.sent)} of ${bytes(one.size)}${one.rate ? `, ${bytes(one.rate)}/s` : ""}` : one.state === "done" ? "is on the card" : one.reason}</small></span>
            {one.state === "going" && <Button icon="cancel" kind="plain" label={`Stop ${one.name}`} onPress={() => cancelUpload(one.id)} />}
            <Bar part={one.state === "done" ? 1 : one.size ? one.sent / one.size : 0} label={`${one.name}: sent`} />
          </li>
        ))}
      </ul>
    </Card>
  );
}

function NewFolder({ path, onClose }: { path: (name: string) => string; onClose: () => void }) {
  const make = (event: Event) => {
    event.preventDefault();
    const name = String(new FormData(event.currentTarget as HTMLFormElement).get("name")).trim();
    onClose();
    if (name) void ask("server.files.post_directory", { path: `gcodes/${path(name)}` });
  };
  return (
    <Dialog title="New folder" onClose={onClose}>
      <form class="form" onSubmit={make}>
        <label>Name<input type="text" name="name" required /></label>
        <div class="row end"><Button kind="main" submit>Make it</Button></div>
      </form>
    </Dialog>
  );
}

const SORTS = { modified: "Newest", filename: "Name", size: "Size" } as const;

export function FilesView() {
  const folder = useSignal("");
  const listing = useSignal<Directory | null>(null);
  const looked = useSignal("");
  const sort = useSignal<keyof typeof SORTS>("modified");
  const over = useSignal(false);
  const newFolder = useSignal(false);
  const picker = useRef<HTMLInputElement>(null);
  const load = async () => {
    const path = `gcodes${folder.peek() ? `/${folder.peek()}` : ""}`;
    await patiently(() => call("server.files.get_directory", { path })).then((found) => { listing.value = found; }).catch((error: Error) => say("error", error.message));
  };
  const enter = (to: string) => { folder.value = to; listing.value = null; void load(); };
  useEffect(() => { void load(); return on("notify_filelist_changed", () => void load()); }, []);
  const removeFolder = async () => { if (await ask("server.files.delete_directory", { path: `gcodes/${folder.peek()}`, force: true })) enter(folder.peek().split("/").slice(0, -1).join("/")); };
  const inside = (name: string) => (folder.value ? `${folder.value}/${name}` : name);
  const put = (files: FileList | null | undefined) => { if (files) putFiles([...files], folder.peek()); };
  const fits = (name: string) => name.toLowerCase().includes(looked.value.toLowerCase());
  const files = (listing.value?.files ?? []).filter((one) => fits(one.filename) && !one.filename.startsWith("."))
    .sort((a, b) => (sort.value === "filename" ? a.filename.localeCompare(b.filename) : b[sort.value] - a[sort.value]));
  const dirs = (listing.value?.dirs ?? []).filter((one) => fits(one.dirname) && !one.dirname.startsWith("."));
  const disk = listing.value?.disk_usage;
  return (
    <section
      class={`files ${over.value ? "over" : ""}`} aria-label="Files; drop some here to upload them"
      onDragOver={(event) => { event.preventDefault(); over.value = true; }} onDragLeave={(event) => { if (event.target === event.currentTarget) over.value = false; }}
      onDrop={(event) => { event.preventDefault(); over.value = false; put(event.dataTransfer?.files); }}
    >
      <h1 class="unseen">Files</h1>
      <div class="row wrap toolbar">
        <nav class="crumbs" aria-label="Folder">
          <button type="button" onClick={() => enter("")}>Card</button>
          {folder.value?.split("/").filter(Boolean).map((part, at, all) => <span key={part}> / <button type="button" onClick={() => enter(all.slice(0, at + 1).join("/"))}>{part}</button></span>)}
        </nav>
        <input type="search" class="search" data-slash placeholder="Find" aria-label="Find files" value={looked.value} onInput={(event) => { looked.value = event.currentTarget.value; }} />
        <select aria-label="Order" value={sort.value} onChange={(event) => { sort.value = event.currentTarget.value as keyof typeof SORTS; }}>{Object.entries(SORTS).map(([key, text]) => <option key={key} value={key}>{text}</option>)}</select>
        {folder.value && isOwner.value && <SureButton key={folder.value} onSure={removeFolder}>Remove folder</SureButton>}
        <Button icon="folder" label="New folder" disabled={!mayOperate.value} onPress={() => { newFolder.value = true; }} />
        <input ref={picker} type="file" class="unseen" multiple tabIndex={-1} aria-label="Files to upload" onChange={(event) => { put(event.currentTarget.files); event.currentTarget.value = ""; }} />
        <Button icon="upload" kind="main" disabled={!mayOperate.value} onPress={() => picker.current?.click()}>Upload</Button>
      </div>
      <Uploads />
      {listing.value && !dirs.length && !files.length && <Empty>{looked.value ? "Nothing here is called so." : "There is nothing here yet. Drop files onto this page."}</Empty>}
      <ul class="filegrid">
        {dirs.map((one) => <li key={one.dirname}><button type="button" class="filecard folder" onClick={() => enter(inside(one.dirname))}><Icon name="files" /><b>{one.dirname}</b></button></li>)}
      </ul>
      <ul class="filegrid">{files.map((one) => <FileCard key={`${inside(one.filename)}@${one.modified}`} path={inside(one.filename)} entry={one} onOpen={(path) => { openedFile.value = path; }} />)}</ul>
      {disk && <p class="note">{bytes(disk.free)} of {bytes(disk.total)} are free.</p>}
      {openedFile.value && <FileDialog key={openedFile.value} path={openedFile.value} onClose={() => { openedFile.value = null; }} />}
      {newFolder.value && <NewFolder path={inside} onClose={() => { newFolder.value = false; }} />}
    </section>
  );
}
