// The mesh of the bed: in 3D and in figures, and how to measure a new one.
import { useEffect, useRef } from "preact/hooks";
import { effect, useSignal } from "@preact/signals";
import { Surface } from "../gl/surface";
import { Button, Card, Choice, Empty } from "../shell/parts";
import { num } from "../shell/format";
import { isFree, obj } from "../state/machine";
import { script } from "../state/notices";
import { colour, themeTurn } from "../state/prefs";
import { mayOperate } from "../state/session";

/** Where on the bed a point of the mesh is, for who does not see the picture. */
function whereabouts(rows: number[][], height: number): string {
  const y = rows.findIndex((row) => row.includes(height));
  const x = rows[y]?.indexOf(height) ?? 0;
  const third = (at: number, count: number, names: string[]) => names[Math.min(2, Math.floor((at + 0.5) * 3 / count))];
  return `${third(y, rows.length, ["front", "middle", "back"])} ${third(x, rows[y]?.length ?? 1, ["left", "centre", "right"])}`;
}

function Picture({ times, words }: { times: number; words: string }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const shown = useRef<Surface | null>(null);
  const mesh = obj("bed_mesh");
  useEffect(() => {
    const surface = Surface.on(canvas.current!);
    shown.current = surface;
    const stop = effect(() => { themeTurn.value; requestAnimationFrame(() => surface?.paint(colour("grid"))); });
    return () => { stop(); surface?.end(); };
  }, []);
  useEffect(() => {
    if (mesh?.mesh_matrix.length) shown.current?.show({ heights: mesh.mesh_matrix, minimum: mesh.mesh_min, maximum: mesh.mesh_max }, times);
  }, [mesh, times]);
  return (
    <div class="stage">
      <canvas ref={canvas} tabIndex={0} role="img" aria-label={`The bed in 3D: ${words}. Arrows turn it, + and − come near; its heights are in the table below.`} />
    </div>
  );
}

export function BedView() {
  const times = useSignal(100);
  const mesh = obj("bed_mesh");
  const heights = mesh?.probed_matrix ?? [];
  const all = heights.flat();
  const [low, high] = [Math.min(...all), Math.max(...all)];
  const mean = all.reduce((sum, one) => sum + one, 0) / Math.max(1, all.length);
  const [lowAt, highAt] = [whereabouts(heights, low), whereabouts(heights, high)];
  const words = `from ${num(low, 3)} mm at the ${lowAt} to ${num(high, 3)} mm at the ${highAt}`;
  const [x0, y0] = mesh?.mesh_min ?? [];
  const [x1, y1] = mesh?.mesh_max ?? [];
  const may = mayOperate.value && isFree.value;
  const measure = <Button kind="main" icon="bed" disabled={!may} onPress={() => script("G29")}>Measure the bed</Button>;
  return (
    <>
      <h1 class="unseen">Bed</h1>
      {!all.length && <Card title="Bed"><Empty>No mesh is in use. {measure}</Empty></Card>}
      {all.length > 0 && (
        <div class="stack">
          <section class="card jobcard tall" aria-label="Mesh">
            <Picture times={times.value} words={words} />
            <div class="jobbody">
              <div class="row wrap between">
                <div class="row"><h2>{mesh?.profile_name || "Mesh"}</h2><span class="tag">{heights[0]?.length} by {heights.length}</span><small class="quiet">X {num(x0, 0)} to {num(x1, 0)}, Y {num(y0, 0)} to {num(y1, 0)} mm</small></div>
                <div class="row wrap">
                  <Choice label="How much heights are stretched" value={times.value} of={[[20, "20×"], [100, "100×"], [300, "300×"]]} onPick={(value) => { times.value = value; }} />
                  <Button disabled={!may} onPress={() => script("G28 Z")}>Home Z</Button>
                  {measure}
                </div>
              </div>
              <div class="tiles">
                {([[`lowest, ${lowAt}`, low], [`highest, ${highAt}`, high], ["range", high - low], ["mean", mean]] as const).map(([what, value]) => <div key={what}><b>{num(value, 3)}<small> mm</small></b><span>{what}</span></div>)}
              </div>
            </div>
          </section>
          <Card title="Heights">
            <div class="scroll" tabIndex={0} role="group" aria-label="Heights in millimetres">
              <table class="mesh">
                <tbody>
                  {[...heights].reverse().map((row, y) => (
                    <tr key={y}>{row.map((value, x) => <td key={x} class={`n h${Math.round(((value - low) / Math.max(1e-6, high - low)) * 6)}`}>{num(value, 3)}</td>)}</tr>
                  ))}
                </tbody>
              </table>
            </div>
          </Card>
        </div>
      )}
    </>
  );
}
