// The page in a browser: each function once, in the words that a person reads.
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import { after, test } from "node:test";
import { readFileSync } from "node:fs";
import type { Page } from "playwright-core";
import { DESK, measure } from "./figures";
import { closeBrowser, type Look, open, type Opened, ready, visit } from "./harness";
import type { Wanted } from "../mock/main";

const IS_MOCK = !process.env.VELVET_URL;
after(closeBrowser);

/** A test with a browser and a board of its own, which fails on any error that the page did not handle. */
function page(name: string, wanted: Partial<Wanted>, run: (page: Page, opened: Opened) => Promise<void>, look: Look = {}): void {
  const isForMock = wanted.kind === "mill" || (wanted.entry !== undefined && wanted.entry !== "open");
  test(name, { timeout: 180000, skip: isForMock && !IS_MOCK }, async () => {
    const opened = await open(wanted, look);
    try {
      await run(opened.page, opened);
      assert.deepEqual(opened.errors, [], "errors of the page");
    } finally { await opened.close(); }
  });
}
const text = (on: Page, selector: string) => on.locator(selector).first().textContent().then((found) => found ?? "");
async function until(what: string, holds: () => Promise<boolean>): Promise<void> {
  for (let turn = 0; turn < 300; turn++) {
    if (await holds()) return;
    await new Promise((done) => setTimeout(done, 100));
  }
  assert.fail(what);
}
async function typeLine(on: Page, line: string): Promise<void> {
  await visit(on, "Console");
  await on.getByLabel("Line to send").fill(line);
  await on.getByLabel("Line to send").press("Escape").catch(() => undefined);
  await on.getByLabel("Line to send").fill(line);
  await on.getByRole("button", { name: "Send" }).click();
}
async function start(on: Page, file: RegExp): Promise<void> {
  await visit(on, "Files");
  await on.getByRole("button", { name: file }).click();
  await on.getByRole("button", { name: "Start", exact: true }).click({ noWaitAfter: true });
  await on.getByRole("button", { name: "Pause" }).first().waitFor();
}

page("shows the state, and steps with the pad move the axis", {}, async (on) => {
  await ready(on);
  await on.getByRole("button", { name: "Home all axes" }).click();
  await on.locator(".pill", { hasText: "Ready" }).waitFor();
  await until("X is at 0", async () => (await text(on, ".positions div:nth-child(1) b")) === "0.00");
  await on.getByRole("region", { name: "Move" }).getByRole("radio", { name: "10", exact: true }).check();
  await on.getByRole("button", { name: "X +" }).click();
  await until("X is at 10", async () => (await text(on, ".positions div:nth-child(1) b")) === "10.00");
  await on.getByRole("button", { name: "X −" }).click();
  await on.getByRole("button", { name: "X −" }).click();
  await on.locator(".notice.error", { hasText: "out of travel" }).waitFor();
});

page("jogs while a key is held, and stands when it is let go", { speed: 1 }, async (on) => {
  await ready(on);
  await on.getByRole("radio", { name: "While held" }).check();
  await on.keyboard.press("j");
  await on.locator(".jogpad:focus").waitFor();
  const before = Number(await text(on, ".positions div:nth-child(1) b"));
  await on.keyboard.down("ArrowRight");
  await on.locator(".pill", { hasText: "Jogging" }).waitFor();
  await on.waitForTimeout(700);
  await on.keyboard.up("ArrowRight");
  await on.locator(".pill", { hasText: "Ready" }).waitFor();
  await on.waitForTimeout(400);
  const stood = await text(on, ".positions div:nth-child(1) b");
  assert.ok(Number(stood) > before + 10, `${before} to ${stood}`);
  await on.waitForTimeout(500);
  assert.equal(await text(on, ".positions div:nth-child(1) b"), stood);
});

page("a jog ends by itself when the link dies", {}, async (on, { board }) => {
  if (!board) return;
  await ready(on);
  await on.getByRole("radio", { name: "While held" }).check();
  const pad = await on.getByRole("button", { name: "Y −" }).boundingBox();
  await on.mouse.move(pad!.x + 20, pad!.y + 20);
  await on.mouse.down();
  await until("it jogs", async () => board.machine.mode === "Jog");
  await on.evaluate(() => { const real = WebSocket.prototype.send; WebSocket.prototype.send = function (data) { if (!String(data).includes("velvet.jog")) real.call(this, data); }; });
  await until("it stands", async () => board.machine.mode === "Idle");
  await on.mouse.up();
});

