// Filament by hand, and which tool is in use.
import { useSignal } from "@preact/signals";
import { Button, Card, Choice, NumberField } from "../shell/parts";
import { heaterLabel, num } from "../shell/format";
import { heaterNames, heaterNamed, isFree, obj } from "../state/machine";
import { script } from "../state/notices";
import { kept } from "../state/prefs";
import { mayOperate } from "../state/session";

const length = kept<number>("filament.length", 10);
const speed = kept<number>("filament.speed", 5);

export function Filament() {
  const isCold = useSignal(false);
  const hotends = heaterNames.value.filter((name) => /^extruder\d*$/.test(name));
  if (!hotends.length) return null;
  const used = obj("toolhead")?.extruder ?? "extruder";
  const heater = heaterNamed(used);
  const may = mayOperate.value && isFree.value;
  const cold = heater !== undefined && (heater.can_extrude === false || (heater.can_extrude === undefined && heater.temperature < 170));
  const push = (mm: number) => {
    isCold.value = cold;
    return cold ? undefined : script(`M83\nG1 E${mm} F${speed.value * 60}`);
  };
  return (
    <Card title="Filament" aside={heater && <span class={cold ? "tag warn" : "tag good"}>{cold ? `too cold: ${num(heater.temperature, 0)} °C` : "hot enough"}</span>}>
      {hotends.length > 1 && <Choice label="Tool in use" value={used} of={hotends.map((name) => [name, heaterLabel(name)] as const)} onPick={(name) => void script(`T${name.slice(8) || 0}`)} />}
      <div class="row wrap filament">
        <Choice label="Length in millimetres" value={length.value} of={[[1, "1"], [5, "5"], [10, "10"], [50, "50"], [100, "100"]]} onPick={(mm) => { length.value = mm; }} />
        <NumberField label="Speed of the filament" value={speed.value} unit="mm/s" min={1} max={60} onSet={(value) => { speed.value = value; }} />
      </div>
      <div class="row filament">
        <Button icon="up" class="grow" disabled={!may} onPress={() => push(-length.value)}>Draw back</Button>
        <Button icon="down" class="grow" disabled={!may} onPress={() => push(length.value)}>Push out</Button>
      </div>
      {isCold.value && cold && <p class="wrong" role="alert">It would not melt. Heat the hot end first.</p>}
    </Card>
  );
}
