// Settings: what there are, by the schema that the page carries, with the values that stand in config.ini.
type Row = [string | string[], string | null, string, (string | null)?, (number | null)?, (number | null)?];
type Rows = Record<string, Row>;
export interface Schema { [section: string]: { all?: Rows; common?: Rows; each?: Rows; free?: Row } }
/** Values as they stand in the file, by section and key. */
export type Written = Map<string, Map<string, string>>;

export interface Setting {
  section: string;
  key: string;
  type: string;
  value: string;
  default: string | null;
  /** Written in the configuration, not only the default. */
  isSet: boolean;
  help: string;
  unit?: string;
  min?: number;
  max?: number;
  choices?: string[];
}
export const nameOf = (one: { section: string; key: string }) => `${one.section}/${one.key}`;

/** `[section]`, `key = value # comment`; the last of several lines counts. */
export function readIni(text: string): Written {
  const out: Written = new Map();
  let keys = new Map<string, string>();
  for (const raw of text.split(/\r?\n/)) {
    const line = raw.replace(/#.*/, "").trim();
    const head = /^\[([^\]]*)\]/.exec(line);
    if (head) {
      keys = out.get(head[1]!) ?? new Map();
      out.set(head[1]!, keys);
    } else if (line.includes("=")) keys.set(line.slice(0, line.indexOf("=")).trim(), line.slice(line.indexOf("=") + 1).trim());
  }
  return out;
}

function setting(section: string, key: string, row: Row, written: Map<string, string> | undefined): Setting {
  const [type, first, help, unit, min, max] = row;
  const value = written?.get(key);
  return {
    section, key, type: Array.isArray(type) ? "choice" : type, default: first, value: value ?? first ?? "", isSet: value !== undefined, help,
    ...(unit ? { unit } : {}), ...(typeof min === "number" ? { min } : {}), ...(typeof max === "number" ? { max } : {}), ...(Array.isArray(type) ? { choices: type } : {}),
  };
}

/** All settings: of sections with names of the user's own, those of the names that are written, and of `added` (`section/name`). */
export function settingsOf(schema: Schema, written: Written, added: string[]): Setting[] {
  const out: Setting[] = [];
  for (const [section, { all, common, each, free }] of Object.entries(schema)) {
    const keys = written.get(section);
    const put = (rows: Rows, before: string) => { for (const [key, row] of Object.entries(rows)) out.push(setting(section, before + key, row, keys)); };
    if (all) put(all, "");
    if (common) put(common, "common.");
    const names = [...(keys?.keys() ?? [])];
    if (each) {
      const own = names.filter((key) => key.includes(".")).map((key) => key.slice(0, key.indexOf("."))).filter((name) => name !== "common");
      const more = added.filter((name) => name.startsWith(`${section}/`)).map((name) => name.slice(section.length + 1));
      for (const name of new Set([...own, ...more])) put(each, `${name}.`);
    }
    if (free) for (const key of names) out.push(setting(section, key, free, keys));
  }
  return out;
}
