// A mill's work: where zero is in each system of coordinates, and a guide that finds it with the probe.
import { useSignal } from "@preact/signals";
import type { Axis } from "../api/types";
import { Button, Card, Choice, NumberField } from "../shell/parts";
import { num } from "../shell/format";
import { Icon } from "../shell/icon";
import { isFree, obj } from "../state/machine";
import { script, say } from "../state/notices";
import { kept } from "../state/prefs";
import { mayOperate } from "../state/session";
import { JogPad, JogSettings } from "../parts/move";
import { Readout, Signals } from "../parts/mill";

function Offsets() {
  const velvet = obj("velvet");
  const may = mayOperate.value && isFree.value;
  if (!velvet) return null;
  return (
    <Card title="Work offsets">
      <div class="scroll">
        <table class="offsets">
          <thead><tr><th>System</th>{velvet.axes.map((axis) => <th key={axis} class="n">{axis.toUpperCase()}</th>)}<th><span class="unseen">In use</span></th></tr></thead>
          <tbody>
            {velvet.coordinates.offsets.map((one, row) => {
              const isActive = one.name === velvet.coordinates.active;
              return (
                <tr key={one.name} class={isActive ? "active" : ""}>
                  <td><b>{one.name}</b></td>
                  {velvet.axes.map((axis, index) => (
                    <td key={axis} class="n"><NumberField label={`${one.name} ${axis.toUpperCase()}`} value={one.at[index] ?? 0} digits={3} disabled={!may} onSet={(value) => script(`G10 L2 P${row + 1} ${axis.toUpperCase()}${value}`)} /></td>
                  ))}
                  <td class="n">{isActive ? <span class="tag accent">in use</span> : <Button disabled={!may} onPress={() => script(one.name)}>Use</Button>}</td>
                </tr>
              );
            })}
          </tbody>
        </table>
      </div>
    </Card>
  );
}

type Target = "top" | "left" | "right" | "front" | "back";
const TARGETS: [Target, string][] = [["top", "Top"], ["left", "Left edge"], ["right", "Right edge"], ["front", "Front edge"], ["back", "Back edge"]];
const WAYS: Record<Target, { axis: Axis; sign: 1 | -1; where: string }> = {
  top: { axis: "z", sign: -1, where: "above the place that is to be Z 0" },
  left: { axis: "x", sign: 1, where: "left of the part, below its top" },
  right: { axis: "x", sign: -1, where: "right of the part, below its top" },
  front: { axis: "y", sign: 1, where: "in front of the part, below its top" },
  back: { axis: "y", sign: -1, where: "behind the part, below its top" },
};
const plate = kept("probe.plate", 0);
const tip = kept("probe.tip", 3);
const reach = kept("probe.reach", 20);
const feed = kept("probe.feed", 100);

/** Lines that search twice, fast and slowly, set the offset and go back. */
function search(target: Target): string {
  const { axis, sign } = WAYS[target];
  const word = axis.toUpperCase();
  const found = axis === "z" ? plate.value : -sign * tip.value / 2;
  return [
    "G21 G91", `G38.2 ${word}${sign * reach.value} F${feed.value}`, `G0 ${word}${-sign}`, `G38.2 ${word}${sign * 2} F${Math.max(10, feed.value / 5)}`,
    "G90", `G10 L20 P0 ${word}${found}`, `G91 G0 ${word}${-sign * 5}`, "G90",
  ].join("\n");
}

function ProbeGuide() {
  const step = useSignal(0);
  const target = useSignal<Target>("top");
  const probe = obj("velvet")?.probe;
  const may = mayOperate.value && isFree.value;
  const way = WAYS[target.value];
  const steps = ["What to find", "Set it up", "Try the contact", "Search"];
  const go = async () => {
    if (await script(search(target.value))) { say("done", `${way.axis.toUpperCase()} 0 of ${obj("velvet")?.coordinates.active} is found.`); step.value = 0; }
  };
  if (!probe) return null;
  return (
    <Card title="Find zero with the probe">
      <ol class="steps">{steps.map((name, at) => <li key={name} class={at === step.value ? "now" : at < step.value ? "done" : ""} aria-current={at === step.value ? "step" : undefined}>{name}</li>)}</ol>
      <div class="guide">
        {step.value === 0 && <Choice label="What to find" value={target.value} of={TARGETS} onPick={(value) => { target.value = value; }} />}
        {step.value === 1 && (
          <>
            <p>Jog until the tip is {way.where}, less than {num(reach.value, 0)} mm from it.</p>
            <div class="row wrap fields">
              {way.axis === "z"
                ? <span>Plate is thick <NumberField label="Thickness of the plate" value={plate.value} unit="mm" digits={2} min={0} onSet={(value) => { plate.value = value; }} /></span>
                : <span>Tip is wide <NumberField label="Diameter of the tip" value={tip.value} unit="mm" digits={2} min={0} onSet={(value) => { tip.value = value; }} /></span>}
              <span>Search for <NumberField label="Longest search" value={reach.value} unit="mm" min={1} max={200} onSet={(value) => { reach.value = value; }} /></span>
              <span>at <NumberField label="Speed of the search" value={feed.value} unit="/min" min={10} max={2000} onSet={(value) => { feed.value = value; }} /></span>
            </div>
            <JogSettings /><JogPad />
          </>
        )}
        {step.value === 2 && <><p>Touch the tip by hand, or hold the clip to the plate: the lamp of the probe must light. Then let go.</p><Signals /></>}
        {step.value === 3 && <><p>The machine moves {way.axis.toUpperCase()} {way.sign > 0 ? "up to" : "down to"} {num(reach.value, 0)} mm until the probe touches, sets {way.axis.toUpperCase()} of {obj("velvet")?.coordinates.active}, and goes back 5 mm.</p><pre class="code">{search(target.value)}</pre></>}
      </div>
      <div class="row end">
        {step.value > 0 && <Button icon="left" onPress={() => { step.value -= 1; }}>Back</Button>}
        {step.value < 3
          ? <Button kind="main" onPress={() => { step.value += 1; }}>Next</Button>
          : <Button kind="main" icon="down" disabled={!may} onPress={go}>Search</Button>}
      </div>
      {probe.last && <p class="note row"><Icon name="info" /> Last contact at machine {probe.last.map((value, at) => `${"XYZABC"[at]} ${num(value, 3)}`).join(", ")}</p>}
    </Card>
  );
}

export function WorkView() {
  return (
    <>
      <h1 class="unseen">Work</h1>
      <div class="grid">
        <div class="stack span7"><Readout /><Offsets /></div>
        <div class="stack span5"><ProbeGuide /></div>
      </div>
    </>
  );
}
