// Bundles src/ into dist/: shell and style (first paint), more and views (loaded after it), an icon and the schema of settings, each
// compressed and with its hash in its name; index.html by name. The same sources give the same bytes: `node check.mjs` holds dist/ to that.
import { createHash } from "node:crypto";
import { mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { dirname, join, relative, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";
import { gzip } from "pako";
import { schema } from "./schema.mjs";

const ROOT = dirname(fileURLToPath(import.meta.url));
const SRC = join(ROOT, "src");
const COMMON = {
  absWorkingDir: ROOT, bundle: true, minify: true, format: "esm", target: ["es2022"], charset: "utf8", write: false,
  legalComments: "none", metafile: true, jsx: "automatic", jsxImportSource: "preact", logLevel: "warning",
};

/** What the shell carries and the second file takes from it. */
const SHARED = new Set(["preact", "preact/hooks", "preact/jsx-runtime", "@preact/signals"]);

function hashed(name, ending, bytes) {
  return `${name}-${createHash("sha256").update(bytes).digest("hex").slice(0, 10)}.${ending}`;
}

async function shell() {
  const made = await build({ ...COMMON, entryPoints: ["src/shell.tsx"] });
  const output = Object.values(made.metafile.outputs)[0];
  return { bytes: Buffer.from(made.outputFiles[0].contents), inputs: new Set(Object.keys(made.metafile.inputs)), exports: new Set(output.exports) };
}

/** The second file: modules that the shell has already are imported from it, not carried twice. */
async function more(of) {
  const plugin = {
    name: "from-the-shell",
    setup(builder) {
      builder.onResolve({ filter: /.*/ }, (args) => {
        if (SHARED.has(args.path)) return { path: `./${of.name}`, external: true };
        if (!args.path.startsWith(".") || !args.resolveDir.startsWith(SRC)) return undefined;
        const base = relative(ROOT, resolve(args.resolveDir, args.path));
        const found = ["ts", "tsx"].some((ending) => of.inputs.has(`${base}.${ending}`));
        return found ? { path: `./${of.name}`, external: true } : undefined;
      });
    },
  };
  const made = await build({ ...COMMON, entryPoints: ["src/more.tsx"], plugins: [plugin] });
  const text = made.outputFiles[0].text;
  for (const [, names] of text.matchAll(/import\s*\{([^}]*)\}\s*from\s*"\.\/shell-/g)) {
    for (const one of names.split(",").map((word) => word.trim().split(/\s+as\s+/)[0])) {
      if (one && !of.exports.has(one)) throw new Error(`src/kit.ts does not export ${one}, which src/more.tsx takes from the shell`);
    }
  }
  return Buffer.from(made.outputFiles[0].contents);
}

async function style(entry) {
  const made = await build({ ...COMMON, entryPoints: [entry] });
  return Buffer.from(made.outputFiles[0].contents);
}

export async function make() {
  const first = await shell();
  first.name = hashed("shell", "js", first.bytes);
  const second = await more(first);
  const css = await style("src/style/page.css");
  const views = await style("src/style/later.css");
  const icon = readFileSync(join(SRC, "icon.svg"));
  const settings = Buffer.from(JSON.stringify(schema(ROOT)));
  const names = {
    shell: first.name, more: hashed("more", "js", second), style: hashed("style", "css", css), views: hashed("views", "css", views), icon: hashed("icon", "svg", icon),
    settings: hashed("settings", "json", settings),
  };
  const html = readFileSync(join(SRC, "index.html"), "utf8").replace(/\{(\w+)\}/g, (_, what) => names[what]);
  const files = new Map([
    ["index.html", Buffer.from(html)], [names.style, css], [names.shell, first.bytes], [names.more, second], [names.views, views], [names.icon, icon], [names.settings, settings],
  ]);
  const out = new Map();
  for (const [name, bytes] of files) out.set(`${name}.gz`, Buffer.from(gzip(bytes, { level: 9 })));
  out.set("assets.rs", Buffer.from(table(files)));
  return out;
}

const KINDS = { html: "text/html; charset=utf-8", js: "text/javascript; charset=utf-8", css: "text/css; charset=utf-8", svg: "image/svg+xml", json: "application/json" };

/** An expression for `include!`: path, type and compressed bytes of each file. */
function table(files) {
  const rows = [...files.keys()].map((name) => `    ("/${name}", "${KINDS[name.split(".").pop()]}", include_bytes!("${name}.gz")),\n`);
  return `// Made by web/build.mjs: path, content type, bytes (gzip). All but index.html have their hash in their name.\n&[\n${rows.join("")}]\n`;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const out = await make();
  const dist = join(ROOT, "dist");
  mkdirSync(dist, { recursive: true });
  for (const old of readdirSync(dist)) if (!out.has(old)) rmSync(join(dist, old));
  for (const [name, bytes] of out) writeFileSync(join(dist, name), bytes);
  for (const [name, bytes] of out) console.log(`${String(bytes.length).padStart(7)} ${name}`);
}
