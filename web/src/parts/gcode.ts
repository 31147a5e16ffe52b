// Reads G-code into points for a picture: moves and arcs of the plane XY, no more. What the machine itself would do with
// a file says the preflight; this only draws.

export interface Reader { read: (line: string) => void; take: () => number[][] }
const ARC_STEP = 0.25;

/** Points along an arc about the centre that I and J give, its end included. */
function arc(at: number[], to: number[], offset: [number, number], clockwise: boolean, kind: number): number[][] {
  const [x = 0, y = 0, z = 0] = at;
  const [cx, cy] = [x + offset[0], y + offset[1]];
  const radius = Math.hypot(x - cx, y - cy);
  const from = Math.atan2(y - cy, x - cx);
  let sweep = Math.atan2(to[1]! - cy, to[0]! - cx) - from;
  if (clockwise && sweep >= -1e-9) sweep -= 2 * Math.PI;
  if (!clockwise && sweep <= 1e-9) sweep += 2 * Math.PI;
  const steps = Math.max(1, Math.ceil(Math.abs(sweep) / ARC_STEP));
  const out: number[][] = [];
  for (let step = 1; step < steps; step++) {
    const angle = from + sweep * step / steps;
    out.push([cx + radius * Math.cos(angle), cy + radius * Math.sin(angle), z + (to[2]! - z) * step / steps, kind]);
  }
  return [...out, [...to, kind]];
}

export function pathReader(isPrinter: boolean): Reader {
  const at = [0, 0, 0];
  let e = 0;
  let isRelative = false;
  let isRelativeE = false;
  let scale = 1;
  let motion = 0;
  let points: number[][] = [];

  function move(words: Map<string, number>): void {
    const to = "XYZ".split("").map((word, axis) => {
      const value = words.get(word);
      return value === undefined ? at[axis]! : isRelative ? at[axis]! + value * scale : value * scale;
    });
    const wanted = words.get("E");
    const pushes = wanted !== undefined && (isRelativeE ? wanted > 0 : wanted > e);
    if (wanted !== undefined && !isRelativeE) e = wanted;
    const kind = isPrinter ? Number(pushes) : Number(motion > 0);
    if (motion > 1 && (words.has("I") || words.has("J"))) points.push(...arc(at, to, [(words.get("I") ?? 0) * scale, (words.get("J") ?? 0) * scale], motion === 2, kind));
    else if (to.some((value, axis) => value !== at[axis])) points.push([...to, kind]);
    to.forEach((value, axis) => { at[axis] = value; });
  }

  return {
    read(line) {
      const plain = line.replace(/;.*|\([^)]*\)/g, "").toUpperCase();
      const words = new Map<string, number>();
      for (const [, word, value] of plain.matchAll(/([A-Z])\s*([-+]?\d*\.?\d+)/g)) {
        if (word !== "G" && word !== "M") { words.set(word!, Number(value)); continue; }
        const code = `${word}${Number(value)}`;
        if (/^G[0-3]$/.test(code)) motion = Number(value);
        else if (code === "G90") isRelative = false;
        else if (code === "G91") isRelative = true;
        else if (code === "M82") isRelativeE = false;
        else if (code === "M83") isRelativeE = true;
        else if (code === "G20") scale = 25.4;
        else if (code === "G21") scale = 1;
        else if (code === "G92") { if (/E/.test(plain)) e = Number(/E\s*([-+]?[\d.]+)/.exec(plain)?.[1] ?? 0); return; }
        else if (word === "G" && code !== "G17" && code !== "G54") return;
        else if (word === "M") return;
      }
      if (words.has("X") || words.has("Y") || words.has("Z") || words.has("E")) move(words);
    },
    take() {
      const out = points;
      points = [];
      return out;
    },
  };
}

/** Reads a file of the card as it comes, and gives its points piece by piece. */
export async function readFile(path: string, isPrinter: boolean, signal: AbortSignal, onPoints: (points: number[][]) => void): Promise<void> {
  const answer = await fetch(`/server/files/gcodes/${path.split("/").map(encodeURIComponent).join("/")}`, { signal });
  if (!answer.ok || !answer.body) throw new Error("The file cannot be read.");
  const reader = answer.body.getReader();
  const decoder = new TextDecoder();
  const lines = pathReader(isPrinter);
  let rest = "";
  for (;;) {
    const { done, value } = await reader.read();
    rest += done ? "" : decoder.decode(value, { stream: true });
    const all = rest.split("\n");
    rest = done ? "" : all.pop() ?? "";
    for (const line of all) lines.read(line);
    onPoints(lines.take());
    if (done) return;
  }
}
