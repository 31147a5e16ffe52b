// Bundles and runs the page's tests with node's own runner; `shots FOLDER [NAME]` makes pictures instead,
// `pictures FOLDER` those of docs/page.md, `figures` its figures.
import { spawnSync } from "node:child_process";
import { dirname } from "node:path";
import { fileURLToPath } from "node:url";
import { bundle } from "../mock/run.mjs";

const WEB = dirname(dirname(fileURLToPath(import.meta.url)));
process.env.VELVET_WEB = WEB;
if (process.argv[2] === "shots") {
  const { shots } = await import(await bundle("tests/shots.ts", "shots"));
  await shots(process.argv[3] ?? "../out/page", process.argv[4] ?? "");
} else if (process.argv[2] === "pictures") {
  const { pictures } = await import(await bundle("tests/docs-shots.ts", "pictures"));
  await pictures(process.argv[3] ?? "../out/page", process.argv[4] ?? "");
} else if (process.argv[2] === "figures") {
  const { figures } = await import(await bundle("tests/figures.ts", "figures"));
  await figures();
} else {
  const files = [await bundle("tests/unit.test.ts", "unit.test"), await bundle("tests/page.test.ts", "page.test")];
  const more = process.argv.slice(2).map((name) => `--test-name-pattern=${name}`);
  const done = spawnSync(process.execPath, ["--test", "--test-reporter=spec", "--test-concurrency=1", ...more, ...files], { stdio: "inherit", cwd: WEB });
  process.exit(done.status ?? 1);
}
