// What the machine says to a file before it starts: the lines of its command `check`.
export interface Finding { line: number; file?: string; stops: boolean; text: string; remedy: string }
export interface Preflight { findings: Finding[]; totals: string[] }

/** Where the bracket opens that the text ends with; there may be others in it. */
function lastBracket(text: string): number {
  let depth = 0;
  for (let at = text.length - 1; at >= 0; at--) {
    if (text[at] === ")") depth++;
    else if (text[at] === "(" && --depth === 0) return at;
  }
  return text.length;
}

/** `sub.ngc, line 12: stops: what it is (what to do)`; other lines are totals. */
export function readPreflight(lines: string[]): Preflight {
  const out: Preflight = { findings: [], totals: [] };
  for (const said of lines) {
    const [, file, line, kind, rest] = /^(?:(.+?), )?line (\d+): (stops|warning): (.*)$/.exec(said) ?? [];
    if (!rest) { out.totals.push(said); continue; }
    const at = lastBracket(rest);
    out.findings.push({ ...(file ? { file } : {}), line: Number(line), stops: kind === "stops", text: rest.slice(0, at).trim(), remedy: rest.slice(at + 1, -1) });
  }
  return out;
}
