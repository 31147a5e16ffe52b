// A browser, and a board to point it at: the mock, or with VELVET_URL the one that is there.
import { existsSync } from "node:fs";
import { type Browser, type BrowserContext, chromium, type Page } from "playwright-core";
import { type Board, serve, type Wanted } from "../mock/main";

const CHROMIUM = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find((path) => path && existsSync(path));
export const WEB = process.env.VELVET_WEB ?? process.cwd();

let browser: Browser | null = null;
export async function theBrowser(): Promise<Browser> {
  if (!CHROMIUM) throw new Error("There is no Chromium here: install Debian's package chromium, or say where it is in CHROMIUM.");
  browser ??= await chromium.launch({
    executablePath: CHROMIUM,
    args: ["--no-sandbox", "--use-angle=swiftshader", "--use-gl=angle", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--font-render-hinting=none"],
  });
  return browser;
}
export async function closeBrowser(): Promise<void> { await browser?.close(); browser = null; }

export interface Look { width?: number; height?: number; dark?: boolean; touch?: boolean; scale?: number }
export interface Opened { page: Page; context: BrowserContext; errors: string[]; board: Board | null; url: string; close: () => Promise<void> }

export async function open(wanted: Partial<Wanted> = {}, look: Look = {}, at?: string): Promise<Opened> {
  const given = at ?? process.env.VELVET_URL;
  const board = given ? null : await serve({ web: WEB, port: 0, kind: "printer", entry: "open", speed: 1, ...wanted });
  const url = given ?? `http://127.0.0.1:${board?.port}/`;
  const context = await (await theBrowser()).newContext({
    viewport: { width: look.width ?? 1280, height: look.height ?? 900 }, colorScheme: look.dark ? "dark" : "light", deviceScaleFactor: look.scale ?? 1,
    hasTouch: look.touch ?? false, isMobile: look.touch ?? false, locale: "en-GB",
  });
  const page = await context.newPage();
  page.setDefaultTimeout(30000);
  const errors: string[] = [];
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("console", (message) => { if (message.type() === "error" && !/WebSocket|ERR_CONNECTION|401/.test(message.text())) errors.push(message.text()); });
  await page.goto(url);
  return { page, context, errors, board, url, close: async () => { await context.close(); await board?.close(); } };
}

export async function visit(page: Page, name: string): Promise<void> {
  await page.getByRole("navigation", { name: "Views" }).getByRole("link", { name, exact: true }).click();
}
/** The machine's first view is there, with live values. */
export async function ready(page: Page): Promise<void> {
  await page.getByRole("heading", { name: "Machine", exact: true, level: 1 }).waitFor();
}
