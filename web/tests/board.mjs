// The page's tests on the unmodified image: starts the virtual board, and runs tests/board.test.ts in a browser against it.
// node tests/board.mjs VIRTUAL-PRIME IMAGE FOLDER [--quick] [NAME]: pictures go to the folder, and so does what the board said.
import { spawn } from "node:child_process";
import { createWriteStream, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { bundle } from "../mock/run.mjs";

const WEB = dirname(dirname(fileURLToPath(import.meta.url)));
const [emulator, image, folder, ...more] = process.argv.slice(2);
const out = resolve(folder);
mkdirSync(out, { recursive: true });

const PASSWORD = "velvet-test";
const NETWORK = "\n[network]\nenable = true\nwebserver_enable = true\npassword_required = false\n";

/** Starts a board with one of the samples' configurations, and a password where it has an owner. Gives its address, and how to end it. */
function start(sample, isOwned) {
  const config = join(out, `${sample}.ini`);
  writeFileSync(config, readFileSync(join(WEB, "../config/samples", `${sample}.ini`), "utf8") + NETWORK);
  const board = spawn(emulator, ["console", "--elf", image, "--config", config, "--net", "--web-port", "80"], { stdio: ["pipe", "pipe", "pipe"] });
  const log = createWriteStream(join(out, `${sample}.log`));
  board.stderr.pipe(log);
  return new Promise((done, failed) => {
    let said = "";
    let isSet = false;
    const hear = (bytes) => {
      said += bytes;
      log.write(bytes);
      const url = /http:\/\/[\d.:]+\//.exec(said)?.[0];
      if (!url) return;
      if (!isOwned) { done({ url, end: () => board.stdin.end() }); return; }
      // The password is set where only who stands at the machine can.
      if (!isSet && /Welcome/.test(said)) { isSet = true; board.stdin.write(`password ${PASSWORD}\n`); }
      if (/ask for this password/.test(said)) done({ url, end: () => board.stdin.end() });
    };
    board.stdout.on("data", hear);
    board.stderr.on("data", hear);
    board.on("exit", (code) => failed(new Error(`the virtual board ended with ${code}: ${said}`)));
  });
}

const isQuick = more.includes("--quick");
const name = more.find((word) => !word.startsWith("--"));
const boards = [await start("cartesian", true), ...(isQuick ? [] : [await start("cnc-mill", false)])];
const tests = await bundle("tests/board.test.ts", "board.test");
const wanted = name ?? (isQuick ? "^quick:" : undefined);
const run = spawn(process.execPath, ["--test", "--test-reporter=spec", "--test-concurrency=1", ...(wanted ? [`--test-name-pattern=${wanted}`] : []), tests], {
  stdio: "inherit", cwd: WEB, env: { ...process.env, VELVET_WEB: WEB, VELVET_URL: boards[0].url, VELVET_MILL_URL: boards[1]?.url ?? "", VELVET_PICTURES: out, VELVET_PASSWORD: PASSWORD },
});
run.on("exit", (code) => {
  for (const board of boards) board.end();
  process.exitCode = code ?? 1;
  setTimeout(() => process.exit(code ?? 1), 5000).unref();
});