page("sets temperatures and draws them", { speed: 10 }, async (on) => {
  await ready(on);
  await on.getByLabel("Hot end: target").fill("200");
  await on.getByLabel("Hot end: target").press("Enter");
  await until("it warms", async () => Number.parseFloat(await text(on, ".heat tbody tr:first-child .figure")) > 60);
  assert.ok(await on.locator(".chart canvas").count() === 1);
  await on.getByRole("button", { name: "Hot end: off" }).click();
  await until("it is off", async () => (await on.getByLabel("Hot end: target").inputValue()) === "0");
  await on.getByLabel("Hot end: target").fill("400");
  await on.getByLabel("Hot end: target").press("Enter");
  await until("the most is taken", async () => (await on.getByLabel("Hot end: target").inputValue()) === "300");
});

page("plays a job with its path, pauses and cancels it", { speed: 8 }, async (on) => {
  await ready(on);
  await start(on, /ribbon-vase/);
  await until("there is a path", async () => Number(await on.locator(".stage canvas").getAttribute("data-points")) > 50);
  await on.getByRole("button", { name: "Pause" }).click();
  await on.locator(".pill", { hasText: "Held" }).waitFor();
  await on.locator("main").focus();
  await on.keyboard.press(" ");
  await on.locator(".pill", { hasText: "Running" }).waitFor();
  await on.getByRole("button", { name: "Cancel" }).click();
  await on.getByRole("button", { name: "Cancel the job" }).click();
  await on.getByText("Cancelled").first().waitFor();
});

page("draws a file before it is made", {}, async (on) => {
  await ready(on);
  await visit(on, "Files");
  await on.getByRole("button", { name: /ribbon-vase/ }).click();
  await on.getByRole("button", { name: "Path", exact: true }).click();
  await until("there is a path", async () => Number(await on.locator(".preview canvas").getAttribute("data-points")) > 4000);
  await on.getByLabel("How far into the file").fill("40");
});

page("pushes filament only when it would melt", { speed: 10 }, async (on) => {
  await ready(on);
  await on.getByRole("button", { name: "Push out" }).click();
  await on.getByText("It would not melt.").waitFor();
  await on.getByRole("button", { name: "Preheat PLA" }).click();
  await on.getByText("hot enough").waitFor();
});

page("says before a job what stands in its way", {}, async (on) => {
  await ready(on);
  await visit(on, "Files");
  await on.getByRole("button", { name: /far-out/ }).click();
  await on.getByText(/out of travel/).waitFor();
  await on.getByText("line 2", { exact: true }).waitFor();
  await on.getByRole("button", { name: "Start all the same" }).waitFor();
});

page("uploads, renames, downloads and removes files", {}, async (on) => {
  await ready(on);
  await visit(on, "Files");
  await on.getByLabel("Files to upload").setInputFiles({ name: "<b>new & old.gcode", mimeType: "text/plain", buffer: Buffer.from("G28\nG1 X10 F600\n") });
  await on.locator(".filecard", { hasText: "<b>new & old.gcode" }).click();
  await on.getByText(/Nothing stands in the way/).waitFor();
  const [download] = await Promise.all([on.waitForEvent("download"), on.getByRole("link", { name: "Download" }).click()]);
  assert.equal(readFileSync(await download.path(), "utf8"), "G28\nG1 X10 F600\n");
  await on.getByRole("button", { name: "Rename" }).click();
  await on.getByLabel("New name").fill("renamed.gcode");
  await on.getByLabel("New name").press("Enter");
  await on.locator(".filecard", { hasText: "renamed.gcode" }).click();
  await on.getByRole("button", { name: "Remove", exact: true }).click();
  await on.getByRole("button", { name: "Remove for good" }).click();
  await on.locator(".filecard", { hasText: "renamed.gcode" }).waitFor({ state: "detached" });
});

page("takes files that are dropped, and shows thumbnails", {}, async (on) => {
  await ready(on);
  await visit(on, "Files");
  await until("a picture has come", async () => await on.locator(".picture img").first().evaluate((img) => (img as HTMLImageElement).naturalWidth > 0).catch(() => false));
  await on.locator(".files").evaluate((at) => {
    const data = new DataTransfer();
    data.items.add(new File(["G28\n"], "dropped.gcode"));
    at.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
  });
  await on.locator(".filecard", { hasText: "dropped.gcode" }).waitFor();
  await on.getByRole("button", { name: "parts", exact: true }).click();
  await on.getByText("bracket-left.gcode").waitFor();
  await on.getByRole("button", { name: "Remove folder" }).click();
  await on.getByRole("button", { name: "Remove folder for good" }).click();
  await on.locator(".filecard", { hasText: "dropped.gcode" }).waitFor();
  await on.getByRole("button", { name: "parts", exact: true }).waitFor({ state: "detached" });
});

