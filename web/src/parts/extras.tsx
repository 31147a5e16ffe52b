// Buttons of people's own, and what the machine has said last.
import { useSignal } from "@preact/signals";
import { Button, Card, Dialog, Empty } from "../shell/parts";
import { clock, plainName } from "../shell/format";
import { keep, type Macro, macros, named, play, played, press } from "../state/buttons";
import { codes, consoleLines, isBad } from "../state/history";
import { eventTime, isFree, isLive, mode, obj } from "../state/machine";
import { script } from "../state/notices";
import { isOwner, mayOperate } from "../state/session";

function EditButtons({ onClose }: { onClose: () => void }) {
  const all = useSignal<Macro[]>(macros.peek().length ? macros.peek() : [{ label: "", script: "", confirm: false }]);
  const change = (at: number, fields: Partial<Macro>) => { all.value = all.peek().map((one, n) => (n === at ? { ...one, ...fields } : one)); };
  const up = (at: number) => { all.value = all.peek().map((one, n, of) => (n === at - 1 ? of[at]! : n === at ? of[at - 1]! : one)); };
  const store = async (event: Event) => {
    event.preventDefault();
    if (await keep(all.peek().filter((one) => one.label.trim()))) onClose();
  };
  return (
    <Dialog title="Buttons" onClose={onClose} wide>
      <form class="form" onSubmit={store}>
        {all.value.map((one, at) => (
          <fieldset key={at} class="madebutton">
            <legend class="unseen">Button {at + 1}</legend>
            <div class="row">
              <input class="grow" type="text" aria-label="Words on the button" placeholder="Words on the button" maxLength={40} value={one.label} onInput={(event) => change(at, { label: event.currentTarget.value })} />
              <Button icon="up" kind="plain" label="Further up" disabled={!at} onPress={() => up(at)} />
              <Button icon="trash" kind="plain" label="Remove this button" onPress={() => { all.value = all.peek().filter((_, n) => n !== at); }} />
            </div>
            <textarea aria-label="Lines that it sends" placeholder={"Lines that it sends, such as\nG28\nM104 S200"} rows={Math.min(8, Math.max(2, one.script.split("\n").length))} spellcheck={false} value={one.script} onInput={(event) => change(at, { script: event.currentTarget.value })} />
            <label class="check"><input type="checkbox" checked={one.confirm} onChange={(event) => change(at, { confirm: event.currentTarget.checked })} /> Ask before they are sent</label>
          </fieldset>
        ))}
        <div class="row between wrap">
          <Button onPress={() => { all.value = [...all.peek(), { label: "", script: "", confirm: false }]; }}>Another button</Button>
          <Button kind="main" submit>Keep</Button>
        </div>
        <p class="note">Kept on the card, for every browser. Files in its folder macros are buttons as well.</p>
      </form>
    </Dialog>
  );
}

/** Macros of the printer.cfg. What is typed goes with the next one alone. */
function Named({ may }: { may: boolean }) {
  const words = useSignal("");
  const help = new Map(codes.value);
  const run = (name: string) => {
    const line = `${name} ${words.peek()}`;
    words.value = "";
    return script(line);
  };
  return (
    <>
      <input type="text" aria-label="Parameters of the next macro" placeholder="Parameters of a macro: BED=60" spellcheck={false} disabled={!may} value={words.value} onInput={(event) => { words.value = event.currentTarget.value; }} />
      <div class="row wrap" role="group" aria-label="Macros of the printer.cfg">
        {named.value.map((name) => <Button key={name} disabled={!may} title={help.get(name.toUpperCase()) ?? name} onPress={() => run(name)}>{name}</Button>)}
      </div>
    </>
  );
}

export function Macros() {
  const asked = useSignal<Macro | null>(null);
  const isEdited = useSignal(false);
  const may = mayOperate.value && isLive.value && mode.value !== "Alarm";
  const isEmpty = !macros.value.length && !played.value.length && !named.value.length;
  if (isEmpty && !isOwner.value) return null;
  const begin = (one: Macro) => {
    if (!one.confirm) return press(one);
    asked.value = one;
    return undefined;
  };
  return (
    <Card title="Buttons" aside={isOwner.value && <Button icon="edit" kind="plain" label="Make and change buttons" onPress={() => { isEdited.value = true; }} />}>
      {isEmpty && <Empty>Make a button of lines that you send often.</Empty>}
      <div class="stack">
        <div class="row wrap">
          {macros.value.map((one, at) => <Button key={at} disabled={!may} title={one.script} onPress={() => begin(one)}>{one.label}</Button>)}
          {played.value.map((name) => <Button key={name} icon="play" disabled={!mayOperate.value || !isFree.value} title={`Plays macros/${name}`} onPress={() => play(name)}>{plainName(name)}</Button>)}
        </div>
        {named.value.length > 0 && <Named may={may} />}
      </div>
      {isEdited.value && <EditButtons onClose={() => { isEdited.value = false; }} />}
      {asked.value && (
        <Dialog title={`${asked.value.label}?`} onClose={() => { asked.value = null; }}>
          <pre class="code">{asked.value.script}</pre>
          <div class="row end">
            <Button onPress={() => { asked.value = null; }}>No</Button>
            <Button kind="main" onPress={async () => { const one = asked.peek(); asked.value = null; if (one) await press(one); }}>{asked.value.label}</Button>
          </div>
        </Dialog>
      )}
    </Card>
  );
}

interface Word { time: number; isBad: boolean; text: string; remedy?: string }

/** What the machine counts as a message, or else the last lines that were more than an answer. */
function lastWords(): Word[] {
  const told = obj("velvet_messages")?.messages;
  if (told) return told.map((one) => ({ ...one, time: one.time + Date.now() / 1000 - eventTime.peek(), isBad: one.level === "error" }));
  return consoleLines.value.filter((line) => line.type === "response" && !/^ok\b/.test(line.message))
    .map((line) => ({ time: line.time, isBad: isBad(line.message), text: line.message.replace(/^(!!|\/\/|error:) ?/, "") }));
}

export function LastWords() {
  const said = lastWords().slice(-5).reverse();
  return (
    <Card title="Messages" aside={<a class="more" href="#/console">Console</a>}>
      {said.length === 0 && <Empty>Nothing has happened yet.</Empty>}
      <div role="log">
        <ul class="words">
          {said.map((one) => <li key={one.text} class={one.isBad ? "wrong" : ""}><time>{clock(one.time)}</time><span>{one.text} <small>{one.remedy}</small></span></li>)}
        </ul>
      </div>
    </Card>
  );
}
