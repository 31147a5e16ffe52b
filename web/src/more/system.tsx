// The board itself: what was made, firmware, who may come in.
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { inquire } from "../api/inquire";
import type { ApiKey, Role } from "../api/types";
import { call, on } from "../api/link";
import { Button, Card, Choice, Dialog, Empty } from "../shell/parts";
import { duration, num } from "../shell/format";
import { cpuLoad, eventTime, hostname, mode, obj, softwareVersion } from "../state/machine";
import { ask, say } from "../state/notices";
import { type Theme, theme } from "../state/prefs";
import { access, isOwner, logout, role, wantsLogin } from "../state/session";
import { PasswordForm } from "../shell/login";

function Statistics() {
  const lines = useSignal<string[]>([]);
  const state = obj("print_stats")?.state;
  useEffect(() => { void inquire("M78").then((said) => { lines.value = said; }).catch(() => undefined); }, [state]);
  return <Card title="Statistics">{lines.value.length ? lines.value.map((one) => <p key={one}>{one}</p>) : <Empty>The machine has not told them yet.</Empty>}</Card>;
}

const OFFERED = "flashme.bin";
const PREVIOUS = "firmware.previous";

function Updates() {
  const runs = useSignal<string[]>([]);
  const files = useSignal<string[]>([]);
  const sure = useSignal<"install" | "back" | null>(null);
  const said = useSignal("");
  const load = () => {
    void inquire("version").then((lines) => { runs.value = lines; }).catch(() => undefined);
    void call("server.files.get_directory", { path: "gcodes" }).then((found) => { files.value = found.files.map((one) => one.filename); }).catch(() => undefined);
  };
  useEffect(() => { load(); return on("notify_filelist_changed", load); }, []);
  const isIdle = mode.value === "Idle";
  const has = (name: string) => files.value.includes(name);
  const act = async (how: "install" | "back") => {
    sure.value = null;
    try {
      if (how === "back") await inquire(`cp ${PREVIOUS} ${OFFERED}`);
      await inquire("flash", (line) => { said.value = line; });
    } catch (error) {
      said.value = "";
      say("error", (error as Error).message);
    }
  };
  return (
    <Card title="Firmware">
      {runs.value.map((one) => <p key={one}>{one}</p>)}
      {isOwner.value && (
        <div class="row wrap">
          {has(OFFERED) && <Button kind="main" disabled={!isIdle} onPress={() => { sure.value = "install"; }}>{`Install ${OFFERED}`}</Button>}
          {has(PREVIOUS) && <Button icon="undo" disabled={!isIdle} onPress={() => { sure.value = "back"; }}>Go back to the firmware from before</Button>}
        </div>
      )}
      {said.value && <div class="banner note"><p>{said.value}</p></div>}
      <p class="note">Put <code>{OFFERED}</code> on the card, or upload it in the view of files. New firmware is on trial for ten seconds: when it fails, the one from before comes back.</p>
      {sure.value && (
        <Dialog title={sure.value === "install" ? `Install ${OFFERED}?` : "Go back to the firmware from before?"} onClose={() => { sure.value = null; }}>
          <p>The board restarts. Heaters and motors are off meanwhile, and axes have to be homed afterwards.</p>
          <div class="row end"><Button onPress={() => { sure.value = null; }}>No</Button><Button kind="main" onPress={() => act(sure.peek() ?? "back")}>{sure.value === "install" ? "Install" : "Go back"}</Button></div>
        </Dialog>
      )}
    </Card>
  );
}

const ROLES_TEXT = { Nobody: "may do nothing", Watch: "may watch, and halt the machine", Operate: "may work with the machine", Own: "may do everything" };

const KEY_ROLES: [Role, string][] = [["Watch", "watches"], ["Operate", "operates"], ["Own", "owns"]];

function Keys() {
  const key = useSignal<string | null>(null);
  const keys = useSignal<ApiKey[]>([]);
  const load = () => void call("velvet.keys.list", {}).then((answer) => { keys.value = answer.keys; }).catch(() => undefined);
  useEffect(load, []);
  const makeKey = async (event: Event) => {
    event.preventDefault();
    const form = event.currentTarget as HTMLFormElement;
    const given = new FormData(form);
    key.value = await ask("access.post_api_key", { name: String(given.get("name")).trim(), role: String(given.get("role")) as Role }) ?? null;
    if (key.value) form.reset();
    load();
  };
  return (
    <>
      {keys.value.map((one) => (
        <div class="row between" key={one.name}>
          <span><b>{one.name}</b> <span class="tag">{KEY_ROLES.find(([role]) => role === one.role)?.[1]}</span></span>
          <Button kind="plain" label={`Revoke the key of ${one.name}`} onPress={async () => { await ask("velvet.keys.revoke", { name: one.name }); load(); }}>Revoke</Button>
        </div>
      ))}
      <form class="row keyform" onSubmit={makeKey}>
        <input type="text" name="name" placeholder="Name of a program" aria-label="Name of the program that gets a key" maxLength={24} required />
        <select name="role" aria-label="What the program may do">
          {KEY_ROLES.map(([role, text]) => <option key={role} value={role} selected={role === "Operate"}>{text}</option>)}
        </select>
        <Button submit>Make a key</Button>
      </form>
      {key.value && <div class="banner note"><div><b>The key is shown this once:</b><br /><code class="key">{key.value}</code></div><Button icon="cancel" kind="plain" label="Hide the key" onPress={() => { key.value = null; }} /></div>}
    </>
  );
}

function Access() {
  const wantsPassword = useSignal(false);
  const hasPassword = access.value?.password_set === true;
  // The first password is anybody's to set who can read the code at the machine.
  const maySet = isOwner.value || !hasPassword;
  return (
    <Card title="Access" aside={role.value !== "Own" ? hasPassword && <Button icon="user" onPress={() => { wantsLogin.value = true; }}>Log in</Button> : access.value?.password_set && <Button kind="plain" onPress={logout}>Log out</Button>}>
      <p>You {ROLES_TEXT[role.value]}.</p>
      {isOwner.value && <Keys />}
      {maySet && <Button onPress={() => { wantsPassword.value = true; }}>{hasPassword ? "Change the password" : "Set a password"}</Button>}
      {wantsPassword.value && <Dialog title="Password" onClose={() => { wantsPassword.value = false; }}><PasswordForm onDone={() => { wantsPassword.value = false; }} /></Dialog>}
    </Card>
  );
}

export function SystemView() {
  return (
    <>
      <h1 class="unseen">System</h1>
      <div class="grid">
        <div class="stack span7"><Statistics /></div>
        <div class="stack span5">
          <Card title={hostname.value}>
            <div class="tiles">
              <div><b>{duration(eventTime.value)}</b><span>since its start</span></div>
              {cpuLoad.value !== undefined && <div><b>{num(cpuLoad.value, 0)}<small> %</small></b><span>processor</span></div>}
            </div>
            <div class="row between colours"><span class="quiet">{softwareVersion.value}</span><Choice<Theme> label="Colours" value={theme.value} of={[["auto", "As the system"], ["light", "Light"], ["dark", "Dark"]]} onPick={(value) => { theme.value = value; }} /></div>
          </Card>
          <Updates />
          <Access />
        </div>
      </div>
    </>
  );
}