page("has a console with answers, history and completion", {}, async (on) => {
  await ready(on);
  await visit(on, "Console");
  const field = on.getByLabel("Line to send");
  await field.pressSequentially("M11");
  await on.getByRole("option", { name: /M115/ }).waitFor();
  await field.fill("M115");
  await field.press("Enter");
  await on.getByText(/FIRMWARE_NAME/).first().waitFor();
  await field.fill("NONSENSE");
  await field.press("Enter");
  await on.locator(".line.bad").first().waitFor();
  await field.press("ArrowUp");
  await field.press("ArrowUp");
  assert.equal(await field.inputValue(), "M115");
  await on.getByText("Hide plain ok").waitFor();
});

page("overrides, buttons and baby steps", {}, async (on) => {
  await ready(on);
  await on.getByLabel("Speed", { exact: true }).fill("150");
  await until("150 %", async () => (await text(on, ".slider output")).startsWith("150"));
  await on.getByRole("button", { name: "Speed: back to 100 %" }).click();
  await until("100 %", async () => (await text(on, ".slider output")).startsWith("100"));
  await on.getByRole("button", { name: "Preheat PLA" }).click();
  await until("PLA", async () => (await on.getByLabel("Hot end: target").inputValue()) === "205");
  await on.getByRole("button", { name: /0.02 mm nearer/ }).click();
  await on.getByText(/Z shifted by −0.020/).waitFor();
});

page("makes buttons that every browser has, asks before some, and plays macros of the card", { speed: 10 }, async (on, { url, context }) => {
  await ready(on);
  const card = on.getByRole("region", { name: "Buttons" });
  await card.getByRole("button", { name: "Make and change buttons" }).click();
  const dialog = on.getByRole("dialog");
  await dialog.waitFor();
  if (await dialog.getByLabel("Words on the button").first().inputValue()) await dialog.getByRole("button", { name: "Another button" }).click();
  await dialog.getByLabel("Words on the button").last().fill("Warm <b>bed");
  await dialog.getByLabel("Lines that it sends").last().fill(`M117 ${"x".repeat(60)}\n`.repeat(12) + "M140 S45");
  await dialog.getByLabel("Ask before they are sent").last().check();
  await dialog.getByRole("button", { name: "Further up" }).last().click({ timeout: 1000 }).catch(() => undefined);
  await dialog.getByRole("button", { name: "Keep" }).click();
  await dialog.waitFor({ state: "detached" });
  const second = await context.newPage();
  await second.goto(url);
  await ready(second);
  await second.getByRole("button", { name: "Warm <b>bed" }).click();
  assert.equal(await second.getByLabel("Bed: target").inputValue(), "0");
  await second.getByRole("dialog").getByRole("button", { name: "Warm <b>bed" }).click();
  await until("it was sent, in pieces", async () => (await second.getByLabel("Bed: target").inputValue()) === "45");
  await second.getByRole("button", { name: "Bed: off" }).click();
  await second.close();
  await on.reload();
  await ready(on);
  await card.getByRole("button", { name: "Warm <b>bed" }).waitFor();
  await card.getByRole("button", { name: "Make and change buttons" }).click();
  await dialog.waitFor();
  while (await dialog.getByRole("button", { name: "Remove this button" }).count()) await dialog.getByRole("button", { name: "Remove this button" }).first().click();
  await dialog.getByRole("button", { name: "Keep" }).click();
  await card.getByRole("button", { name: "Warm <b>bed" }).waitFor({ state: "detached" });
  if (IS_MOCK) {
    await card.getByRole("button", { name: "Clean the nozzle" }).click();
    await on.getByText(/Clean the nozzle is done/).waitFor();
  }
});

