// The frame: who and how the machine is, where to go, how to stop it; the views come with the second file.
import { type ComponentType, Fragment } from "preact";
import { useEffect } from "preact/hooks";
import { computed, effect, signal } from "@preact/signals";
import { linkState, retryAt } from "../api/link";
import { hostname, isLive, isPrinter, mode, now, obj, oldFor } from "../state/machine";
import { ask, dismiss, notices, say } from "../state/notices";
import { theme } from "../state/prefs";
import { go, type View, view } from "../state/route";
import { access, isReady, mayOperate, role, wantsLogin } from "../state/session";
import { duration, num, plainName } from "./format";
import { Icon, type IconName } from "./icon";
import { Gate, LoginDialog } from "./login";
import { Button, Dialog } from "./parts";

const views = signal<Record<View, ComponentType> | null>(null);
const showKeys = signal(false);

/** The styles of the views, which have to be there before these are shown. */
function loadStyle(href: string): Promise<void> {
  return new Promise((done, failed) => {
    const link = document.createElement("link");
    Object.assign(link, { rel: "stylesheet", href, onload: () => done(), onerror: () => { link.remove(); failed(new Error(href)); } });
    document.head.append(link);
  });
}

async function loadViews(): Promise<void> {
  const { more = "", style = "" } = document.getElementById("shell")?.dataset ?? {};
  try {
    const [found] = await Promise.all([import(more), loadStyle(style)]);
    views.value = found.views;
  } catch {
    window.setTimeout(() => void loadViews(), 2000);
  }
}

/** A job that is paused stands, but is not over: its machine is shown as held. */
const isPaused = computed(() => mode.value === "Idle" && obj("print_stats")?.state === "paused");
effect(() => { document.documentElement.dataset.mode = !isReady.value ? "Idle" : !isLive.value ? "Sleep" : isPaused.value ? "Hold" : mode.value; });
effect(() => { view.value; window.scrollTo(0, 0); });
effect(() => {
  const progress = obj("print_stats")?.state === "printing" ? `${Math.round((obj("virtual_sdcard")?.progress ?? 0) * 100)} % · ` : "";
  document.title = `${progress}${isReady.value ? `${mode.value} · ` : ""}${hostname.value}`;
});

/** By the socket, and by a request of its own where that is gone: whatever still reaches the machine. */
export async function emergencyStop(): Promise<void> {
  const isOpen = linkState.peek() === "open";
  const byRequest = () => fetch("/printer/emergency_stop", { method: "POST" }).then((answer) => answer.ok, () => false);
  const done = isOpen ? Boolean(await ask("printer.emergency_stop", {})) || await byRequest() : await byRequest();
  if (done) say("info", "The machine was told to halt.");
  else say("error", "The machine cannot be reached: use the switch at the machine.");
}

function places(): [View, IconName, string][] {
  const shape: [View, IconName, string] = isPrinter.value ? ["bed", "bed", "Bed"] : ["work", "work", "Work"];
  return [
    ["machine", "machine", "Machine"], ["job", "job", "Job"], ["files", "files", "Files"], shape,
    ["console", "console", "Console"], ["settings", "settings", "Settings"], ["system", "system", "System"],
  ];
}

function Navigation() {
  return (
    <nav class="rail" aria-label="Views">
      {places().map(([to, icon, label]) => (
        <a key={to} href={`#/${to}`} aria-current={view.value === to ? "page" : undefined}><Icon name={icon} /><span>{label}</span></a>
      ))}
    </nav>
  );
}

const THEMES = { auto: "light", light: "dark", dark: "auto" } as const;
const MODES: Record<string, string> = {
  Idle: "Ready", Run: "Running", Hold: "Held", Jog: "Jogging", Alarm: "Halted", Door: "Door open", Check: "Checking", Home: "Homing", Sleep: "Asleep",
};

function StateLine() {
  const stats = obj("print_stats");
  const card = obj("virtual_sdcard");
  if (stats && (stats.state === "printing" || stats.state === "paused")) {
    return <>{plainName(stats.filename)}, {num((card?.progress ?? 0) * 100, 0)} %</>;
  }
  return <>{obj("display_status")?.message || (obj("toolhead")?.homed_axes ? "" : "not homed")}</>;
}

function Header() {
  return (
    <header class="top">
      <a class="brand" href="#/machine">{hostname.value}</a>
      <p class="state" role="status">
        <b class="pill">{!isLive.value ? "No connection" : isPaused.value ? "Paused" : MODES[mode.value]}</b>
        <span class="quiet">{isReady.value && <StateLine />}</span>
      </p>
      <div class="corner">
        <span class="wide-only"><Button icon="keys" kind="plain" label="Keys" onPress={() => { showKeys.value = true; }} /></span>
        <Button icon="theme" kind="plain" label={`Colours: ${theme.value}. Change`} onPress={() => { theme.value = THEMES[theme.value]; }} />
        {role.value === "Watch" && access.value?.password_set && <Button icon="user" kind="soft" label="Log in" onPress={() => { wantsLogin.value = true; }} />}
        <button type="button" class="halt" onClick={() => void emergencyStop()} aria-label="Halt the machine at once" title="Halt the machine at once (Ctrl + .)">
          <Icon name="stop" /><span>Halt</span>
        </button>
      </div>
    </header>
  );
}

