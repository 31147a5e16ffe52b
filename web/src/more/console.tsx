// The console: lines and answers, with history, and completion from the board's own table of codes.
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { call } from "../api/link";
import { Button, Card } from "../shell/parts";
import { clock } from "../shell/format";
import { addLine, codes, consoleLines, isBad } from "../state/history";
import { kept } from "../state/prefs";
import { isLive } from "../state/machine";
import { mayOperate } from "../state/session";

const typedBefore = kept<string[]>("console.history", []);
const hidesAnswers = kept<boolean>("console.quiet", true);

async function send(text: string): Promise<void> {
  addLine({ message: text, time: Date.now() / 1000, type: "command" });
  typedBefore.value = [...typedBefore.peek().filter((one) => one !== text), text].slice(-100);
  if (/^M112\b/i.test(text.trim())) { await call("printer.emergency_stop", {}).catch(() => undefined); return; }
  try {
    await call("printer.gcode.script", { script: text });
  } catch (error) {
    const message = (error as Error).message;
    const isSaid = consoleLines.peek().slice(-4).some((line) => line.message.includes(message));
    if (!isSaid) addLine({ message: `!! ${message}`, time: Date.now() / 1000, type: "response" });
  }
}

function matches(text: string): [string, string][] {
  const word = text.trimStart().split("\n").pop()?.toUpperCase() ?? "";
  if (word.length < 1) return [];
  const isCode = /^[GMT]\d*(\.\d*)?$/.test(word);
  const found = codes.value.filter(([name, help]) => (isCode ? name.startsWith(word) : !/\s/.test(word) && word.length > 2 && (name.startsWith(word) || help.toUpperCase().includes(word))));
  const exact = codes.value.filter(([name]) => name === word.split(/\s/)[0]);
  return (isCode || found.length ? found : exact).sort((a, b) => a[0].length - b[0].length || a[0].localeCompare(b[0], undefined, { numeric: true })).slice(0, 7);
}

function Lines() {
  const box = useRef<HTMLDivElement>(null);
  const lines = consoleLines.value.filter((line) => !hidesAnswers.value || line.message !== "ok");
  const last = lines.at(-1);
  useEffect(() => { box.current?.scrollTo(0, box.current.scrollHeight); }, [last]);
  return (
    <div class="lines" ref={box} role="log" aria-label="Lines and answers" tabIndex={0}>
      {lines.map((line, at) => (
        <div key={at} class={`line ${line.type} ${isBad(line.message) ? "bad" : line.message.startsWith("//") ? "info" : ""}`}>
          <time>{clock(line.time)}</time><span>{line.message}</span>
        </div>
      ))}
    </div>
  );
}

function Offers({ offered, chosen, take }: { offered: [string, string][]; chosen: number; take: (name: string) => void }) {
  if (!offered.length) return null;
  return (
    <div class="offers" id="offers" role="listbox" aria-label="Codes">
      {offered.map(([name, help], at) => (
        // biome-ignore lint/a11y/useKeyWithClickEvents: the field beside it has the keys.
        <div key={name} class="offer" id={`offer${at}`} role="option" tabIndex={-1} aria-selected={at === chosen} onClick={() => take(name)}><b>{name}</b><span>{help}</span></div>
      ))}
    </div>
  );
}

function Prompt() {
  const text = useSignal("");
  const chosen = useSignal(-1);
  const back = useSignal(0);
  const field = useRef<HTMLTextAreaElement>(null);
  const offered = matches(text.value);
  const take = (name: string) => { text.value = `${name} `; chosen.value = -1; field.current?.focus(); };
  const submit = () => {
    const line = text.peek().trim();
    if (!line) return;
    text.value = "";
    back.value = 0;
    chosen.value = -1;
    void send(line);
  };
  const recall = (by: number) => {
    back.value = Math.min(typedBefore.value.length, Math.max(0, back.value + by));
    text.value = back.value ? typedBefore.value[typedBefore.value.length - back.value] ?? "" : "";
  };
  const onKey = (event: KeyboardEvent) => {
    const picked = offered[chosen.value];
    const isOneLine = !text.value.includes("\n");
    if (event.key === "Enter" && !event.shiftKey) { if (picked) take(picked[0]); else submit(); }
    else if (event.key === "Tab" && offered[0] && text.value.trim() !== offered[Math.max(0, chosen.value)]?.[0]) take((picked ?? offered[0])[0]);
    else if (event.key === "ArrowUp" && isOneLine) { if (chosen.value >= 0) chosen.value -= 1; else recall(1); }
    else if (event.key === "ArrowDown" && isOneLine) { if (offered.length && !back.value) chosen.value = Math.min(offered.length - 1, chosen.value + 1); else recall(-1); }
    else if (event.key === "Escape") { chosen.value = -1; text.value = ""; }
    else return;
    event.preventDefault();
  };
  return (
    <div class="prompt">
      <Offers offered={offered} chosen={chosen.value} take={take} />
      <textarea
        ref={field} data-slash rows={Math.min(6, text.value.split("\n").length)} value={text.value} placeholder="G-code or a command" aria-label="Line to send" spellcheck={false} autocapitalize="characters"
        aria-controls={offered.length ? "offers" : undefined} aria-autocomplete="list" aria-activedescendant={chosen.value >= 0 ? `offer${chosen.value}` : undefined}
        disabled={!mayOperate.value} onInput={(event) => { text.value = event.currentTarget.value; chosen.value = -1; back.value = 0; }} onKeyDown={onKey}
      />
      <Button kind="main" disabled={!mayOperate.value || !isLive.value} onPress={submit}>Send</Button>
    </div>
  );
}

export function ConsoleView() {
  return (
    <>
      <h1 class="unseen">Console</h1>
      <Card class="console" title="Console" aside={<label class="check quiet"><input type="checkbox" checked={hidesAnswers.value} onChange={(event) => { hidesAnswers.value = event.currentTarget.checked; }} />Hide plain ok</label>}>
        <Lines />
        <Prompt />
        <p class="note">Up and down: lines from before. Tab: complete. Shift and Enter: one more line.</p>
      </Card>
    </>
  );
}