page("has the macros of the printer.cfg as buttons, with parameters, and others after a reload", {}, async (on, { board }) => {
  if (!board) return;
  await ready(on);
  const card = on.getByRole("region", { name: "Buttons" });
  const macros = card.getByRole("group", { name: "Macros of the printer.cfg" });
  await macros.getByRole("button", { name: "PRINT_START" }).waitFor();
  assert.deepEqual(await macros.getByRole("button").allTextContents(), ["PRINT_START", "Load_Filament", "M600"], "those with _ are for other macros");
  await until("its help", async () => (await macros.getByRole("button", { name: "Load_Filament" }).getAttribute("title")) === "Pulls filament in");
  await card.getByLabel("Parameters of the next macro").fill("BED=60 NAME=a");
  await macros.getByRole("button", { name: "PRINT_START" }).click();
  await on.getByText("PRINT_START got BED=60 NAME=a").waitFor();
  await macros.getByRole("button", { name: "Load_Filament" }).click();
  await on.getByText("Load_Filament got nothing").waitFor();
  await visit(on, "Console");
  await on.getByLabel("Line to send").pressSequentially("load_f");
  await on.getByRole("option", { name: /LOAD_FILAMENT.*Pulls filament in/ }).waitFor();
  await typeLine(on, "macros reload");
  await visit(on, "Machine");
  await macros.getByRole("button", { name: "PRINT_END" }).waitFor();
  await macros.getByRole("button", { name: "PRINT_START" }).waitFor({ state: "detached" });
});

page("goes on with an upload where the link died", {}, async (on, { board }) => {
  if (!board) return;
  await ready(on);
  await visit(on, "Files");
  const content = Buffer.alloc(3_000_000);
  for (let at = 0; at < content.length; at++) content[at] = at * 7919 % 251;
  board.api.cutUploadAt = 1_234_567;
  await on.getByLabel("Files to upload").setInputFiles({ name: "large.gcode", mimeType: "text/plain", buffer: content });
  await on.getByText("waits for the connection").waitFor();
  await on.locator(".filecard", { hasText: "large.gcode" }).waitFor();
  assert.equal(board.api.uploadedFrom, 1_234_567);
  assert.ok(board.api.card.files.get("large.gcode")!.bytes.equals(content));
});

page("has the lines from before it was opened", {}, async (on, { url, context }) => {
  await ready(on);
  await typeLine(on, "M115");
  await on.getByText(/FIRMWARE_NAME/).first().waitFor();
  const second = await context.newPage();
  await second.goto(url);
  await ready(second);
  await visit(second, "Console");
  await second.locator(".line.command", { hasText: "M115" }).first().waitFor();
  await second.getByText(/FIRMWARE_NAME/).first().waitFor();
});

page("has the machine's messages from before it was opened, with what to do, and no answers", {}, async (on, { board, url, context }) => {
  if (!board) return;
  await ready(on);
  await typeLine(on, "MOCK_FAULT");
  await on.getByRole("button", { name: "Unlock" }).click();
  for (let turn = 0; turn < 6; turn++) await typeLine(on, "M115");
  const second = await context.newPage();
  await second.goto(url);
  await ready(second);
  const messages = second.getByRole("region", { name: "Messages" }).getByRole("log");
  await messages.getByRole("listitem").filter({ hasText: "temperature fell by 24 C" }).filter({ hasText: "The sensor has come off" }).waitFor();
  assert.equal(await messages.getByText("FIRMWARE_NAME").count(), 0);
  assert.match(await text(second, ".words time"), /^\d\d:\d\d$/, "the time of today");
});

page("shows the mesh of the bed", {}, async (on) => {
  await ready(on);
  await visit(on, "Bed");
  await on.getByRole("region", { name: "Mesh" }).locator("canvas").waitFor();
  await on.locator(".mesh").waitFor();
  if (IS_MOCK) assert.equal(await on.locator(".mesh td").count(), 49);
  const canvas = on.getByRole("img", { name: /The bed in 3D: from −\d\.\d{3} mm at the (front|middle|back) (left|centre|right) to/ });
  const before = await canvas.screenshot();
  await canvas.focus();
  for (let turn = 0; turn < 4; turn++) await on.keyboard.press("ArrowLeft");
  await until("it turns", async () => !before.equals(await canvas.screenshot()));
  await on.getByText(/^highest, /).waitFor();
  await on.getByRole("radio", { name: "300×" }).check();
});