/** Values that are shown are old: said plainly, with when the next attempt is. */
function OldBanner() {
  if (isLive.value) return null;
  const wait = Math.max(0, Math.ceil((retryAt.value - now.value) / 1000));
  const what = oldFor.value ? `Everything below is ${duration(oldFor.value)} old.` : "";
  const next = linkState.value === "lost" ? ` Trying again${wait ? ` in ${wait} s` : ""}.` : "";
  return <div class="banner old" role="status"><Icon name="warn" /><p><b>No connection to the machine.</b> {what}{next}</p></div>;
}

function FaultBanner() {
  const fault = obj("velvet")?.fault;
  if (!fault && obj("webhooks")?.state !== "shutdown") return null;
  return (
    <div class="banner fault" role="alert">
      <Icon name="warn" />
      <div>
        <b>{fault?.text ?? obj("webhooks")?.state_message ?? "The machine has halted."}</b>
        {fault?.remedy && <p>{fault.remedy}</p>}
      </div>
      {mayOperate.value && <Button kind="soft" onPress={() => ask("printer.firmware_restart", {})}>Unlock</Button>}
    </div>
  );
}

function Notices() {
  return (
    <div class="notices" role="log" aria-label="Messages of the page">
      {notices.value.map((one) => (
        <div key={one.id} class={`notice ${one.level}`}>
          <Icon name={one.level === "error" ? "warn" : one.level === "done" ? "check" : "info"} />
          <span>{one.text}</span>
          {one.action && <Button kind="plain" onPress={() => { one.action?.act(); dismiss(one.id); }}>{one.action.label}</Button>}
          <Button icon="cancel" kind="plain" label="Dismiss" onPress={() => dismiss(one.id)} />
        </div>
      ))}
    </div>
  );
}

const KEYS: [string, string][] = [
  ["Ctrl + .", "halt the machine at once"], ["1 to 7", "go to a view"], ["/", "type into the console or a search"], ["Space", "pause or go on with the job, in the job's view"],
  ["J", "to the jog pad; there:"], ["Arrows", "X and Y"], ["Page up, Page down", "Z"], ["+, −", "longer and shorter steps"], ["H", "home all axes"], ["Esc", "leave the pad; stop a jog"], ["?", "these keys"],
];
function KeysDialog() {
  if (!showKeys.value) return null;
  return (
    <Dialog title="Keys" onClose={() => { showKeys.value = false; }}>
      <dl class="keys">{KEYS.map(([key, what]) => <Fragment key={key}><dt><kbd>{key}</kbd></dt><dd>{what}</dd></Fragment>)}</dl>
    </Dialog>
  );
}

function onKey(event: KeyboardEvent): void {
  if (event.ctrlKey && event.key === ".") { event.preventDefault(); void emergencyStop(); return; }
  const takesText = (event.target as HTMLElement).matches("textarea, select, input:not([type=radio], [type=checkbox])");
  if (event.ctrlKey || event.altKey || event.metaKey || takesText || document.querySelector("dialog[open]")) return;
  const place = places()[Number(event.key) - 1];
  if (place) go(place[0]);
  else if (event.key === "?") showKeys.value = true;
  else if (event.key === "j") focusOn(".jogpad", "machine");
  else if (event.key === "/") focusOn("[data-slash]", view.peek() === "settings" || view.peek() === "files" ? view.peek() : "console");
  else return;
  event.preventDefault();
}

function focusOn(selector: string, where: View): void {
  go(where);
  window.setTimeout(() => document.querySelector<HTMLElement>(selector)?.focus(), 60);
}

/** What can be said before the views are there: the figures, and room for the rest. */
function FirstLook() {
  const at = obj("toolhead")?.position ?? [];
  return (
    <div class="tiles">
      {["X", "Y", "Z"].map((axis, index) => <div key={axis}><b>{num(at[index])}<small> mm</small></b><span>{axis}</span></div>)}
      {obj("extruder") && <div><b>{num(obj("extruder")?.temperature, 1)}<small> °C</small></b><span>Hot end</span></div>}
      {obj("heater_bed") && <div><b>{num(obj("heater_bed")?.temperature, 1)}<small> °C</small></b><span>Bed</span></div>}
    </div>
  );
}

export function App() {
  useEffect(() => {
    window.addEventListener("keydown", onKey);
    // The rest is fetched when the first picture stands.
    requestAnimationFrame(() => window.setTimeout(() => void loadViews(), 0));
  }, []);
  if (access.value?.role === "Nobody") return <><OldBanner /><Gate /><Notices /></>;
  const Shown = views.value?.[view.value];
  return (
    <>
      <button type="button" class="skip" onClick={() => document.getElementById("main")?.focus()}>To the content</button>
      <Header />
      <Navigation />
      <main id="main" tabIndex={-1} class={isLive.value || !isReady.value ? "" : "isold"} data-view={view.value}>
        <OldBanner />
        <FaultBanner />
        {Shown && isReady.value ? <Shown /> : <FirstLook />}
      </main>
      <Notices />
      <LoginDialog />
      <KeysDialog />
    </>
  );
}
