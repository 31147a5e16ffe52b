// Heaters, sensors and fans: what is, what is wanted, how hard it works.
import { Bar, Button, Card, NumberField, Slider } from "../shell/parts";
import { heaterLabel, num } from "../shell/format";
import { heaterNamed, heaterNames, isLive, obj, sensorNames } from "../state/machine";
import { script } from "../state/notices";
import { mayOperate } from "../state/session";
import { SHADES, TemperatureChart } from "./chart";

function setTarget(name: string, target: number): Promise<unknown> {
  return script(`SET_HEATER_TEMPERATURE HEATER=${name.replace("heater_generic ", "")} TARGET=${target}`);
}

function HeaterRow({ name, index }: { name: string; index: number }) {
  const heater = heaterNamed(name);
  if (!heater) return null;
  const label = heaterLabel(name);
  return (
    <tr>
      <td><i class={`dot ${SHADES[index % 6]}`} />{label}</td>
      <td class="n figure">{num(heater.temperature, 1)}<small> °C</small></td>
      <td class="n">
        <NumberField label={`${label}: target`} value={heater.target} unit="°C" min={0} max={heater.max_temp ?? 500} disabled={!mayOperate.value || !isLive.value} onSet={(value) => setTarget(name, value)} />
      </td>
      <td class="power"><Bar part={heater.power} label={`${label}: power`} /></td>
      <td class="n"><Button icon="cancel" kind="plain" label={`${label}: off`} disabled={!mayOperate.value || heater.target === 0} onPress={() => setTarget(name, 0)} /></td>
    </tr>
  );
}

function SensorRow({ name, index }: { name: string; index: number }) {
  const label = heaterLabel(name);
  return (
    <tr>
      <td><i class={`dot ${SHADES[index % 6]}`} />{label}</td>
      <td class="n figure">{num(heaterNamed(name)?.temperature, 1)}<small> °C</small></td>
      <td class="n quiet">sensor</td><td class="power" /><td />
    </tr>
  );
}

export function Temperatures() {
  const heaters = heaterNames.value;
  const all = [...heaters, ...sensorNames.value];
  return (
    <Card title="Temperatures" aside={<Button kind="plain" disabled={!mayOperate.value} onPress={() => script("TURN_OFF_HEATERS")}>All off</Button>}>
      <div class="scroll">
        <table class="heat">
          <thead><tr><th>Where</th><th class="n">Is</th><th class="n">Target</th><th>Power</th><th><span class="unseen">Off</span></th></tr></thead>
          <tbody>
            {heaters.map((name, index) => <HeaterRow key={name} name={name} index={index} />)}
            {sensorNames.value.map((name, index) => <SensorRow key={name} name={name} index={heaters.length + index} />)}
          </tbody>
        </table>
      </div>
      <TemperatureChart names={all} />
    </Card>
  );
}

/** Speed, flow and fans while it works. */
export function Overrides() {
  const move = obj("gcode_move");
  const fan = obj("fan");
  const may = mayOperate.value && isLive.value;
  const origin = move?.homing_origin[2] ?? 0;
  return (
    <Card title="Overrides">
      <Slider label="Speed" value={(move?.speed_factor ?? 1) * 100} min={10} max={300} reset={100} disabled={!may} onSet={(value) => script(`M220 S${value}`)} />
      {obj("extruder") && <Slider label="Flow" value={(move?.extrude_factor ?? 1) * 100} min={50} max={150} reset={100} disabled={!may} onSet={(value) => script(`M221 S${value}`)} />}
      {fan && <Slider label="Fan" value={fan.speed * 100} min={0} max={100} reset={0} disabled={!may} onSet={(value) => script(`SET_FAN_SPEED FAN=fan SPEED=${(value / 100).toFixed(2)}`)} />}
      {obj("extruder") && (
        <div class="row babystep">
          <span class="grow"><b>First layer</b> <small>Z shifted by {num(origin, 3)} mm</small></span>
          <Button icon="down" label="Nozzle 0.02 mm nearer to the bed" disabled={!may} onPress={() => script("M290 Z-0.02")} />
          <Button icon="up" label="Nozzle 0.02 mm further from the bed" disabled={!may} onPress={() => script("M290 Z0.02")} />
        </div>
      )}
    </Card>
  );
}
