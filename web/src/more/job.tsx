// The job as large as the screen, and what was made before.
import { useEffect } from "preact/hooks";
import { JobFigures, JobSummary, useMetadata } from "../parts/job";
import { PathStage } from "../parts/stage";
import { Overrides } from "../parts/temps";
import { MillOverrides } from "../parts/mill";
import { isPrinter, obj } from "../state/machine";
import { ask } from "../state/notices";
import { mayOperate } from "../state/session";

function onKey(event: KeyboardEvent): void {
  if (event.key !== " " || !mayOperate.peek() || (event.target as HTMLElement).closest("input, textarea, button, select, a, dialog")) return;
  event.preventDefault();
  const state = obj("print_stats")?.state;
  if (state === "printing") void ask("printer.print.pause", {});
  else if (state === "paused") void ask("printer.print.resume", {});
}

export function JobView() {
  const meta = useMetadata();
  useEffect(() => {
    window.addEventListener("keydown", onKey);
    return () => window.removeEventListener("keydown", onKey);
  }, []);
  return (
    <>
      <h1 class="unseen">Job</h1>
      <div class="stack">
        <section class="card jobcard tall" aria-label="Job">
          <PathStage />
          <div class="jobbody"><JobSummary meta={meta.value} /></div>
        </section>
        <JobFigures meta={meta.value} />
        <div class="grid"><div class="span6">{isPrinter.value ? <Overrides /> : <MillOverrides />}</div></div>
      </div>
    </>
  );
}
