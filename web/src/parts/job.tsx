// The job: what, how far, how long still, and what can be done with it.
import { useSignal, useSignalEffect } from "@preact/signals";
import type { Metadata } from "../api/types";
import { call } from "../api/link";
import { Bar, Button, Dialog } from "../shell/parts";
import { baseName, duration, num, plainName } from "../shell/format";
import { isLive, isPlaying, isPrinter, mode, obj } from "../state/machine";
import { ask } from "../state/notices";
import { go } from "../state/route";
import { mayOperate } from "../state/session";

export function thumbnailUrl(meta: Metadata, wanted: number): string | undefined {
  const all = [...(meta.thumbnails ?? [])].sort((a, b) => a.width - b.width);
  const found = all.find((one) => one.width >= wanted) ?? all.at(-1);
  if (!found) return undefined;
  const folder = meta.filename.slice(0, meta.filename.length - baseName(meta.filename).length);
  return `/server/files/gcodes/${`${folder}${found.relative_path}`.split("/").map(encodeURIComponent).join("/")}?timestamp=${Math.round(meta.modified)}`;
}

/** Remaining seconds: by the slicer's estimate at first, by what has been seen the more of it there is. */
export function remaining(elapsed: number, progress: number, estimate: number | undefined): number | undefined {
  if (progress <= 0.005) return estimate;
  const seen = elapsed / progress - elapsed;
  if (estimate === undefined) return progress > 0.02 ? seen : undefined;
  const weight = Math.min(1, progress * 1.5);
  return Math.max(0, estimate * (1 - progress) * (1 - weight) + seen * weight);
}

export function useMetadata(): { value: Metadata | undefined } {
  const meta = useSignal<Metadata | undefined>(undefined);
  const asked = useSignal("");
  useSignalEffect(() => {
    const filename = obj("print_stats")?.filename ?? "";
    if (filename === asked.peek()) return;
    asked.value = filename;
    meta.value = undefined;
    if (filename) void call("server.files.metadata", { filename }).then((found) => { meta.value = found; }).catch(() => undefined);
  });
  return meta;
}

export function JobButtons() {
  const wantsCancel = useSignal(false);
  const stats = obj("print_stats");
  if (!stats) return null;
  const may = mayOperate.value && isLive.value;
  if (!isPlaying.value) {
    const again = stats.filename && stats.state !== "standby";
    return (
      <div class="row">
        {(mode.value === "Hold" || mode.value === "Door") && <Button icon="play" kind="main" disabled={!may} onPress={() => ask("printer.print.resume", {})}>Go on</Button>}
        {again && <Button icon="play" disabled={!may} onPress={() => ask("printer.print.start", { filename: stats.filename })}>Again</Button>}
        <Button icon="files" kind="main" onPress={() => go("files")}>Choose a file</Button>
      </div>
    );
  }
  return (
    <div class="row">
      {stats.state === "paused"
        ? <Button icon="play" kind="main" disabled={!may} onPress={() => ask("printer.print.resume", {})}>Go on</Button>
        : <Button icon="pause" kind="main" disabled={!may} onPress={() => ask("printer.print.pause", {})}>Pause</Button>}
      <Button icon="cancel" kind="danger" disabled={!may} onPress={() => { wantsCancel.value = true; }}>Cancel</Button>
      {wantsCancel.value && (
        <Dialog title="Cancel the job?" onClose={() => { wantsCancel.value = false; }}>
          <p>{plainName(stats.filename)} ends at {num((obj("virtual_sdcard")?.progress ?? 0) * 100, 0)} %. A job that was cancelled cannot go on.</p>
          <div class="row end">
            <Button onPress={() => { wantsCancel.value = false; }}>Let it run</Button>
            <Button kind="danger" icon="cancel" onPress={async () => { wantsCancel.value = false; await ask("printer.print.cancel", {}); }}>Cancel the job</Button>
          </div>
        </Dialog>
      )}
    </div>
  );
}

const ENDS: Record<string, string> = { complete: "Done", cancelled: "Cancelled", error: "Broken off", standby: "No job", printing: "Running", paused: "Paused" };

export function JobSummary({ meta }: { meta: Metadata | undefined }) {
  const stats = obj("print_stats");
  const progress = stats?.state === "complete" ? 1 : obj("virtual_sdcard")?.progress ?? 0;
  if (!stats?.filename) {
    return (
      <div class="jobline">
        <div class="grow"><h2>No job</h2><p class="quiet">Files are on the card, or dropped onto the view of files.</p></div>
        <JobButtons />
      </div>
    );
  }
  const picture = meta && thumbnailUrl(meta, 120);
  const left = isPlaying.value ? remaining(stats.print_duration, progress, meta?.estimated_time) : undefined;
  return (
    <>
      <div class="jobline">
        {picture && <img class="thumb" src={picture} alt="" />}
        <div class="grow">
          <h2 class="jobname">{plainName(stats.filename)}</h2>
          <p class="quiet">{ENDS[stats.state]}{left !== undefined && `, ${duration(left)} left, done at ${new Date(Date.now() + left * 1000).toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" })}`}{stats.message && `: ${stats.message}`}</p>
        </div>
        <b class="percent">{num(progress * 100, 0)}<small> %</small></b>
        <JobButtons />
      </div>
      <Bar part={progress} label="Progress of the job" />
    </>
  );
}

export function JobFigures({ meta, short }: { meta: Metadata | undefined; short?: boolean }) {
  const stats = obj("print_stats");
  if (!stats?.filename) return null;
  const { current_layer, total_layer } = stats.info ?? {};
  const figures: [string, string, string?][] = [[duration(stats.print_duration), "running for"]];
  if (current_layer) figures.push([`${current_layer}${total_layer ? ` / ${total_layer}` : ""}`, "layer"]);
  if (isPrinter.value) figures.push([num(stats.filament_used / 1000), "filament", "m"]);
  figures.push([num(obj("motion_report")?.live_velocity, 0), "speed", "mm/s"]);
  if (meta?.estimated_time && !short) figures.push([duration(meta.estimated_time), "foreseen"]);
  return <div class="tiles">{figures.map(([value, what, unit]) => <div key={what}><b>{value}{unit && <small> {unit}</small>}</b><span>{what}</span></div>)}</div>;
}
