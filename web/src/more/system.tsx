// The board itself: what was made, firmware, who may come in.
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Firmware, Job, Totals, UpdateState } from "../api/types";
import { call, on } from "../api/link";
import { Button, Card, Choice, Dialog, Empty } from "../shell/parts";
import { bytes, clock, duration, num, plainName } from "../shell/format";
import { cpuLoad, eventTime, hostname, isPrinter, mode, softwareVersion } from "../state/machine";
import { ask, say } from "../state/notices";
import { type Theme, theme } from "../state/prefs";
import { access, isOwner, logout, role, wantsLogin } from "../state/session";
import { PasswordForm } from "../shell/login";

const ENDS: Record<Job["status"], [string, string]> = {
  in_progress: ["running", "accent"], completed: ["done", "good"], cancelled: ["cancelled", ""], error: ["broken off", "bad"], klippy_shutdown: ["halted", "bad"],
};

function Days({ jobs }: { jobs: Job[] }) {
  const days = Array.from({ length: 28 }, (_, at) => {
    const start = new Date();
    start.setHours(0, 0, 0, 0);
    const from = start.getTime() / 1000 - (27 - at) * 86400;
    const hours = jobs.filter((job) => job.start_time >= from && job.start_time < from + 86400).reduce((sum, job) => sum + job.total_duration, 0) / 3600;
    return { from, hours };
  });
  const most = Math.max(1, ...days.map((one) => one.hours));
  return (
    <svg class="days" viewBox="0 0 280 60" role="img" aria-label="Hours of work on each of the last 28 days" preserveAspectRatio="none">
      {days.map((one, at) => <rect key={at} x={at * 10 + 1} width={8} rx={2} y={58 - Math.max(1.5, (one.hours / most) * 56)} height={Math.max(1.5, (one.hours / most) * 56)}><title>{`${clock(one.from).split(",")[0]}: ${num(one.hours, 1)} h`}</title></rect>)}
    </svg>
  );
}

