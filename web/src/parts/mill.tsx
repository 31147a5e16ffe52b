// What a mill or a lathe shows: positions to be read from across the shop, spindle, signals.
import { useSignal } from "@preact/signals";
import type { Axis } from "../api/types";
import { Button, Card, Choice, NumberField, Slider } from "../shell/parts";
import { num } from "../shell/format";
import { isFree, isLive, obj } from "../state/machine";
import { ask, script } from "../state/notices";
import { mayOperate } from "../state/session";

export function setWork(axis: Axis, value: number): Promise<unknown> {
  return script(`G10 L20 P0 ${axis.toUpperCase()}${value}`);
}

function AxisRow({ axis, index, work }: { axis: Axis; index: number; work: boolean }) {
  const machine = obj("motion_report")?.live_position[index];
  const place = obj("velvet")?.work_position[index];
  const isHomed = obj("toolhead")?.homed_axes.includes(axis) ?? false;
  const may = mayOperate.value && isFree.value;
  const [big, small] = work ? [place, machine] : [machine, place];
  return (
    <div class={`axis ${isHomed ? "" : "unsure"}`}>
      <b class="name">{axis.toUpperCase()}</b>
      <span class="big">{num(big, 3)}</span>
      <span class="small quiet">{num(small, 3)}<br />{work ? "machine" : "work"}{!isHomed && ", not homed"}</span>
      <Button disabled={!may} label={`${axis.toUpperCase()}: zero here`} onPress={() => setWork(axis, 0)}>Zero</Button>
      <Button disabled={!may} label={`${axis.toUpperCase()}: ½, the middle between zero and here`} title="Half of what is shown: the middle between zero and here" onPress={() => setWork(axis, (place ?? 0) / 2)}>½</Button>
    </div>
  );
}

export function Readout() {
  const isWork = useSignal(true);
  const velvet = obj("velvet");
  const may = mayOperate.value && isFree.value;
  if (!velvet) return null;
  const zeroAll = () => script(`G10 L20 P0 ${velvet.axes.map((axis) => `${axis.toUpperCase()}0`).join(" ")}`);
  return (
    <Card title="Position" aside={(
      <div class="row">
        <select aria-label="Work coordinates" value={velvet.coordinates.active} disabled={!may} onChange={(event) => void script(event.currentTarget.value)}>
          {velvet.coordinates.offsets.map((one) => <option key={one.name}>{one.name}</option>)}
        </select>
        <Choice label="Which position is large" value={isWork.value ? "work" : "machine"} of={[["work", "Work"], ["machine", "Machine"]]} onPick={(which) => { isWork.value = which === "work"; }} />
      </div>
    )}>
      <div class="readout">{velvet.axes.map((axis, index) => <AxisRow key={axis} axis={axis} index={index} work={isWork.value} />)}</div>
      <div class="row wrap readfoot">
        <span class="grow quiet">{num((obj("motion_report")?.live_velocity ?? 0) * 60, 0)} mm/min{velvet.tool && `, T${velvet.tool.number} ${velvet.tool.name}`}</span>
        <Button disabled={!may} onPress={() => script("G53 G0 Z0")}>Z up</Button>
        <Button disabled={!may} onPress={() => script("G53 G0 Z0\nG0 X0 Y0")}>To X0 Y0</Button>
        <Button disabled={!may} onPress={zeroAll}>Zero all</Button>
      </div>
    </Card>
  );
}

export function SpindleCard() {
  const spindle = obj("velvet")?.spindle;
  const coolant = obj("velvet")?.coolant;
  const may = mayOperate.value && isLive.value;
  const wanted = useSignal(0);
  if (!spindle) return null;
  const speed = wanted.value || spindle.target || Math.min(12000, spindle.max_rpm);
  const turn = (code: string) => script(`${code} S${speed}`);
  return (
    <Card title="Spindle" aside={<b class="figure">{num(spindle.rpm, 0)}<small> rpm</small></b>}>
      <div class="row wrap rpm">
        <NumberField label="Spindle speed" value={speed} unit="rpm" min={0} max={spindle.max_rpm} disabled={!may} onSet={(value) => { wanted.value = value; if (spindle.direction !== "off") void script(`M3 S${value}`); }} />
        <Button pressed={spindle.direction === "clockwise"} disabled={!may} onPress={() => turn("M3")}>Right</Button>
        <Button pressed={spindle.direction === "counterclockwise"} disabled={!may} onPress={() => turn("M4")}>Left</Button>
        <Button kind={spindle.direction === "off" ? "soft" : "danger"} disabled={!may} onPress={() => script("M5")}>Off</Button>
      </div>
      {coolant && (
        <div class="row wrap coolant">
          <span class="quiet">Coolant</span>
          <Button pressed={coolant.flood} disabled={!may} onPress={() => script(coolant.flood ? "M9" : "M8")}>Flood</Button>
          <Button pressed={coolant.mist} disabled={!may} onPress={() => script(coolant.mist ? "M9" : "M7")}>Mist</Button>
        </div>
      )}
    </Card>
  );
}

export function MillOverrides() {
  const overrides = obj("velvet")?.overrides;
  const may = mayOperate.value && isLive.value;
  if (!overrides) return null;
  return (
    <Card title="Overrides">
      <Slider label="Feed" value={overrides.feed * 100} min={10} max={200} reset={100} disabled={!may} onSet={(value) => ask("velvet.override.set", { feed: value / 100 })} />
      <div class="row between">
        <span><b>Rapids</b></span>
        <Choice label="Rapids" value={Math.round(overrides.rapid * 100)} of={[[25, "25 %"], [50, "50 %"], [100, "100 %"]]} onPick={(value) => void ask("velvet.override.set", { rapid: value / 100 })} />
      </div>
      {obj("velvet")?.spindle && <Slider label="Spindle" value={overrides.spindle * 100} min={10} max={200} reset={100} disabled={!may} onSet={(value) => ask("velvet.override.set", { spindle: value / 100 })} />}
    </Card>
  );
}

export function Signals() {
  const velvet = obj("velvet");
  if (!velvet) return null;
  const all = Object.entries(velvet.limits).map(([name, on]) => [name.replace("_", " "), on] as const);
  return (
    <ul class="signals">
      {all.map(([name, on]) => <li key={name} class={on ? "on" : ""}><i />{name}<span class="unseen">{on ? ", pressed" : ", free"}</span></li>)}
      {velvet.probe && <li class={velvet.probe.is_triggered ? "on" : ""}><i />probe<span class="unseen">{velvet.probe.is_triggered ? ", touches" : ", free"}</span></li>}
    </ul>
  );
}

export function LaserCard() {
  const laser = obj("velvet")?.laser;
  if (!laser) return null;
  const { on, open } = laser;
  const what = open[0] ? `locked: ${open.join(", ")}` : laser.test ? "test" : laser.framing ? "framing" : on ? "fires" : laser.mode;
  return (
    <Card title="Laser" aside={<b class="figure">{num(laser.power * 100, 1)}<small> %</small></b>}>
      <div class="row between"><span class={on ? "tag bad" : "tag"}>{what}</span><Button kind="danger" disabled={!mayOperate.value || !isLive.value} onPress={() => script("M5")}>Off</Button></div>
    </Card>
  );
}
