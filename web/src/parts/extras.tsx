// Buttons of the user's own, and what the machine has said last.
import { useSignal } from "@preact/signals";
import type { Macro } from "../api/types";
import { Button, Card, Dialog, Empty } from "../shell/parts";
import { clock } from "../shell/format";
import { consoleLines, isBad } from "../state/history";
import { isLive, mode, obj } from "../state/machine";
import { script } from "../state/notices";
import { mayOperate } from "../state/session";

export function Macros() {
  const asked = useSignal<Macro | null>(null);
  const macros = obj("velvet")?.macros ?? [];
  const groups = [...new Set(macros.map((one) => one.group))];
  const may = mayOperate.value && isLive.value && mode.value !== "Alarm";
  if (!macros.length) return null;
  const press = (one: Macro) => {
    if (!one.confirm) return script(one.script);
    asked.value = one;
    return undefined;
  };
  return (
    <Card title="Buttons">
      <div class="macros">
        {groups.map((group) => (
          <div key={group} role="group" aria-label={group}>
            <h3>{group}</h3>
            <div class="row wrap">
              {macros.filter((one) => one.group === group).map((one) => <Button key={one.name} disabled={!may} title={one.script} onPress={() => press(one)}>{one.label}</Button>)}
            </div>
          </div>
        ))}
      </div>
      {asked.value && (
        <Dialog title={`${asked.value.label}?`} onClose={() => { asked.value = null; }}>
          <pre class="code">{asked.value.script}</pre>
          <div class="row end">
            <Button onPress={() => { asked.value = null; }}>No</Button>
            <Button kind="main" onPress={async () => { const one = asked.peek(); asked.value = null; if (one) await script(one.script); }}>{asked.value.label}</Button>
          </div>
        </Dialog>
      )}
    </Card>
  );
}

interface Word { time: number; isBad: boolean; text: string }

/** What the machine counts as a message, or else the last lines that were more than an answer. */
function lastWords(): Word[] {
  const messages = obj("velvet")?.messages ?? [];
  if (messages.length) return messages.map((one) => ({ time: one.time, isBad: one.level === "error", text: one.text }));
  return consoleLines.value.filter((line) => line.type === "response" && !/^ok\b/.test(line.message))
    .map((line) => ({ time: line.time, isBad: isBad(line.message), text: line.message.replace(/^(!!|\/\/|error:) ?/, "") }));
}

export function LastWords() {
  const said = lastWords().slice(-5).reverse();
  return (
    <Card title="Messages" aside={<a class="more" href="#/console">Console</a>}>
      {said.length === 0 && <Empty>Nothing has happened yet.</Empty>}
      <ul class="words">
        {said.map((one, at) => <li key={`${one.time}${at}`} class={one.isBad ? "wrong" : ""}><time>{clock(one.time)}</time><span>{one.text}</span></li>)}
      </ul>
    </Card>
  );
}