page("finds, checks, stores and undoes settings", {}, async (on) => {
  await ready(on);
  await visit(on, "Settings");
  await on.getByLabel("Find a setting").fill("default_feed_rate");
  const field = on.getByLabel("motion control, default_feed_rate");
  const before = await field.inputValue();
  await field.fill("fast");
  await on.locator(".setting .wrong", { hasText: "is not a number" }).waitFor();
  assert.ok(await on.getByRole("button", { name: "Store" }).isDisabled());
  await field.fill("2800");
  await until("checked", async () => !(await on.getByRole("button", { name: "Store" }).isDisabled()));
  await on.getByRole("button", { name: "Store" }).click();
  await on.getByText("One setting is stored.").waitFor();
  await on.getByRole("button", { name: "Undo" }).click();
  await until("it is as it was", async () => (await field.inputValue()) === before);
  await on.getByRole("button", { name: "Restart the board" }).waitFor();
  await on.getByLabel("Find a setting").fill("");
  await on.getByLabel("Section").selectOption("switch");
  await on.getByLabel("Name of another one in switch").fill("lamp");
  await on.getByRole("button", { name: "Add" }).click();
  await on.getByLabel("switch, lamp.output_pin", { exact: true }).waitFor();
});

page("says what firmware runs, and goes back to the one from before", {}, async (on) => {
  await ready(on);
  await visit(on, "System");
  await on.getByText(/^Build version: /).waitFor();
  await on.getByText(/^jobs: /).waitFor();
  if (!IS_MOCK) return;
  await on.getByRole("button", { name: "Install flashme.bin" }).waitFor();
  await on.getByRole("button", { name: "Go back to the firmware from before" }).click();
  await on.getByRole("dialog").getByRole("button", { name: "Go back" }).click();
  await on.locator(".banner", { hasText: "it is installed in a second" }).waitFor();
  await on.getByLabel("Name of the program that gets a key").fill("slicer");
  await on.getByRole("button", { name: "Make a key" }).click();
  await on.locator("code.key").waitFor();
  await on.getByRole("button", { name: "Revoke the key of slicer" }).click();
  await on.getByRole("button", { name: "Revoke the key of slicer" }).waitFor({ state: "detached" });
});

page("says a fault in words, with what to do, and unlocks", {}, async (on) => {
  await ready(on);
  await on.keyboard.press("Control+.");
  await on.locator(".pill", { hasText: "Halted" }).waitFor();
  await on.locator(".banner.fault", { hasText: "unlock" }).waitFor();
  assert.ok(await on.getByRole("button", { name: "X +" }).isDisabled());
  await on.getByRole("button", { name: "Unlock" }).click();
  await on.locator(".pill", { hasText: "Ready" }).waitFor();
  if (IS_MOCK) { await typeLine(on, "MOCK_FAULT"); await on.getByText(/The sensor has come off/).waitFor(); }
});

page("says that values are old, and comes back by itself", {}, async (on, { url, context }) => {
  const second = await context.newPage();
  let isCut = false;
  const sockets: { close: () => unknown }[] = [];
  await second.routeWebSocket(/websocket/, (socket) => {
    if (isCut) { void socket.close(); return; }
    socket.connectToServer();
    sockets.push(socket);
  });
  await on.close();
  await second.goto(url);
  await ready(second);
  isCut = true;
  for (const one of sockets) void one.close();
  await second.getByText("No connection to the machine.").waitFor();
  await second.getByText(/Everything below is .* old/).waitFor();
  await second.keyboard.press("Control+.");
  await second.getByText("The machine was told to halt.").waitFor();
  isCut = false;
  await second.locator(".pill", { hasText: "Halted" }).waitFor();
});

page("bears with a board that lacks half of it", { bare: true, speed: 8 }, async (on) => {
  await ready(on);
  await start(on, /ribbon-vase/);
  await until("positions make a path", async () => Number(await on.locator(".stage canvas").getAttribute("data-points")) > 3);
  for (const view of ["Machine", "Job", "Files", "Bed", "Console", "Settings", "System", "Machine"]) {
    await visit(on, view);
    await on.getByRole("heading", { name: view, exact: true, level: 1 }).waitFor();
    await on.waitForTimeout(200);
  }
  await on.getByLabel("Hot end: target").waitFor();
  await on.getByRole("button", { name: "Cancel" }).first().click();
  await on.getByRole("button", { name: "Cancel the job" }).click();
  await on.getByText("Cancelled").first().waitFor();
});

