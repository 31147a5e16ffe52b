// Changes of settings: checked and stored by the machine, with its command `config-set`.
import { inquire } from "../api/inquire";

/** What is wrong with a setting, by its section and key. */
export type Findings = Record<string, string>;
export type Changes = Record<string, string | null>;

/** The line that changes a setting, or only has the change checked. */
function line(name: string, value: string | null, isCheck: boolean): string {
  const at = name.indexOf("/");
  return `config-set ${isCheck ? "--check " : ""}"${name.slice(0, at)}" ${name.slice(at + 1)}${value === null ? "" : ` = ${value}`}`;
}

/** Has the machine say what is wrong with a change, in its own words. */
async function carryOut(name: string, value: string | null, isCheck: boolean): Promise<string | undefined> {
  if (value?.includes("\n")) return "a value is one line";
  try {
    const said = await inquire(line(name, value, isCheck));
    return said.find((text) => text.startsWith("error:"))?.slice(6);
  } catch (error) {
    return (error as Error).message;
  }
}

export async function check(changes: Changes): Promise<Findings> {
  const out: Findings = {};
  for (const [name, value] of Object.entries(changes)) {
    const wrong = await carryOut(name, value, true);
    if (wrong) out[name] = wrong;
  }
  return out;
}

/** Stores changes, none of them when one is wrong. */
export async function store(changes: Changes): Promise<Findings> {
  const wrong = await check(changes);
  if (Object.keys(wrong).length) return wrong;
  for (const [name, value] of Object.entries(changes)) {
    const why = await carryOut(name, value, false);
    if (why) return { [name]: why };
  }
  return {};
}
