// What needs no browser: the table of the API, reading G-code, figures as people read them.
import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { ROLES } from "../src/api/types";
import { pathReader } from "../src/parts/gcode";
import { Sha256 } from "../src/parts/sha256";
import { readPreflight } from "../src/parts/preflight";
import { readIni, type Schema, settingsOf } from "../src/parts/settings";
import { bytes, duration, num, plainName } from "../src/shell/format";

/** Methods with their roles, as the table of docs/api.md has them. */
function documented(): Record<string, string> {
  const out: Record<string, string> = {};
  const page = readFileSync(join(process.env.VELVET_WEB ?? ".", "../docs/api.md"), "utf8");
  const table = page.slice(page.indexOf("## Methods"), page.indexOf("### Login"));
  for (const row of table.split("\n").filter((line) => line.startsWith("| `"))) {
    const cells = row.split("|").map((cell) => cell.trim());
    let last = "";
    for (const [, name] of cells[1]!.matchAll(/`([^`]+)`/g)) {
      last = name!.startsWith(".") ? last.slice(0, last.lastIndexOf(".")) + name : name!;
      out[last] = cells[4]!;
    }
  }
  return out;
}

test("docs/api.md has every method of types.ts, with its role", () => {
  assert.deepEqual(documented(), { ...ROLES });
});

test("digests are SHA-256, in pieces of any size", () => {
  const bytes = Uint8Array.from({ length: 1000 }, (_, at) => at * 31 % 256);
  for (let size = 0; size <= 300; size++) {
    for (const piece of [1, 55, 64, 129, 1000]) {
      const hash = new Sha256();
      for (let at = 0; at < size; at += piece) hash.add(bytes.subarray(at, Math.min(size, at + piece)));
      assert.equal(hash.hex(), createHash("sha256").update(bytes.subarray(0, size)).digest("hex"), `${size} by ${piece}`);
    }
  }
});

function path(text: string, isPrinter = false): number[][] {
  const reader = pathReader(isPrinter);
  for (const line of text.split("\n")) reader.read(line);
  return reader.take().map((point) => point.map((value) => Number(value.toFixed(3))));
}

test("reads moves, relative and absolute, in mm and inch", () => {
  assert.deepEqual(path("G21 G90\nG0 X10 Y5\nG1 Z-1 F300 ; down\nG91\nX2\nG20\nG1 Y1"), [[10, 5, 0, 0], [10, 5, -1, 1], [12, 5, -1, 1], [12, 30.4, -1, 1]]);
});

test("knows which moves lay material", () => {
  assert.deepEqual(path("M83\nG1 X1 E1\nG1 X2\nG1 X3 E-1\nM82\nG92 E0\nG1 X4 E2\nG1 X5 E2", true).map((point) => point[3]), [1, 0, 0, 1, 0]);
});

test("draws arcs on their circle, whole ones too", () => {
  const points = path("G0 X10 Y0\nG2 X10 Y0 I-10 J0\nG3 X-10 Y0 I-10");
  assert.ok(points.length > 30);
  for (const [x = 0, y = 0] of points) assert.ok(Math.abs(Math.hypot(x, y) - 10) < 0.01, `${x} ${y}`);
  assert.deepEqual(points.at(-1), [-10, 0, 0, 1]);
});

test("writes figures as people read them", () => {
  assert.equal(num(-0.0004, 3), "0.000");
  assert.equal(num(-2.5, 1), "\u22122.5");
  assert.equal(num(undefined), "–");
  assert.deepEqual([12, 75, 2400, 7260, 400000].map(duration), ["12 s", "1 min 15 s", "40 min", "2 h 01 min", "4 d 15 h"]);
  assert.deepEqual([999, 1500, 25_300_000].map(bytes), ["999 B", "1.5 kB", "25 MB"]);
  assert.equal(plainName("parts/left bracket.gcode"), "left bracket");
});

test("reads what the machine says to a file", () => {
  const found = readPreflight(["line 7: stops: X 300 is out (move it) here (place it elsewhere)", "hole.ngc, line 2: warning: S is asked (turn it on (M3) before)", "9 lines: 1 stop the job, 1 warnings"]);
  assert.deepEqual(found.findings, [
    { line: 7, stops: true, text: "X 300 is out (move it) here", remedy: "place it elsewhere" }, { file: "hole.ngc", line: 2, stops: false, text: "S is asked", remedy: "turn it on (M3) before" },
  ]);
  assert.deepEqual(found.totals, ["9 lines: 1 stop the job, 1 warnings"]);
});

test("puts settings together from the schema and the file", () => {
  const schema: Schema = { general: { all: { dialect: [["a", "b"], "a", "Which."] } }, switch: { each: { enable: ["boolean", "false", "There is."] } }, volts: { free: ["text", null, "Pin.", "V"] } };
  const written = readIni("# head\n[general]\ndialect = b # why\n\n[switch]\nfan.enable=true\n[volts]\nvmotor = ADC3_0\n");
  const all = settingsOf(schema, written, ["switch/lamp"]);
  assert.deepEqual(all.map((one) => [one.section, one.key, one.value, one.isSet]), [
    ["general", "dialect", "b", true], ["switch", "fan.enable", "true", true], ["switch", "lamp.enable", "false", false], ["volts", "vmotor", "ADC3_0", true],
  ]);
  assert.deepEqual([all[0]!.type, all[0]!.choices, all[3]!.unit], ["choice", ["a", "b"], "V"]);
});
