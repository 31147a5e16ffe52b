// Small parts that every view is made of.
import type { ComponentChildren } from "preact";
import { useEffect, useId, useRef } from "preact/hooks";
import { useSignal } from "@preact/signals";
import { Icon, type IconName } from "./icon";

export function Card(props: { title?: string; aside?: ComponentChildren; class?: string; children: ComponentChildren; id?: string }) {
  const id = useId();
  return (
    <section class={`card ${props.class ?? ""}`} id={props.id} aria-labelledby={props.title ? id : undefined}>
      {props.title && <div class="cardhead"><h2 id={id}>{props.title}</h2>{props.aside}</div>}
      {props.children}
    </section>
  );
}

interface ButtonProps {
  onPress?: () => unknown;
  icon?: IconName;
  kind?: "main" | "soft" | "plain" | "danger";
  label?: string;
  disabled?: boolean;
  pressed?: boolean;
  submit?: boolean;
  class?: string;
  title?: string;
  children?: ComponentChildren;
}
/** A button that shows that it is busy until what it does has ended. */
export function Button(props: ButtonProps) {
  const busy = useSignal(false);
  const press = async () => {
    const going = props.onPress?.();
    if (!(going instanceof Promise)) return;
    busy.value = true;
    try { await going; } finally { busy.value = false; }
  };
  return (
    <button
      type={props.submit ? "submit" : "button"}
      class={`button ${props.kind ?? "soft"} ${props.children ? "" : "square"} ${props.class ?? ""}`}
      aria-label={props.label}
      title={props.title ?? (props.children ? undefined : props.label)}
      aria-pressed={props.pressed}
      aria-busy={busy.value || undefined}
      disabled={props.disabled}
      onClick={props.onPress ? press : undefined}
    >
      {props.icon && <Icon name={props.icon} />}
      {props.children && <span>{props.children}</span>}
    </button>
  );
}

/** One of a few: radio buttons that look like one switch. */
export function Choice<T extends string | number>(props: { label: string; value: T; of: readonly (readonly [T, string])[]; onPick: (value: T) => void }) {
  const name = useId();
  return (
    <fieldset class="choice">
      <legend class="unseen">{props.label}</legend>
      {props.of.map(([value, text]) => (
        <label key={value}>
          <input type="radio" name={name} checked={props.value === value} onChange={() => props.onPick(value)} />
          <span>{text}</span>
        </label>
      ))}
    </fieldset>
  );
}

export function Dialog(props: { title: string; onClose: () => void; children: ComponentChildren; wide?: boolean }) {
  const box = useRef<HTMLDialogElement>(null);
  const id = useId();
  useEffect(() => { box.current?.showModal(); }, []);
  const onBackdrop = (event: MouseEvent) => { if (event.target === box.current) props.onClose(); };
  return (
    // biome-ignore lint/a11y/useKeyWithClickEvents: Escape closes a dialog by itself.
    <dialog ref={box} class={props.wide ? "wide" : ""} aria-labelledby={id} onClose={props.onClose} onClick={onBackdrop}>
      <div class="cardhead">
        <h2 id={id}>{props.title}</h2>
        <Button icon="cancel" kind="plain" label="Close" onPress={props.onClose} />
      </div>
      {props.children}
    </dialog>
  );
}

/** A number that is typed, and sent by Enter or on leaving the field. */
export function NumberField(props: {
  label: string; value: number; unit?: string; min?: number; max?: number; step?: number; digits?: number; disabled?: boolean; onSet: (value: number) => unknown;
}) {
  const typed = useSignal<string | null>(null);
  const shown = typed.value ?? props.value.toFixed(props.digits ?? 0);
  const send = () => {
    const value = Number((typed.peek() ?? "").replace(",", "."));
    if (typed.peek() !== null && typed.peek() !== "" && Number.isFinite(value) && value !== props.value) {
      props.onSet(Math.min(props.max ?? Number.POSITIVE_INFINITY, Math.max(props.min ?? Number.NEGATIVE_INFINITY, value)));
    }
    typed.value = null;
  };
  return (
    <span class={`field ${!props.unit ? "bare" : props.unit.length > 2 ? "long" : ""}`}>
      <input
        type="text" inputMode="decimal" aria-label={props.label} value={shown} disabled={props.disabled}
        onFocus={(event) => event.currentTarget.select()}
        onInput={(event) => { typed.value = event.currentTarget.value; }}
        onBlur={send}
        onKeyDown={(event) => {
          if (event.key === "Enter") { event.preventDefault(); send(); event.currentTarget.select(); }
          if (event.key === "Escape") { typed.value = null; event.currentTarget.blur(); }
        }}
      />
      {props.unit && <small>{props.unit}</small>}
    </span>
  );
}

/** A slider for a share of something, sent when let go, so that a drag is one command. */
export function Slider(props: {
  label: string; value: number; min: number; max: number; step?: number; unit?: string; disabled?: boolean; reset?: number; onSet: (value: number) => unknown;
}) {
  const dragged = useSignal<number | null>(null);
  const value = dragged.value ?? props.value;
  const id = useId();
  return (
    <div class="slider">
      <label for={id}>{props.label}</label>
      <output for={id}>{Math.round(value)}<small> {props.unit ?? "%"}</small></output>
      {props.reset !== undefined && (
        <Button icon="undo" kind="plain" label={`${props.label}: back to ${props.reset} ${props.unit ?? "%"}`} disabled={props.disabled || Math.round(props.value) === props.reset}
          onPress={() => props.onSet(props.reset ?? 0)} />
      )}
      <input
        id={id} type="range" min={props.min} max={props.max} step={props.step ?? 1} value={value} disabled={props.disabled}
        onInput={(event) => { dragged.value = event.currentTarget.valueAsNumber; }}
        onChange={(event) => {
          const chosen = event.currentTarget.valueAsNumber;
          dragged.value = null;
          props.onSet(chosen);
        }}
      />
    </div>
  );
}

export function Bar({ part, label }: { part: number; label: string }) {
  return <progress class="bar" max={1} value={Math.min(1, Math.max(0, part))} aria-label={label} />;
}

export function Empty({ children }: { children: ComponentChildren }) {
  return <p class="empty">{children}</p>;
}
