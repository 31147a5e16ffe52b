// The configuration from its schema: found by words, explained, checked by the board before it is stored, and undone.
import { computed, signal, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Changes, Setting, SettingFinding } from "../api/types";
import { call } from "../api/link";
import { Bar, Button, Card, Choice, Empty } from "../shell/parts";
import { ask, say } from "../state/notices";
import { isLive } from "../state/machine";
import { isOwner, wantsLogin } from "../state/session";

const all = signal<Setting[]>([]);
const total = signal(0);
const changes = signal<Changes>({});
const findings = signal<SettingFinding[]>([]);
const needsRestart = signal(false);
const nameOf = (one: Setting) => `${one.section}/${one.key}`;
const changed = computed(() => Object.keys(changes.value).length);

async function load(): Promise<void> {
  const found: Setting[] = [];
  let start: number | null = 0;
  while (start !== null) {
    const piece: { settings: Setting[]; next: number | null; total: number } = await call("velvet.settings.list", { start });
    found.push(...piece.settings);
    total.value = piece.total;
    start = piece.next;
    all.value = [...found];
  }
}

let checkTimer = 0;
function change(one: Setting, value: string | null): void {
  const next = { ...changes.peek() };
  const now = one.is_set ? one.value : null;
  if (value === now || (value !== null && value === one.value)) delete next[nameOf(one)];
  else next[nameOf(one)] = value;
  changes.value = next;
  clearTimeout(checkTimer);
  checkTimer = window.setTimeout(() => {
    if (!Object.keys(changes.peek()).length) { findings.value = []; return; }
    void call("velvet.settings.check", { changes: changes.peek() }).then((answer) => { findings.value = answer.findings; }).catch(() => undefined);
  }, 300);
}

/** What would lead back to how things were. */
function opposite(of: Changes): Changes {
  return Object.fromEntries(Object.keys(of).map((name) => {
    const one = all.peek().find((setting) => nameOf(setting) === name);
    return [name, one?.is_set ? one.value : null];
  }));
}

async function store(wanted: Changes, undoes: boolean): Promise<void> {
  const back = opposite(wanted);
  const answer = await ask("velvet.settings.set", { changes: wanted });
  if (!answer) return;
  findings.value = answer.findings;
  if (!answer.stored) { say("error", "Nothing was stored: look at what is marked."); return; }
  all.value = all.peek().map((one) => {
    const value = wanted[nameOf(one)];
    return value === undefined ? one : { ...one, value: value ?? one.default ?? "", is_set: value !== null };
  });
  changes.value = {};
  findings.value = [];
  needsRestart.value ||= answer.restart;
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
  const said = findings.value.filter((finding) => finding.key === name);
  const range = one.min !== undefined && one.max !== undefined && Math.abs(one.max) < 1e8 ? `${one.min} to ${one.max}` : "";
  const facts = [one.default !== null && one.default !== "" ? `default ${one.default}` : "", range, one.acts === "restart" ? "" : "acts at once"].filter(Boolean);
  return (
    <div class={`setting ${isChanged ? "changed" : ""} ${one.is_set ? "set" : ""}`}>
      <div class="words">
        <code>{one.key}</code>{isChanged && <span class="tag accent">changed</span>}
        <p>{one.help}</p>
        {facts.length > 0 && <small>{facts.join(" · ")}</small>}
        {said.map((finding) => <p key={finding.text} class={finding.level === "error" ? "wrong" : "caution"}>{finding.text}</p>)}
      </div>
      <div class="value">
        <Field one={one} value={value} />
        {isOwner.value && (isChanged
          ? <Button icon="undo" kind="plain" label={`${one.key}: as it was`} onPress={() => change(one, one.is_set ? one.value : null)} />
          : one.is_set && one.default !== null && <Button icon="cancel" kind="plain" label={`${one.key}: back to the default`} onPress={() => change(one, null)} />)}
      </div>
    </div>
  );
}

