// Settings from the schema that is in the repository, and codes from its table: the mock has the board's own words.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import type { Changes, Setting, SettingFinding } from "../src/api/types";

interface Property {
  type?: string; description?: string; default?: unknown; minimum?: number; maximum?: number; enum?: string[]; pattern?: string; "x-unit"?: string;
}
interface Section { properties?: Record<string, Property & Section>; patternProperties?: Record<string, { properties?: Record<string, Property> }> }

const INSTANCES: Record<string, string[]> = { actuator: ["alpha", "beta", "gamma", "delta"], "temperature control": ["hotend", "bed", "chamber"], extruder: ["hotend"], fan: ["fan"], switch: ["fan"] };
const WRITTEN: Record<string, string> = {
  "actuator/alpha.steps_per_mm": "80", "actuator/beta.steps_per_mm": "80", "actuator/gamma.steps_per_mm": "400", "network/enable": "true", "network/hostname": "velvet",
  "temperature control/hotend.max_temp": "300", "temperature control/hotend.p_factor": "21.4", "motion control/default_feed_rate": "3000",
};

function setting(section: string, key: string, one: Property): Setting {
  const isPin = one.pattern?.includes("A-Ka-k") ?? false;
  const type = one.enum ? "choice" : one.type === "boolean" ? "boolean" : one.type === "integer" ? "integer" : one.type === "number" ? "number" : isPin ? "pin" : "text";
  const first = one.default === undefined ? null : String(one.default);
  const written = WRITTEN[`${section}/${key}`];
  return {
    section, key, type, default: first, value: written ?? first ?? "", is_set: written !== undefined, help: one.description ?? "", acts: "restart",
    ...(one["x-unit"] ? { unit: one["x-unit"] } : {}), ...(one.enum ? { choices: one.enum } : {}),
    ...(one.minimum !== undefined ? { min: one.minimum } : {}), ...(one.maximum !== undefined ? { max: one.maximum } : {}),
  };
}

export function readSettings(web: string): Setting[] {
  const schema = JSON.parse(readFileSync(join(web, "../docs/config.schema.json"), "utf8")) as { properties: Record<string, Section> };
  const out: Setting[] = [];
  for (const [section, body] of Object.entries(schema.properties)) {
    for (const [key, one] of Object.entries(body.properties ?? {})) {
      if (one.properties) for (const [inner, leaf] of Object.entries(one.properties)) out.push(setting(section, `${key}.${inner}`, leaf));
      else out.push(setting(section, key, one));
    }
    const pattern = Object.values(body.patternProperties ?? {})[0];
    for (const name of INSTANCES[section] ?? []) {
      for (const [key, one] of Object.entries(pattern?.properties ?? {})) out.push(setting(section, `${name}.${key}`, one));
    }
  }
  return out;
}

/** Findings of a change, in the words of `velvet check`. */
export function check(all: Setting[], changes: Changes): SettingFinding[] {
  const out: SettingFinding[] = [];
  for (const [name, value] of Object.entries(changes)) {
    const found = all.find((one) => `${one.section}/${one.key}` === name);
    if (!found) out.push({ key: name, level: "error", text: `there is no setting ${name}` });
    else if (value !== null && (found.type === "number" || found.type === "integer")) {
      const number = Number(value);
      if (!Number.isFinite(number) || value.trim() === "") out.push({ key: name, level: "error", text: `${found.key} = ${value} is no number` });
      else if (number < (found.min ?? -1e30) || number > (found.max ?? 1e30)) out.push({ key: name, level: "error", text: `${found.key} = ${value} is not within ${found.min} to ${found.max}` });
      else if (found.key.endsWith("max_temp") && number > 285) out.push({ key: name, level: "warning", text: `${found.key} = ${value}: hot ends with PTFE in them stand 240 C` });
    }
  }
  return out;
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
