// The machine's own words from the repository: its settings, their rows, and codes from their table.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { readIni, type Schema, settingsOf } from "../src/parts/settings";
// @ts-expect-error: plain JavaScript, as build.mjs is, which uses it too.
import { schema } from "../schema.mjs";

export function sampleConfig(web: string, isMill: boolean): string {
  return readFileSync(join(web, "../config/samples", isMill ? "cnc-mill.ini" : "cartesian.ini"), "utf8");
}

/** `config-set`: the changed file, or what is wrong in the words of the board. */
export function configSet(web: string, file: string, line: string): { file: string } | { wrong: string } {
  const [, check, section = "", key = "", value = ""] = /^config-set (--check )?"([^"]*)" (\S+?)(?: = (.*))?$/.exec(line) ?? [];
  const dot = key.indexOf(".");
  const rows = settingsOf(schema(web) as Schema, readIni(file), dot > 0 ? [`${section}/${key.slice(0, dot)}`] : []);
  const row = rows.find((one) => one.section === section && one.key === key);
  if (!row) return { wrong: `[${section}] has no setting '${key}'` };
  const number = Number(value);
  if (value && ["number", "integer"].includes(row.type)) {
    if (Number.isNaN(number)) return { wrong: `${key}: '${value}' is not a number (write a number)` };
    if (number < (row.min ?? -1e30) || number > (row.max ?? 1e30)) return { wrong: `${key}: ${value} is outside its range (use ${row.min} to ${row.max})` };
  }
  if (check) return { file };
  const lines = file.split("\n");
  const head = lines.findIndex((one) => one.startsWith(`[${section}]`));
  const end = lines.findIndex((one, at) => at > head && one.startsWith("["));
  const at = lines.findIndex((one, place) => place > head && (end < 0 || place < end) && one.split("=")[0]!.trim() === key);
  const text = value ? [`${key} = ${value}`] : [];
  if (head < 0) lines.push(`[${section}]`, ...text);
  else lines.splice(at < 0 ? head + 1 : at, at < 0 ? 0 : 1, ...text);
  return { file: lines.join("\n") };
}

export function readCodes(web: string): Record<string, string> {
  const out: Record<string, string> = {};
  for (const line of readFileSync(join(web, "../docs/commands.md"), "utf8").split("\n")) {
    const cells = line.split("|").map((cell) => cell.trim());
    const name = cells[1]?.replaceAll("`", "");
    if (!name || !/^[GMT]\d+(\.\d+)?$/.test(name)) continue;
    const help = cells.find((cell, index) => index > 1 && cell.length > 3);
    if (help) out[name] = help.split("<br>")[0]!.replaceAll(/[`*\\]/g, "");
  }
  return out;
}
