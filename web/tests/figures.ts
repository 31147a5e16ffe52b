// Figures of the page as a first visitor meets it, for docs/page.md: node tests/run.mjs figures
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";
import { closeBrowser, type Look, theBrowser, WEB } from "./harness";
import { serve, type Wanted } from "../mock/main";

/** A phone over a poor radio link, as Lighthouse has it: 1.6 Mbit/s down, 0.75 up, 150 ms there and back, a quarter of the computer's speed. */
const SLOW = { offline: false, latency: 150, downloadThroughput: 1.6e6 / 8, uploadThroughput: 0.75e6 / 8 };
const PHONE: Look = { width: 390, height: 844, touch: true };
export const DESK: Look = { width: 1360, height: 900 };

interface Figures { requests: number; sent: number; elsewhere: number; paint: number; largest: number; shift: number; blocked: number; whole: number; nodes: number; passes: number; violations: number }

/** Opens the page once, with nothing kept from before. */
export async function measure(kind: Wanted["kind"], look: Look, isSlow: boolean): Promise<Figures> {
  const board = await serve({ web: WEB, port: 0, kind, entry: "open", speed: 1 });
  const context = await (await theBrowser()).newContext({ viewport: { width: look.width ?? 0, height: look.height ?? 0 }, isMobile: look.touch ?? false, hasTouch: look.touch ?? false });
  const page = await context.newPage();
  const [requests, wire] = [[] as string[], await context.newCDPSession(page)];
  let sent = 0;
  wire.on("Network.requestWillBeSent", ({ request }) => requests.push(request.url));
  wire.on("Network.loadingFinished", ({ encodedDataLength }) => { sent += encodedDataLength; });
  await wire.send("Network.enable");
  if (isSlow) {
    await wire.send("Network.emulateNetworkConditions", SLOW);
    await wire.send("Emulation.setCPUThrottlingRate", { rate: 4 });
  }
  await page.addInitScript(() => {
    const seen = { largest: 0, shift: 0, blocked: 0 };
    (window as unknown as { seen: typeof seen }).seen = seen;
    const watch = (type: string, take: (entry: PerformanceEntry & { value?: number }) => void) => new PerformanceObserver((list) => list.getEntries().forEach(take)).observe({ type, buffered: true });
    watch("largest-contentful-paint", (entry) => { seen.largest = entry.startTime; });
    watch("layout-shift", (entry) => { seen.shift += entry.value ?? 0; });
    watch("longtask", (entry) => { seen.blocked += Math.max(0, entry.duration - 50); });
  });
  const url = `http://127.0.0.1:${board.port}/`;
  await page.goto(url);
  await page.getByRole("heading", { name: "Machine", exact: true, level: 1 }).waitFor({ state: "attached" });
  const whole = await page.evaluate(() => performance.now());
  await page.waitForTimeout(2000);
  const seen = await page.evaluate(() => ({
    ...(window as unknown as { seen: { largest: number; shift: number; blocked: number } }).seen,
    paint: performance.getEntriesByName("first-contentful-paint")[0]?.startTime ?? 0, nodes: document.querySelectorAll("*").length,
  }));
  const rules = await accessibility(page);
  await context.close();
  await board.close();
  return { requests: requests.length, sent, elsewhere: requests.filter((one) => !one.startsWith(url)).length, whole, ...seen, ...rules };
}

async function accessibility(page: { evaluate: <T>(what: string | (() => T)) => Promise<T> }): Promise<{ passes: number; violations: number }> {
  await page.evaluate(readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8"));
  return await page.evaluate(async () => {
    const { passes, violations } = await (window as unknown as { axe: { run: () => Promise<Record<"passes" | "violations", unknown[]>> } }).axe.run();
    return { passes: passes.length, violations: violations.length };
  }) as { passes: number; violations: number };
}

export async function figures(): Promise<void> {
  const looks: [string, Wanted["kind"], Look, boolean][] = [["printer, desk", "printer", DESK, false], ["printer, phone, poor link", "printer", PHONE, true], ["mill, desk", "mill", DESK, false], ["mill, phone, poor link", "mill", PHONE, true]];
  const rows: [string, (of: Figures) => string][] = [
    ["requests, of them to elsewhere", (of) => `${of.requests}, ${of.elsewhere}`], ["bytes, heads among them", (of) => of.sent.toLocaleString("en")], ["first paint (FCP)", (of) => `${of.paint.toFixed(0)} ms`],
    ["largest paint (LCP)", (of) => `${of.largest.toFixed(0)} ms`], ["first view whole", (of) => `${of.whole.toFixed(0)} ms`], ["blocked (TBT)", (of) => `${of.blocked.toFixed(0)} ms`],
    ["layout shift (CLS)", (of) => of.shift.toFixed(3)], ["DOM nodes", (of) => `${of.nodes}`], ["axe-core: rules kept, broken", (of) => `${of.passes}, ${of.violations}`],
  ];
  // A browser that has just started is slow once.
  await measure("printer", DESK, false);
  const all: Figures[] = [];
  for (const [, kind, look, isSlow] of looks) all.push(await measure(kind, look, isSlow));
  console.log(`| | ${looks.map(([name]) => name).join(" | ")} |\n|---|${looks.map(() => "---|").join("")}`);
  for (const [name, cell] of rows) console.log(`| ${name} | ${all.map(cell).join(" | ")} |`);
  await closeBrowser();
}
