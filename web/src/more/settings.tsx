// The configuration from its schema: found by words, explained, checked by the board before it is stored, and undone.
import { computed, signal, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { type Changes, check, type Findings, store as storeChanges } from "../parts/change";
import { nameOf, readIni, type Schema, type Setting, settingsOf, type Written } from "../parts/settings";
import { Button, Card, Choice, Empty } from "../shell/parts";
import { say, script } from "../state/notices";
import { isLive } from "../state/machine";
import { isOwner, wantsLogin } from "../state/session";

const schema = signal<Schema>({});
const written = signal<Written>(new Map());
/** Names that were added here, `section/name`, and have no line in the file yet. */
const added = signal<string[]>([]);
const all = computed(() => settingsOf(schema.value, written.value, added.value));
const changes = signal<Changes>({});
const findings = signal<Findings>({});
const isStoring = signal(false);
const needsRestart = signal(false);
const changed = computed(() => Object.keys(changes.value).length);

async function get(path: string): Promise<Response> {
  const answer = await fetch(path);
  if (answer.status === 404) throw new Error("There is no config.ini on the card.");
  if (!answer.ok) throw new Error("config.ini was not read: only the owner sees it.");
  return answer;
}

async function load(): Promise<void> {
  written.value = readIni(await (await get("/server/files/gcodes/config.ini")).text());
  if (!Object.keys(schema.peek()).length) schema.value = await (await get(document.getElementById("shell")?.dataset.settings ?? "")).json() as Schema;
}

let checkTimer = 0;
let checks = 0;
function change(one: Setting, value: string | null): void {
  const next = { ...changes.peek() };
  const now = one.isSet ? one.value : null;
  if (value === now || (value !== null && value === one.value)) delete next[nameOf(one)];
  else next[nameOf(one)] = value;
  changes.value = next;
  clearTimeout(checkTimer);
  const mine = ++checks;
  checkTimer = window.setTimeout(() => { void check(changes.peek()).then((wrong) => { if (mine === checks) findings.value = wrong; }); }, 300);
}

/** What would lead back to how things were. */
function opposite(of: Changes): Changes {
  return Object.fromEntries(Object.keys(of).map((name) => {
    const one = all.peek().find((setting) => nameOf(setting) === name);
    return [name, one?.isSet ? one.value : null];
  }));
}

async function store(wanted: Changes, undoes: boolean): Promise<void> {
  const back = opposite(wanted);
  isStoring.value = true;
  const wrong = await storeChanges(wanted);
  isStoring.value = false;
  await load().catch((error: Error) => say("error", error.message));
  findings.value = wrong;
  if (Object.keys(wrong).length) { say("error", `Not everything was stored: ${Object.values(wrong)[0]}`); return; }
  changes.value = {};
  needsRestart.value = true;
  const count = Object.keys(wanted).length;
  say("done", undoes ? "It is as it was." : `${count === 1 ? "One setting is" : `${count} settings are`} stored.`, undoes ? undefined : { label: "Undo", act: () => void store(back, true) });
}

function Field({ one, value }: { one: Setting; value: string }) {
  const label = `${one.section}, ${one.key}`;
  const disabled = !isOwner.value;
  if (one.type === "boolean") return <label class="check"><input type="checkbox" aria-label={label} checked={value === "true"} disabled={disabled} onChange={(event) => change(one, String(event.currentTarget.checked))} />{value === "true" ? "on" : "off"}</label>;
  if (one.choices) return <select aria-label={label} value={value} disabled={disabled} onChange={(event) => change(one, event.currentTarget.value)}>{one.choices.map((name) => <option key={name}>{name}</option>)}{!one.choices.includes(value) && <option>{value}</option>}</select>;
  return (
    <span class={`field wide ${one.type}`}>
      <input type="text" aria-label={label} value={value} disabled={disabled} spellcheck={false} onInput={(event) => change(one, event.currentTarget.value)} />
      {one.unit && <small>{one.unit}</small>}
    </span>
  );
}

function Row({ one }: { one: Setting }) {
  const name = nameOf(one);
  const pending = changes.value[name];
  const isChanged = pending !== undefined;
  const value = pending === null ? one.default ?? "" : pending ?? one.value;
  const wrong = findings.value[name];
  const range = one.min !== undefined && one.max !== undefined ? `${one.min} to ${one.max}` : "";
  const facts = [one.default !== null && one.default !== "" ? `default ${one.default}` : "", range].filter(Boolean);
  return (
    <div class={`setting ${isChanged ? "changed" : ""} ${one.isSet ? "set" : ""}`}>
      <div class="words">
        <code>{one.key}</code>{isChanged && <span class="tag accent">changed</span>}
        <p>{one.help}</p>
        {facts.length > 0 && <small>{facts.join(" · ")}</small>}
        {wrong && <p class="wrong">{wrong}</p>}
      </div>
      <div class="value">
        <Field one={one} value={value} />
        {isOwner.value && (isChanged
          ? <Button icon="undo" kind="plain" label={`${one.key}: as it was`} onPress={() => change(one, one.isSet ? one.value : null)} />
          : one.isSet && one.default !== null && <Button icon="cancel" kind="plain" label={`${one.key}: back to the default`} onPress={() => change(one, null)} />)}
      </div>
    </div>
  );
}

function SaveBar() {
  if (!changed.value) return null;
  const wrong = Object.values(findings.value)[0];
  return (
    <div class="savebar" role="region" aria-label="Changes">
      <span class="grow"><b>{changed.value} {changed.value === 1 ? "change" : "changes"}</b> {wrong ? <span class="wrong">cannot be stored: {wrong}</span> : <span class="quiet">checked by the machine</span>}</span>
      <Button icon="undo" onPress={() => { changes.value = {}; findings.value = {}; }}>Drop</Button>
      <Button icon="check" kind="main" disabled={wrong !== undefined || isStoring.value || !isLive.value} onPress={() => store(changes.peek(), false)}>Store</Button>
    </div>
  );
}

/** How far a setting is from what was looked for: its key, its section, or only its help. */
function distance(one: Setting, words: string[]): number {
  const holds = (text: string) => words.every((word) => text.toLowerCase().includes(word));
  return holds(one.key) ? 0 : holds(`${one.section} ${one.key}`) ? 1 : 2;
}

/** In a section of things with names of the user's own: one more of them. */
function AddName({ section }: { section: string }) {
  if (!schema.value[section]?.each || !isOwner.value) return null;
  const add = (event: Event) => {
    event.preventDefault();
    const form = event.currentTarget as HTMLFormElement;
    const name = String(new FormData(form).get("name")).trim();
    if (/^[^.=#[\]\s]{1,24}$/.test(name)) { added.value = [...added.peek(), `${section}/${name}`]; form.reset(); } else say("error", "A name has no blanks, dots or brackets.");
  };
  return <form class="row keyform" onSubmit={add}><input type="text" name="name" placeholder="Another name" aria-label={`Name of another one in ${section}`} required /><Button submit>Add</Button></form>;
}

type Which = "all" | "set" | "changed";
const SHOWN = 80;

export function SettingsView() {
  const looked = useSignal("");
  const which = useSignal<Which>("set");
  const section = useSignal("");
  useEffect(() => { if (isOwner.value) void load().catch((error: Error) => say("error", error.message)); }, [isOwner.value]);
  const words = looked.value.toLowerCase().split(/\s+/).filter(Boolean);
  const fits = (one: Setting) => {
    if (section.value && one.section !== section.value) return false;
    if (words.length) return words.every((word) => `${one.section} ${one.key} ${one.help}`.toLowerCase().includes(word));
    return section.value !== "" || which.value === "all" || (which.value === "set" ? one.isSet : changes.value[nameOf(one)] !== undefined);
  };
  const found = all.value.filter(fits);
  if (words.length) found.sort((a, b) => distance(a, words) - distance(b, words));
  const sections = Object.keys(schema.value);
  const groups = [...new Set(found.slice(0, SHOWN).map((one) => one.section))];
  return (
    <div class="stack settings">
      <h1 class="unseen">Settings</h1>
      <div class="row wrap toolbar">
        <input type="search" class="search grow" data-slash placeholder="Find a setting by name or by what it is for" aria-label="Find a setting" value={looked.value} onInput={(event) => { looked.value = event.currentTarget.value; }} />
        <select aria-label="Section" value={section.value} onChange={(event) => { section.value = event.currentTarget.value; }}><option value="">All sections</option>{sections.map((name) => <option key={name}>{name}</option>)}</select>
        <Choice<Which> label="Which settings" value={which.value} of={[["set", "Written"], ["changed", "Changed"], ["all", "All"]]} onPick={(value) => { which.value = value; }} />
      </div>
      {!isOwner.value && <div class="banner note"><p>Only the owner sees and changes settings.</p><Button onPress={() => { wantsLogin.value = true; }}>Log in</Button></div>}
      {needsRestart.value && <div class="banner note"><p>What was stored acts when the board starts again.</p><Button onPress={async () => { if (await script("reset")) needsRestart.value = false; }}>Restart the board</Button></div>}
      {isOwner.value && !found.length && <Empty>{words.length ? "No setting is about that." : "Nothing to show here."}</Empty>}
      {groups.map((name) => (
        <Card key={name} title={name} class="settinggroup">{found.slice(0, SHOWN).filter((one) => one.section === name).map((one) => <Row key={nameOf(one)} one={one} />)}<AddName section={name} /></Card>
      ))}
      {found.length > SHOWN && <p class="note">{found.length - SHOWN} more: narrow the search.</p>}
      {section.value && !groups.length && <AddName section={section.value} />}
      <SaveBar />
    </div>
  );
}