function Statistics() {
  const totals = useSignal<Totals | null>(null);
  const jobs = useSignal<Job[]>([]);
  const load = () => {
    void call("server.history.totals", {}).then((answer) => { totals.value = answer.job_totals; }).catch(() => undefined);
    void call("server.history.list", { limit: 100, start: 0 }).then((answer) => { jobs.value = answer.jobs; }).catch(() => undefined);
  };
  useEffect(() => { load(); return on("notify_history_changed", load); }, []);
  const one = totals.value;
  const done = jobs.value.filter((job) => job.status === "completed").length;
  const ended = jobs.value.filter((job) => job.status !== "in_progress").length;
  return (
    <Card title="Statistics">
      {one && (
        <div class="tiles">
          <div><b>{one.total_jobs}</b><span>jobs</span></div>
          <div><b>{duration(one.total_print_time)}</b><span>at work</span></div>
          {isPrinter.value && <div><b>{num(one.total_filament_used / 1e6, 2)}<small> km</small></b><span>filament</span></div>}
          <div><b>{duration(one.longest_job)}</b><span>longest job</span></div>
          {ended > 0 && <div><b>{num((done / ended) * 100, 0)}<small> %</small></b><span>of the last {ended} done</span></div>}
        </div>
      )}
      {jobs.value.length > 0 && <Days jobs={jobs.value} />}
      {jobs.value.length === 0 ? <Empty>Nothing was made yet.</Empty> : (
        <div class="scroll">
          <table class={isPrinter.value ? "jobs filaments" : "jobs"}>
            <thead><tr><th>Job</th><th>Begun</th><th class="n">Took</th>{isPrinter.value && <th class="n">Filament</th>}<th class="n">Ended</th></tr></thead>
            <tbody>
              {jobs.value.slice(0, 12).map((job) => (
                <tr key={job.job_id}>
                  <td>{plainName(job.filename)}</td><td class="quiet">{clock(job.start_time)}</td><td class="n">{duration(job.total_duration)}</td>
                  {isPrinter.value && <td class="n">{num(job.filament_used / 1000, 1)} m</td>}
                  <td class="n"><span class={`tag ${ENDS[job.status][1]}`}>{ENDS[job.status][0]}</span></td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
    </Card>
  );
}

function FirmwareRow({ what, one, children }: { what: string; one: Firmware; children?: preact.ComponentChildren }) {
  return (
    <div class="firmware">
      <div class="grow"><b>{one.version}</b> <span class="tag">{what}</span><br /><small>{one.commit} · {bytes(one.bytes)} · {one.signed_by ? `signed by ${one.signed_by}` : "not signed"}</small></div>
      {children}
    </div>
  );
}

function Updates() {
  const state = useSignal<UpdateState | null>(null);
  const sure = useSignal<"install" | "back" | null>(null);
  const load = () => void call("velvet.update.state", {}).then((answer) => { state.value = answer; }).catch(() => undefined);
  useEffect(() => { load(); return on("notify_filelist_changed", load); }, []);
  const now = state.value;
  const isIdle = mode.value === "Idle";
  if (!now) return null;
  const act = async (how: "install" | "back") => {
    sure.value = null;
    const done = how === "back" ? await ask("velvet.update.back", {}) : await ask("velvet.update.install", { path: now.offered?.path ?? "" });
    if (done) { say("info", "The board starts with the other firmware. That takes some 20 s."); load(); }
  };
  return (
    <Card title="Firmware">
      <FirmwareRow what="runs" one={now.running} />
      {now.trial && (
        <div class="banner note">
          <p>On trial: unless it is kept, the firmware from before comes back when this one fails{now.trial.left_s ? `, or in ${duration(now.trial.left_s)}` : ""}.</p>
          {isOwner.value && <Button kind="main" onPress={async () => { if (await ask("velvet.update.confirm", {})) { say("done", "This firmware stays."); load(); } }}>Keep it</Button>}
        </div>
      )}
      {now.offered && (
        <FirmwareRow what={`in ${now.offered.path}`} one={now.offered}>
          {now.offered.refused ? <p class="wrong">{now.offered.refused}</p> : isOwner.value && <Button kind="main" disabled={!isIdle} onPress={() => { sure.value = "install"; }}>Install</Button>}
        </FirmwareRow>
      )}
      {now.previous && <FirmwareRow what="from before" one={now.previous}>{isOwner.value && <Button icon="undo" disabled={!isIdle} onPress={() => { sure.value = "back"; }}>Go back</Button>}</FirmwareRow>}
      <p class="note">Put <code>flashme.bin</code> on the card, or upload it in the view of files. The machine has to stand still.</p>
      {sure.value && (
        <Dialog title={sure.value === "install" ? `Install ${now.offered?.version}?` : `Go back to ${now.previous?.version}?`} onClose={() => { sure.value = null; }}>
          <p>The board restarts. Heaters and motors are off meanwhile, and axes have to be homed afterwards.</p>
          <div class="row end"><Button onPress={() => { sure.value = null; }}>No</Button><Button kind="main" onPress={() => act(sure.peek() ?? "back")}>{sure.value === "install" ? "Install" : "Go back"}</Button></div>
        </Dialog>
      )}
    </Card>
  );
}

const ROLES_TEXT = { Nobody: "may do nothing", Watch: "may watch, and halt the machine", Operate: "may work with the machine", Own: "may do everything" };

function Access() {
  const key = useSignal<string | null>(null);
  const wantsPassword = useSignal(false);
  const makeKey = async (event: Event) => {
    event.preventDefault();
    const form = event.currentTarget as HTMLFormElement;
    key.value = await ask("access.post_api_key", { name: String(new FormData(form).get("name")) }) ?? null;
    form.reset();
  };
  return (
    <Card title="Access" aside={role.value !== "Own" ? <Button icon="user" onPress={() => { wantsLogin.value = true; }}>Log in</Button> : access.value?.password_set && <Button kind="plain" onPress={logout}>Log out</Button>}>
      <p>You {ROLES_TEXT[role.value]}.</p>
      {isOwner.value && (
        <>
          <form class="row keyform" onSubmit={makeKey}>
            <input type="text" name="name" placeholder="Name of a program" aria-label="Name of the program that gets a key" required />
            <Button submit>Make a key</Button>
          </form>
          {key.value && <div class="banner note"><div><b>The key is shown this once:</b><br /><code class="key">{key.value}</code></div><Button icon="cancel" kind="plain" label="Hide the key" onPress={() => { key.value = null; }} /></div>}
          <Button onPress={() => { wantsPassword.value = true; }}>{access.value?.password_set ? "Change the password" : "Set a password"}</Button>
        </>
      )}
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
