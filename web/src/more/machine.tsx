// The first view: everything at a glance, laid out for a printer or for a mill.
import { Card } from "../shell/parts";
import { heaterNames, isPrinter, sensorNames } from "../state/machine";
import { LastWords, Macros } from "../parts/extras";
import { JobFigures, JobSummary, useMetadata } from "../parts/job";
import { LaserCard, MillOverrides, Readout, Signals, SpindleCard } from "../parts/mill";
import { Filament } from "../parts/filament";
import { Move } from "../parts/move";
import { PathStage } from "../parts/stage";
import { Overrides, Temperatures } from "../parts/temps";

function JobCard() {
  const meta = useMetadata();
  return (
    <section class="card jobcard" aria-label="Job">
      <PathStage />
      <div class="jobbody"><JobSummary meta={meta.value} /><JobFigures meta={meta.value} short /></div>
    </section>
  );
}

function Printer() {
  return (
    <div class="grid">
      <div class="stack span7"><JobCard /><Temperatures /><LastWords /></div>
      <div class="stack span5"><Move /><Filament /><Overrides /><Macros /></div>
    </div>
  );
}

function Mill() {
  const hasHeat = heaterNames.value.length + sensorNames.value.length > 0 && heaterNames.value.length > 0;
  return (
    <div class="grid">
      <div class="stack span7"><Readout /><JobCard />{hasHeat && <Temperatures />}<Card title="Signals"><Signals /></Card><LastWords /></div>
      <div class="stack span5"><Move /><SpindleCard /><LaserCard /><MillOverrides /><Macros /></div>
    </div>
  );
}

export function MachineView() {
  return <><h1 class="unseen">Machine</h1>{isPrinter.value ? <Printer /> : <Mill />}</>;
}