page("asks for a password, and lets in with it", { entry: "login" }, async (on) => {
  await on.getByLabel("Password").fill("wrong");
  await on.getByRole("button", { name: "Log in" }).click();
  await on.getByText("That is not the password.").waitFor();
  await on.getByLabel("Password").fill("velvet-test");
  await on.getByRole("button", { name: "Log in" }).click();
  await ready(on);
  assert.equal(await on.evaluate(() => document.cookie), "", "no script reads the cookie");
  await visit(on, "System");
  await on.getByRole("button", { name: "Log out" }).click();
  await on.getByLabel("Password").waitFor();
});

page("sets the first password, confirmed at the machine", { entry: "first" }, async (on, { board }) => {
  await on.getByLabel("New password").fill("a long word");
  await on.getByLabel("Once more").fill("another word");
  await on.getByRole("button", { name: "Set the password" }).click();
  await on.getByText("The two are not the same.").waitFor();
  await on.getByLabel("Once more").fill("a long word");
  await on.getByRole("button", { name: "Set the password" }).click();
  await on.getByLabel("Code").fill("000000");
  await on.getByRole("button", { name: "Confirm" }).click();
  await on.getByText(/not the code/).waitFor();
  await on.getByLabel("Code").fill(board!.code());
  await on.getByRole("button", { name: "Confirm" }).click();
  await ready(on);
});

page("who may only watch sees everything, moves nothing, and may halt", { entry: "watch" }, async (on) => {
  await ready(on);
  assert.ok(await on.getByRole("button", { name: "X +" }).isDisabled());
  assert.ok(await on.getByRole("button", { name: "Home all axes" }).isDisabled());
  await on.getByRole("button", { name: "Halt the machine at once" }).click();
  await on.locator(".pill", { hasText: "Halted" }).waitFor();
});

page("a mill: large positions, zero, offsets, spindle", { kind: "mill" }, async (on) => {
  await ready(on);
  await on.getByRole("button", { name: "X: zero here" }).click();
  await until("X 0", async () => (await text(on, ".axis .big")) === "0.000");
  await on.getByRole("button", { name: "Right", exact: true }).click();
  await until("it turns", async () => Number.parseInt(await text(on, ".cardhead .figure"), 10) > 1000);
  await visit(on, "Work");
  await on.locator("tr", { hasText: "G55" }).getByRole("button", { name: "Use" }).click();
  await on.locator("tr.active", { hasText: "G55" }).waitFor();
  await on.getByLabel("G55 Z").fill("-12.5");
  await on.getByLabel("G55 Z").press("Enter");
  await until("stored", async () => (await on.getByLabel("G55 Z").inputValue()) === "-12.500");
});

page("a mill: the laser's power, what it does, and interlocks that are open", { kind: "mill" }, async (on, { board }) => {
  await ready(on);
  assert.equal(await on.getByRole("region", { name: "Laser" }).count(), 0, "no laser, no card");
  const show = (fields: object) => board!.machine.change({ laser: { power: 0, mode: "off", on: false, test: false, framing: false, open: [], ...fields } });
  const card = on.getByRole("region", { name: "Laser" });
  for (const [fields, says] of [
    [{}, "off"], [{ mode: "M4" }, "M4"], [{ mode: "M4", power: 0.25, on: true }, "fires"], [{ power: 0.05, on: true, test: true }, "test"],
    [{ mode: "M3", power: 0.02, on: true, framing: true }, "framing"], [{ mode: "M4", open: ["lid", "door"] }, "locked"],
  ] as const) {
    show(fields);
    await card.locator(".tag", { hasText: says }).waitFor();
  }
  await card.getByText("locked: lid, door").waitFor();
  show({ power: 0.123, on: true });
  await card.getByText("12.3").waitFor();
});

page("a mill: the probe finds zero step by step", { kind: "mill", speed: 10 }, async (on) => {
  await ready(on);
  await visit(on, "Work");
  for (let step = 0; step < 3; step++) await on.getByRole("button", { name: "Next" }).click();
  await on.getByText(/G38.2 Z-20/).waitFor();
  await on.getByRole("button", { name: "Search", exact: true }).click();
  await on.getByText(/is found/).waitFor();
  await on.getByText(/Last contact/).waitFor();
});

page("works by keys alone", {}, async (on) => {
  await ready(on);
  await on.keyboard.press("3");
  await on.getByRole("heading", { name: "Files", level: 1 }).waitFor();
  await on.keyboard.press("?");
  await on.getByRole("dialog", { name: "Keys" }).waitFor();
  await on.keyboard.press("Escape");
  await on.getByRole("dialog", { name: "Keys" }).waitFor({ state: "detached" });
  await on.keyboard.press("/");
  await on.locator("input[data-slash]:focus").waitFor();
});

