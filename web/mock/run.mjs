// Starts the mock board: node mock/run.mjs [--port 8080] [--mill] [--login | --watch | --first] [--speed 1]
import { mkdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const WEB = dirname(dirname(fileURLToPath(import.meta.url)));

export async function bundle(entry, name) {
  const outfile = join(WEB, ".build", `${name}.mjs`);
  mkdirSync(dirname(outfile), { recursive: true });
  await build({
    absWorkingDir: WEB, entryPoints: [entry], outfile, bundle: true, platform: "node", format: "esm", target: "node20",
    external: ["ws", "playwright-core", "axe-core"], logLevel: "warning", sourcemap: "inline",
  });
  return outfile;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const { serve } = await import(await bundle("mock/main.ts", "mock"));
  const given = (name) => process.argv.includes(`--${name}`);
  const value = (name, or) => (given(name) ? Number(process.argv[process.argv.indexOf(`--${name}`) + 1]) : or);
  const board = await serve({
    web: WEB, port: value("port", 8080), kind: given("mill") ? "mill" : "printer",
    entry: given("first") ? "first" : given("login") ? "login" : given("watch") ? "watch" : "open", speed: value("speed", 1),
  });
  console.log(`http://127.0.0.1:${board.port}/`);
}
