// Moving by hand: a pad for mouse, finger and keys, homing, positions.
import { Button, Card, Choice, NumberField } from "../shell/parts";
import { num } from "../shell/format";
import { Icon, type IconName } from "../shell/icon";
import { isFree, isPrinter, obj } from "../state/machine";
import { ask, script } from "../state/notices";
import { mayOperate } from "../state/session";
import type { Axis } from "../api/types";
import { begin, end, isContinuous, jogFeed, jogFeedZ, jogStep, running, STEPS, step } from "./jogging";

const LABELS: Record<string, string> = { x1: "X +", "x-1": "X −", y1: "Y +", "y-1": "Y −", z1: "Z +", "z-1": "Z −" };

function JogButton({ axis, direction, icon }: { axis: Axis; direction: 1 | -1; icon: IconName }) {
  const name = `${axis}${direction}`;
  const stop = () => { if (running.peek() === name) end(); };
  return (
    <button
      type="button" class={`jog ${axis}${direction > 0 ? "plus" : "minus"} ${running.value === name ? "on" : ""}`} aria-label={LABELS[name]}
      disabled={!isFree.value || !mayOperate.value}
      onPointerDown={(event) => {
        if (!isContinuous.peek() || event.button !== 0) return;
        event.currentTarget.setPointerCapture(event.pointerId);
        void begin(axis, direction);
      }}
      onPointerUp={stop} onPointerCancel={stop} onLostPointerCapture={stop}
      onClick={() => { if (!isContinuous.peek()) void step(axis, direction); }}
      onContextMenu={(event) => event.preventDefault()}
    >
      <Icon name={icon} /><span aria-hidden="true">{LABELS[name]}</span>
    </button>
  );
}

const KEYS: Record<string, [Axis, 1 | -1]> = {
  ArrowRight: ["x", 1], ArrowLeft: ["x", -1], ArrowUp: ["y", 1], ArrowDown: ["y", -1], PageUp: ["z", 1], PageDown: ["z", -1],
};

// Wherever the focus is by then: a key that is let go ends what it began.
window.addEventListener("keyup", (event) => { if (KEYS[event.key] && running.peek()) end(); });

function onPadKey(event: KeyboardEvent): void {
  const way = KEYS[event.key];
  const at = STEPS.indexOf(jogStep.peek() as 1);
  if (way) {
    if (!isFree.peek() || !mayOperate.peek()) return;
    if (isContinuous.peek()) { if (!event.repeat) void begin(...way); }
    else if (!event.repeat) void step(...way);
  } else if (event.key === "+" || event.key === "-") jogStep.value = STEPS[Math.min(STEPS.length - 1, Math.max(0, at + (event.key === "+" ? 1 : -1)))]!;
  else if (event.key === "h" || event.key === "H") void home("");
  else if (event.key === "Escape") { end(); (event.currentTarget as HTMLElement).blur(); }
  else return;
  event.preventDefault();
  event.stopPropagation();
}

export function home(axes: string): Promise<unknown> {
  return ask("velvet.home", { axes });
}

/** The pad takes the keys while it has the focus, so that no arrow key moves a machine by accident. */
export function JogPad() {
  const pad = ["y", "x", "z"] as const;
  return (
    <div class="jogpad" role="group" aria-label="Jog pad: arrows move X and Y, page up and down Z" tabIndex={0} onKeyDown={onPadKey}
      onFocusOut={(event) => { if (!event.currentTarget.contains(event.relatedTarget as Node | null)) end(); }}>
      <JogButton axis={pad[0]} direction={1} icon="up" />
      <JogButton axis={pad[1]} direction={-1} icon="left" />
      <button type="button" class="jog all" disabled={!mayOperate.value || !isFree.value} onClick={() => void home("")} aria-label="Home all axes"><Icon name="home" /><span aria-hidden="true">Home</span></button>
      <JogButton axis={pad[1]} direction={1} icon="right" />
      <JogButton axis={pad[0]} direction={-1} icon="down" />
      <JogButton axis={pad[2]} direction={1} icon="up" />
      <JogButton axis={pad[2]} direction={-1} icon="down" />
    </div>
  );
}

export function HomeButtons() {
  const homed = obj("toolhead")?.homed_axes ?? "";
  return (
    <div class="row wrap homes">
      {(obj("velvet")?.axes ?? ["x", "y", "z"]).map((axis) => (
        <Button key={axis} icon={homed.includes(axis) ? "check" : "home"} label={`Home ${axis.toUpperCase()}${homed.includes(axis) ? ", is homed" : ""}`} disabled={!mayOperate.value || !isFree.value} onPress={() => home(axis)}>
          {axis.toUpperCase()}
        </Button>
      ))}
      <Button icon="home" kind={homed ? "soft" : "main"} disabled={!mayOperate.value || !isFree.value} onPress={() => home("")}>Home all</Button>
    </div>
  );
}

export function JogSettings() {
  return (
    <div class="jogset">
      <Choice label="How to jog" value={isContinuous.value ? "hold" : "step"} of={[["step", "Steps"], ["hold", "While held"]]} onPick={(way) => { isContinuous.value = way === "hold"; }} />
      {!isContinuous.value && <Choice label="Step in millimetres" value={jogStep.value} of={STEPS.map((one) => [one, String(one)] as const)} onPick={(mm) => { jogStep.value = mm; }} />}
      <div class="row wrap speeds">
        <span>Speed XY <NumberField label="Speed of X and Y" value={jogFeed.value / 60} unit="mm/s" digits={0} min={1} max={1000} onSet={(value) => { jogFeed.value = value * 60; }} /></span>
        <span>Z <NumberField label="Speed of Z" value={jogFeedZ.value / 60} unit="mm/s" digits={0} min={1} max={200} onSet={(value) => { jogFeedZ.value = value * 60; }} /></span>
      </div>
    </div>
  );
}

function Positions() {
  const live = obj("motion_report")?.live_position ?? obj("toolhead")?.position ?? [];
  const homed = obj("toolhead")?.homed_axes ?? "";
  return (
    <div class="tiles positions">
      {(obj("velvet")?.axes ?? (["x", "y", "z"] as const)).map((axis, index) => (
        <div key={axis} class={homed.includes(axis) ? "" : "unsure"}><b>{num(live[index])}</b><span>{axis.toUpperCase()}{homed.includes(axis) ? "" : ", not homed"}</span></div>
      ))}
      <div><b>{num(obj("motion_report")?.live_velocity, 0)}</b><span>mm/s</span></div>
    </div>
  );
}

export function Move() {
  return (
    <Card title="Move" aside={<Button kind="plain" disabled={!mayOperate.value || !isFree.value} onPress={() => script("M18")}>Motors off</Button>}>
      {isPrinter.value && <Positions />}
      <JogSettings />
      <JogPad />
      <HomeButtons />
    </Card>
  );
}