function SaveBar() {
  if (!changed.value) return null;
  const wrong = findings.value.find((one) => one.level === "error");
  return (
    <div class="savebar" role="region" aria-label="Changes">
      <span class="grow"><b>{changed.value} {changed.value === 1 ? "change" : "changes"}</b> {wrong ? <span class="wrong">cannot be stored: {wrong.text}</span> : <span class="quiet">checked by the machine</span>}</span>
      <Button icon="undo" onPress={() => { changes.value = {}; findings.value = []; }}>Drop</Button>
      <Button icon="check" kind="main" disabled={wrong !== undefined || !isLive.value} onPress={() => store(changes.peek(), false)}>Store</Button>
    </div>
  );
}

/** How far a setting is from what was looked for: its key, its section, or only its help. */
function distance(one: Setting, words: string[]): number {
  const holds = (text: string) => words.every((word) => text.toLowerCase().includes(word));
  return holds(one.key) ? 0 : holds(`${one.section} ${one.key}`) ? 1 : 2;
}

type Which = "all" | "set" | "changed";
const SHOWN = 80;

export function SettingsView() {
  const looked = useSignal("");
  const which = useSignal<Which>("set");
  const section = useSignal("");
  useEffect(() => { if (!all.peek().length) void load().catch((error: Error) => say("error", error.message)); }, []);
  const words = looked.value.toLowerCase().split(/\s+/).filter(Boolean);
  const fits = (one: Setting) => {
    if (section.value && one.section !== section.value) return false;
    if (words.length) return words.every((word) => `${one.section} ${one.key} ${one.help}`.toLowerCase().includes(word));
    return section.value !== "" || which.value === "all" || (which.value === "set" ? one.is_set : changes.value[nameOf(one)] !== undefined);
  };
  const found = all.value.filter(fits);
  if (words.length) found.sort((a, b) => distance(a, words) - distance(b, words));
  const sections = [...new Set(all.value.map((one) => one.section))];
  const groups = [...new Set(found.slice(0, SHOWN).map((one) => one.section))];
  const isLoading = all.value.length < total.value;
  return (
    <div class="stack settings">
      <h1 class="unseen">Settings</h1>
      <div class="row wrap toolbar">
        <input type="search" class="search grow" data-slash placeholder="Find a setting by name or by what it is for" aria-label="Find a setting" value={looked.value} onInput={(event) => { looked.value = event.currentTarget.value; }} />
        <select aria-label="Section" value={section.value} onChange={(event) => { section.value = event.currentTarget.value; }}><option value="">All sections</option>{sections.map((name) => <option key={name}>{name}</option>)}</select>
        <Choice<Which> label="Which settings" value={which.value} of={[["set", "Written"], ["changed", "Changed"], ["all", "All"]]} onPick={(value) => { which.value = value; }} />
      </div>
      {!isOwner.value && <div class="banner note"><p>Only who has logged in may change settings.</p><Button onPress={() => { wantsLogin.value = true; }}>Log in</Button></div>}
      {needsRestart.value && <div class="banner note"><p>What was stored acts when the board starts again.</p><Button onPress={async () => { if (await ask("printer.gcode.script", { script: "reset" })) needsRestart.value = false; }}>Restart the board</Button></div>}
      {isLoading && <Bar part={all.value.length / Math.max(1, total.value)} label="Settings read from the board" />}
      {!isLoading && !found.length && <Empty>{words.length ? "No setting is about that." : "Nothing to show here."}</Empty>}
      {groups.map((name) => (
        <Card key={name} title={name} class="settinggroup">{found.slice(0, SHOWN).filter((one) => one.section === name).map((one) => <Row key={nameOf(one)} one={one} />)}</Card>
      ))}
      {found.length > SHOWN && <p class="note">{found.length - SHOWN} more: narrow the search.</p>}
      <SaveBar />
    </div>
  );
}