test("asks for little, for nothing elsewhere, and builds a small document", { timeout: 60000, skip: !IS_MOCK }, async () => {
  const { requests, elsewhere, sent, nodes, passes, violations } = await measure("printer", DESK, false);
  assert.ok(requests <= 7 && sent < 95_000, `${requests} requests, ${sent} bytes`);
  assert.ok(nodes > 200 && nodes < 450, `${nodes} nodes`);
  assert.ok(passes > 30, `${passes} rules of axe-core apply`);
  assert.deepEqual([elsewhere, violations], [0, 0], "requests to elsewhere, rules broken");
});

page("keeps the colours that were chosen", {}, async (on) => {
  await ready(on);
  const paper = () => on.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const light = await paper();
  await on.getByRole("button", { name: /Colours/ }).click();
  await on.getByRole("button", { name: /Colours/ }).click();
  assert.notEqual(await paper(), light);
  const dark = await paper();
  await on.reload();
  await ready(on);
  assert.equal(await paper(), dark);
});

const AXE = createRequire(import.meta.url).resolve("axe-core/axe.min.js");
interface Violation { id: string; nodes: { html: string; failureSummary?: string }[] }
async function violations(on: Page, where: string): Promise<string[]> {
  await on.evaluate(readFileSync(AXE, "utf8"));
  const found = await on.evaluate(async () => (await (window as unknown as { axe: { run: () => Promise<{ violations: Violation[] }> } }).axe.run()).violations);
  return found.map((one) => `${where}: ${one.id}: ${one.nodes.map((node) => `${node.html.slice(0, 160)} ${node.failureSummary?.slice(0, 260)}`).join(" | ")}`);
}
for (const dark of [false, true]) {
  for (const kind of ["printer", "mill"] as const) {
    page(`axe finds nothing: ${kind}, ${dark ? "dark" : "light"}`, { kind }, async (on) => {
      await ready(on);
      await on.waitForTimeout(500);
      const found: string[] = [];
      for (const view of kind === "mill" ? ["Machine", "Work"] : ["Machine", "Job", "Files", "Bed", "Console", "Settings", "System"]) {
        await visit(on, view);
        await on.waitForTimeout(400);
        found.push(...await violations(on, view));
      }
      assert.deepEqual(found, []);
    }, { dark });
  }
}
page("axe finds nothing: windows over the page, changes, a job at work", { speed: 4 }, async (on) => {
  await ready(on);
  const found: string[] = [];
  const look = async (where: string) => { await on.waitForTimeout(500); found.push(...await violations(on, where)); };
  await on.keyboard.press("?");
  await look("keys");
  await on.keyboard.press("Escape");
  await visit(on, "Files");
  await on.getByRole("button", { name: /ribbon-vase/ }).click();
  await on.getByRole("button", { name: "Path", exact: true }).click();
  await on.getByRole("button", { name: "Rename" }).click();
  await look("file");
  await on.keyboard.press("Escape");
  await visit(on, "Settings");
  await on.getByLabel("Find a setting").fill("default_feed_rate");
  await on.getByLabel("motion control, default_feed_rate").fill("fast");
  await look("settings");
  await on.getByRole("button", { name: "Drop" }).click();
  await visit(on, "Console");
  await on.getByLabel("Line to send").pressSequentially("M10");
  await look("console");
  await start(on, /ribbon-vase/);
  await look("job");
  await visit(on, "Machine");
  await look("machine");
  assert.deepEqual(found, []);
});
page("axe finds nothing: login, halted, on a phone", { entry: "login" }, async (on) => {
  await on.getByLabel("Password").waitFor();
  const found = await violations(on, "login");
  await on.getByLabel("Password").fill("velvet-test");
  await on.getByRole("button", { name: "Log in" }).click();
  await ready(on);
  await on.getByRole("button", { name: "Halt the machine at once" }).click();
  await on.getByRole("button", { name: "Unlock" }).waitFor();
  await on.waitForTimeout(500);
  assert.deepEqual([...found, ...await violations(on, "halted")], []);
  const wide = await on.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  assert.equal(wide, 0, "nothing is wider than the phone");
}, { width: 390, height: 844, touch: true });
