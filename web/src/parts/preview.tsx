// The path of a file before it is made, in 3D, with a slider through it.
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { Stage } from "../gl/stage";
import { isPrinter, obj } from "../state/machine";
import { colour } from "../state/prefs";
import { readFile } from "./gcode";

export function Preview({ path }: { path: string }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const shown = useRef<Stage | null>(null);
  const share = useSignal(100);
  const count = useSignal(0);
  const said = useSignal("The file is read…");
  useEffect(() => {
    const stage = Stage.on(canvas.current!);
    if (!stage) { said.value = "This browser has no WebGL2, so there is no picture."; return undefined; }
    shown.current = stage;
    stage.hasTail = false;
    const room = obj("toolhead");
    if (room) stage.bed({ minimum: room.axis_minimum, maximum: room.axis_maximum });
    stage.paint(colour("grid"), colour("accent"), colour("ink"));
    const stop = new AbortController();
    readFile(path, isPrinter.peek(), stop.signal, (points) => { stage.add(points); stage.follow(); count.value = stage.points; })
      .then(() => { said.value = ""; })
      .catch((error: Error) => { if (!stop.signal.aborted) said.value = error.message; });
    return () => { stop.abort(); stage.end(); };
  }, [path]);
  return (
    <div class="preview">
      <div class="stage">
        <canvas ref={canvas} tabIndex={0} role="img" aria-label="The path of the file in 3D. Arrows turn it, plus and minus zoom." data-points={count.value} />
        {said.value && <p class="stagenote">{said.value}</p>}
      </div>
      <input type="range" min={0} max={100} step={0.2} value={share.value} aria-label="How far into the file"
        onInput={(event) => { share.value = event.currentTarget.valueAsNumber; if (shown.current) shown.current.upTo(share.value / 100); }} />
    </div>
  );
}
