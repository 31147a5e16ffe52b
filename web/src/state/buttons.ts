// Buttons of people's own, kept in a file on the card so that every browser has the same, files of a folder to play, and
// macros of the printer.cfg.
import { computed, effect, signal } from "@preact/signals";
import { call, on } from "../api/link";
import { loadHelp } from "./history";
import { obj, objectNames } from "./machine";
import { ask, say, script } from "./notices";
import { onReady } from "./session";

/** A button: its words, the lines that it sends, and whether it asks before. */
export interface Macro { label: string; script: string; confirm: boolean }
const FOLDER = "macros";
const FILE = "buttons.json";
/** Longest script that the board takes at once, bytes. */
const MOST = 500;
export const macros = signal<Macro[]>([]);
/** Names of the files that can be played. */
export const played = signal<string[]>([]);

/** Names of the macros that are for people: those that begin with _ are for other macros. */
export const named = computed(() => objectNames.value.map((name) => /^gcode_macro ([^_].*)/.exec(name)?.[1]).filter((name) => name !== undefined));
const list = computed(() => obj("velvet")?.macros);

function read(value: unknown): Macro[] {
  if (!Array.isArray(value)) return [];
  return value.filter((one) => typeof one?.label === "string" && typeof one.script === "string").map(({ label, script, confirm }) => ({ label, script, confirm: confirm === true }));
}

async function load(): Promise<void> {
  // A card without the folder has no buttons.
  const found = await call("server.files.get_directory", { path: `gcodes/${FOLDER}` }).catch((error: { code?: number }) => (error.code === 404 ? { files: [] } : null));
  if (!found) return;
  const names = found.files.map((one) => one.filename);
  played.value = names.filter((name) => /\.(g|gcode|nc|ngc)$/i.test(name)).sort();
  if (!names.includes(FILE)) { macros.value = []; return; }
  await fetch(`/server/files/gcodes/${FOLDER}/${FILE}`).then((answer) => answer.json()).then((value) => { macros.value = read(value); }).catch(() => say("error", `${FOLDER}/${FILE} on the card cannot be read.`));
}

/** Keeps buttons on the card. Gives whether they are. */
export async function keep(all: Macro[]): Promise<boolean> {
  const form = new FormData();
  form.append("root", "gcodes");
  form.append("path", FOLDER);
  form.append("file", new File([JSON.stringify(all, null, 1)], FILE));
  const answer = await fetch("/server/files/upload", { method: "POST", body: form }).catch(() => null);
  if (answer?.ok) { macros.value = all; return true; }
  const said = await answer?.json().catch(() => null) as { error?: { message: string } } | null;
  say("error", said?.error?.message ?? "The buttons could not be kept.");
  return false;
}

/** Sends the lines of a button, a few at a time, until one is refused. */
export async function press(one: Macro): Promise<void> {
  let piece = "";
  for (const line of [...one.script.split("\n"), null]) {
    if (piece && (line === null || new TextEncoder().encode(`${piece}${line}`).length >= MOST)) {
      if (await script(piece) === undefined) return;
      piece = "";
    }
    if (line?.trim()) piece += `${line}\n`;
  }
}
export const play = (name: string) => ask("printer.print.start", { filename: `${FOLDER}/${name}` });

export function startButtons(): void {
  let known = list.peek();
  effect(() => {
    if (list.value === known) return;
    known = list.value;
    void call("printer.objects.list", {}).then(({ objects }) => { objectNames.value = objects; }).then(loadHelp).catch(() => undefined);
  });
  onReady(() => void load());
  on("notify_filelist_changed", ({ item, source_item }) => { if ([item.path, source_item?.path ?? FOLDER].some((path) => !path || path.startsWith(FOLDER))) void load(); });
}
