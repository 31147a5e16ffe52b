// What has been executed, kept while the page is open: views come and go, and each draws all of it.
import { call, Refused } from "../api/link";
import type { Stage } from "../gl/stage";
import { isLive, mode, obj } from "../state/machine";

const TURN_MS = 250;
const BEHIND_MS = 30;
/** As many points as an answer has when there is more to come. */
const MANY = 300;
const MOST = 400_000;

let points: number[][] = [];
let seq = 0;
let job = "";
let began = 0;
let hasRecord = true;
let isSettled = false;
let timer = 0;
const stages = new Set<Stage>();

function forget(): void {
  points = [];
  seq = 0;
  isSettled = false;
  for (const stage of stages) { stage.clear(); stage.orbit.isTouched = false; }
}

function keep(more: number[][]): void {
  if (points.length + more.length > MOST) return;
  for (const one of more) points.push(one);
  for (const stage of stages) { stage.add(more); if (points.length > 30) stage.follow(); }
}

/** One question for what came since; a board without such a record gives its position four times a second. */
async function turn(): Promise<number> {
  const stats = obj("print_stats");
  const live = obj("motion_report")?.live_position ?? obj("toolhead")?.position;
  const isAnother = (stats?.filename ?? "") !== job || (stats?.total_duration ?? 0) < began;
  job = stats?.filename ?? "";
  began = stats?.total_duration ?? 0;
  if (isAnother) forget();
  if (live) for (const stage of stages) stage.toolAt(live);
  // A job that is paused still makes the moves that were planned.
  const works = stats?.state === "printing" || mode.value === "Run";
  if (!hasRecord) {
    if (live && works) keep([[...live.slice(0, 3), 1]]);
    return TURN_MS;
  }
  if (isSettled && !works) return TURN_MS;
  const piece = await call("velvet.path.since", { seq });
  if (piece.lost) forget();
  seq = piece.next;
  isSettled = !works && piece.points.length === 0;
  keep(piece.points);
  return piece.points.length >= MANY ? BEHIND_MS : TURN_MS;
}

async function run(): Promise<void> {
  let wait = TURN_MS;
  try {
    if (isLive.peek() && !document.hidden) wait = await turn();
  } catch (error) {
    if (error instanceof Refused && error.isUnknown) hasRecord = false;
  }
  timer = stages.size ? window.setTimeout(() => void run(), wait) : 0;
}

/** Draws on a stage all that is known and all that comes, until the function given back is called. */
export function drawOn(stage: Stage): () => void {
  stages.add(stage);
  stage.add(points);
  stage.follow();
  if (stages.size === 1 && !timer) void run();
  return () => { stages.delete(stage); };
}
