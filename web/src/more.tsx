// The second file: all views.
import type { ComponentType } from "preact";
import { effect } from "@preact/signals";
import { BedView } from "./more/bed";
import { ConsoleView } from "./more/console";
import { FilesView } from "./more/files";
import { JobView } from "./more/job";
import { MachineView } from "./more/machine";
import { SettingsView } from "./more/settings";
import { SystemView } from "./more/system";
import { WorkView } from "./more/work";
import { duration, plainName } from "./shell/format";
import { startButtons } from "./state/buttons";
import { obj } from "./state/machine";
import { say } from "./state/notices";
import type { View } from "./state/route";

startButtons();

const ENDS: Record<string, string> = { complete: "is done", cancelled: "was cancelled", error: "was broken off" };
let lastState: string | undefined;
effect(() => {
  const job = obj("print_stats");
  const before = lastState;
  lastState = job?.state;
  if ((before === "printing" || before === "paused") && job && ENDS[job.state]) {
    say(job.state === "complete" ? "done" : "info", `${plainName(job.filename)} ${ENDS[job.state]} after ${duration(job.total_duration)}.`);
  }
});

export const views: Record<View, ComponentType> = {
  machine: MachineView, job: JobView, files: FilesView, console: ConsoleView, bed: BedView, work: WorkView, settings: SettingsView, system: SystemView,
};
