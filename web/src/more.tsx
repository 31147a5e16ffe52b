// The second file: all views.
import type { ComponentType } from "preact";
import { on } from "./api/link";
import { BedView } from "./more/bed";
import { ConsoleView } from "./more/console";
import { FilesView } from "./more/files";
import { JobView } from "./more/job";
import { MachineView } from "./more/machine";
import { SettingsView } from "./more/settings";
import { SystemView } from "./more/system";
import { WorkView } from "./more/work";
import { duration, plainName } from "./shell/format";
import { say } from "./state/notices";
import type { View } from "./state/route";

const ENDS: Record<string, string> = { completed: "is done", cancelled: "was cancelled", error: "was broken off", klippy_shutdown: "ended with a halt" };
on("notify_history_changed", ({ action, job }) => {
  if (action === "finished") say(job.status === "completed" ? "done" : "info", `${plainName(job.filename)} ${ENDS[job.status] ?? "has ended"} after ${duration(job.total_duration)}.`);
});

export const views: Record<View, ComponentType> = {
  machine: MachineView, job: JobView, files: FilesView, console: ConsoleView, bed: BedView, work: WorkView, settings: SettingsView, system: SystemView,
};
