// The 3D view of what has been executed, fed by the board's own record of it.
import { useEffect, useRef } from "preact/hooks";
import { effect, useSignal } from "@preact/signals";
import { Stage } from "../gl/stage";
import { Button } from "../shell/parts";
import { mode, obj } from "../state/machine";
import { colour, themeTurn } from "../state/prefs";
import { drawOn } from "./record";

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
    const stopRecord = drawOn(stage);
    const counter = window.setInterval(() => { count.value = stage.points; }, 500);
    return () => { stopTheme(); stopRecord(); clearInterval(counter); stage.end(); };
  }, []);
  return (
    <div class="stage">
      <canvas ref={canvas} tabIndex={0} role="img" aria-label="The executed path in 3D. Arrows turn it, plus and minus zoom." data-points={count.value} />
      {cannot.value && <p class="empty">This browser has no WebGL2, so there is no picture.</p>}
      <div class="stagetools">
        <Button kind="soft" title="Bring the part into view" onPress={() => shown.current?.fit()}>Fit</Button>
        <Button kind="soft" title="Look from above" onPress={() => { const orbit = shown.current?.orbit; if (orbit) { orbit.turn = 0; orbit.tilt = 1.55; orbit.changed(); } }}>Top</Button>
      </div>
      {children}
    </div>
  );
}
