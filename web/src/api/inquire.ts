// Questions to the machine in its own commands. What it says comes to this page alone, line by line.
import { call, on } from "./link";

let last: Promise<unknown> = Promise.resolve();

/** Sends a line, and gives all that the machine says to it. One at a time, as answers do not say what they answer. */
export function inquire(line: string, heard?: (text: string) => void): Promise<string[]> {
  const mine = last.then(async () => {
    const lines: string[] = [];
    const off = on("notify_velvet_answer", (text) => { lines.push(text); heard?.(text); });
    try {
      await call("velvet.ask", { script: line });
    } finally {
      off();
    }
    return lines;
  });
  last = mine.catch(() => undefined);
  return mine;
}
