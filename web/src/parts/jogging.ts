// Jogs: steps, and continuous ones that end by themselves when nobody says any more that they should go on.
import { signal } from "@preact/signals";
import { call, tell } from "../api/link";
import type { Axis } from "../api/types";
import { ask, say } from "../state/notices";
import { kept } from "../state/prefs";

const BEAT_MS = 50;
export const STEPS = [0.01, 0.1, 1, 10, 100] as const;
export const jogStep = kept<number>("jog.step", 1);
export const jogFeed = kept<number>("jog.feed", 3000);
export const jogFeedZ = kept<number>("jog.feed.z", 600);
export const isContinuous = kept<boolean>("jog.continuous", false);
/** The axis and direction that a continuous jog runs in. */
export const running = signal<string | null>(null);

let id: number | null = null;
let timer = 0;
let turn = 0;

function feed(axis: Axis): number {
  return axis === "z" ? jogFeedZ.peek() : jogFeed.peek();
}

export function step(axis: Axis, direction: 1 | -1): Promise<unknown> {
  return ask("velvet.jog.step", { axis, mm: direction * jogStep.peek(), mm_per_min: feed(axis) });
}

export async function begin(axis: Axis, direction: 1 | -1): Promise<void> {
  end();
  const mine = ++turn;
  running.value = `${axis}${direction}`;
  try {
    const started = await call("velvet.jog.start", { axis, direction, mm_per_min: feed(axis) });
    if (mine !== turn) { tell("velvet.jog.stop", { id: started.id }); return; }
    id = started.id;
    const beat = () => { if (id !== null) tell("velvet.jog.beat", { id }); };
    beat();
    timer = window.setInterval(beat, BEAT_MS);
  } catch (error) {
    if (mine === turn) running.value = null;
    say("error", (error as Error).message);
  }
}

export function end(): void {
  turn++;
  clearInterval(timer);
  if (id !== null) tell("velvet.jog.stop", { id });
  id = null;
  running.value = null;
}
// Whoever looks elsewhere does not see what the machine does.
window.addEventListener("blur", end);
window.addEventListener("pagehide", end);
document.addEventListener("visibilitychange", () => { if (document.hidden) end(); });
