// The settings that there are, for the page: docs/config.schema.json without what only other tools want. The page reads values out of
// config.ini, and carries help, defaults and ranges itself, as the board's image has no room for them twice.
import { readFileSync } from "node:fs";
import { join } from "node:path";

/** Greatest number that says something about a setting; those beyond stand for "any". */
const ANY = 1e8;

/** [type or choices, default or null, help, unit, least, greatest], without what is missing at the end. */
function row(one) {
  const isPin = one.pattern?.includes("A-Ka-k");
  const type = one.enum ?? (isPin ? "pin" : { boolean: "boolean", integer: "integer", number: "number" }[one.type] ?? "text");
  const bound = (value) => (value === undefined || Math.abs(value) > ANY ? null : value);
  const all = [type, one.default === undefined ? null : String(one.default), one.description ?? "", one["x-unit"] ?? null, bound(one.minimum), bound(one.maximum)];
  while (all.length > 3 && all.at(-1) === null) all.pop();
  return all;
}

const rows = (properties) => Object.fromEntries(Object.entries(properties).map(([key, one]) => [key, row(one)]));

/**
 * Sections by name: `all`, rows of keys that stand alone; `common`, rows behind `common.`; `each`, rows behind any name of the user's own;
 * `free`, the one row of a section whose keys are names.
 */
export function schema(web) {
  const { properties } = JSON.parse(readFileSync(join(web, "../docs/config.schema.json"), "utf8"));
  return Object.fromEntries(Object.entries(properties).map(([name, body]) => {
    const plain = Object.entries(body.properties ?? {}).filter(([, one]) => !one.properties);
    const each = Object.values(body.patternProperties ?? {})[0];
    const out = {};
    if (plain.length) out.all = rows(Object.fromEntries(plain));
    if (body.properties?.common) out.common = rows(body.properties.common.properties);
    if (each) Object.assign(out, each.properties ? { each: rows(each.properties) } : { free: row(each) });
    return [name, out];
  }));
}
