// What must hold before a change of the page is taken: dist/ is what the sources give, it fits its budget, nothing in it
// breaks the content security policy, lints and types are clean, and the tests pass where there is a browser.
import { spawnSync } from "node:child_process";
import { existsSync, readdirSync, readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { ungzip } from "pako";
import { make } from "./build.mjs";

const WEB = dirname(fileURLToPath(import.meta.url));
const BUDGET = 105_000;
const FIRST_PAINT = 25_000;
const failures = [];
const fail = (text) => { failures.push(text); console.error(`page: ${text}`); };

function run(what, command, args) {
  const done = spawnSync(command, args, { cwd: WEB, stdio: ["ignore", "inherit", "inherit"] });
  if (done.status !== 0) fail(`${what} failed`);
}

const made = await make();
const dist = join(WEB, "dist");
const there = existsSync(dist) ? readdirSync(dist).sort() : [];
if (there.join() !== [...made.keys()].sort().join()) fail(`dist/ has other files than the sources give (npm run build): ${there.join(", ")}`);
else for (const [name, bytes] of made) if (!bytes.equals(readFileSync(join(dist, name)))) fail(`dist/${name} is not what the sources give (npm run build)`);

const files = [...made].filter(([name]) => name.endsWith(".gz"));
const whole = files.reduce((sum, [, bytes]) => sum + bytes.length, 0);
const first = files.filter(([name]) => /^(index|style|shell)/.test(name)).reduce((sum, [, bytes]) => sum + bytes.length, 0);
if (whole > BUDGET) fail(`${whole} bytes are more than ${BUDGET}`);
if (first > FIRST_PAINT) fail(`${first} bytes for the first picture are more than ${FIRST_PAINT}`);
for (const [name, bytes] of files) {
  const text = new TextDecoder().decode(ungzip(bytes));
  for (const word of ["eval(", "new Function", "insertAdjacentHTML", "document.write"]) if (text.includes(word)) fail(`${name} holds ${word}`);
  if (name.startsWith("index") && /<style|\sstyle=|<script(?![^>]*src=)/.test(text)) fail("index.html holds something inline");
}
for (const name of readdirSync(join(WEB, "src"), { recursive: true })) {
  if (/\.tsx?$/.test(name) && /innerHTML|dangerouslySet|outerHTML/i.test(readFileSync(join(WEB, "src", name), "utf8"))) fail(`src/${name} makes elements from text`);
}
run("biome", "npx", ["--no-install", "biome", "lint", "--error-on-warnings", "."]);
run("tsc", "npx", ["--no-install", "tsc", "--noEmit"]);
if (process.argv.includes("--quick")) console.log("page: the tests in a browser are left out");
else if ([process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].some((path) => path && existsSync(path))) run("tests", process.execPath, ["tests/run.mjs"]);
else console.log("page: there is no Chromium: the tests in a browser are left out");
console.log(`page: ${whole} of ${BUDGET} bytes, ${first} of ${FIRST_PAINT} for the first picture`);
process.exit(failures.length ? 1 : 0);
