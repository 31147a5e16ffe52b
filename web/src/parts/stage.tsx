// The 3D view of what has been executed, fed by the board's own record of it.
import { useEffect, useRef } from "preact/hooks";
import { effect, useSignal } from "@preact/signals";
import { call, Refused } from "../api/link";
import { Stage } from "../gl/stage";
import { Button } from "../shell/parts";
import { isLive, mode, obj } from "../state/machine";
import { colour, themeTurn } from "../state/prefs";

const TURN_MS = 250;

/** Asks for points since the last ones; a board without such a record gives its position four times a second. */
function follow(stage: Stage, onPoints: (count: number) => void): () => void {
  let seq = 0;
  let job = "";
  let hasRecord = true;
  let ended = false;
  const turn = async () => {
    const stats = obj("print_stats");
    const now = `${stats?.filename}`;
    if (now !== job || (stats && stats.total_duration < 1 && stats.state === "printing" && seq > 50)) { job = now; seq = 0; stage.orbit.isTouched = false; stage.clear(); }
    const live = obj("motion_report")?.live_position;
    if (live) stage.toolAt(live);
    if (hasRecord) {
      const piece = await call("velvet.path.since", { seq });
      if (piece.lost) stage.clear();
      seq = piece.next;
      stage.add(piece.points);
    } else if (live && stats?.state === "printing") stage.add([[...live.slice(0, 3), 1]]);
    if (stage.points > 30) stage.follow();
    onPoints(stage.points);
  };
  const run = async () => {
    if (ended) return;
    try {
      if (isLive.peek() && !document.hidden) await turn();
    } catch (error) {
      if (error instanceof Refused && error.isUnknown) hasRecord = false;
    }
    window.setTimeout(() => void run(), TURN_MS);
  };
  void run();
  return () => { ended = true; };
}

export function PathStage({ children }: { children?: preact.ComponentChildren }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const shown = useRef<Stage | null>(null);
  const count = useSignal(0);
  const cannot = useSignal(false);
  useEffect(() => {
    const stage = Stage.on(canvas.current!);
    if (!stage) { cannot.value = true; return undefined; }
    shown.current = stage;
    const room = obj("toolhead");
    if (room) stage.bed({ minimum: room.axis_minimum, maximum: room.axis_maximum });
    const stopTheme = effect(() => { themeTurn.value; mode.value; requestAnimationFrame(() => stage.paint(colour("grid"), colour("accent"), colour("ink"))); });
    const stopFollow = follow(stage, (points) => { count.value = points; });
    return () => { stopTheme(); stopFollow(); stage.end(); };
  }, []);
  return (
    <div class="stage">
      <canvas ref={canvas} tabIndex={0} role="img" aria-label="The executed path in 3D. Arrows turn it, plus and minus zoom." data-points={count.value} />
      {cannot.value && <p class="empty">This browser has no WebGL2, so there is no picture.</p>}
      <div class="stagetools">
        <Button kind="soft" label="The part" onPress={() => shown.current?.fit()}>Fit</Button>
        <Button kind="soft" label="From above" onPress={() => { const orbit = shown.current?.orbit; if (orbit) { orbit.turn = 0; orbit.tilt = 1.55; orbit.changed(); } }}>Top</Button>
      </div>
      {children}
    </div>
  );
}
