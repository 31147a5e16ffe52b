// The second file: all views.
import type { ComponentType } from "preact";
import { BedView } from "./more/bed";
import { ConsoleView } from "./more/console";
import { FilesView } from "./more/files";
import { JobView } from "./more/job";
import { MachineView } from "./more/machine";
import { SettingsView } from "./more/settings";
import { SystemView } from "./more/system";
import { WorkView } from "./more/work";
import type { View } from "./state/route";

export const views: Record<View, ComponentType> = {
  machine: MachineView, job: JobView, files: FilesView, console: ConsoleView, bed: BedView, work: WorkView, settings: SettingsView, system: SystemView,
};
