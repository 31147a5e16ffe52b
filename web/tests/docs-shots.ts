// The four pictures of docs/page.md: node tests/run.mjs pictures FOLDER
import { join } from "node:path";
import { closeBrowser, type Look, open, ready, visit } from "./harness";

interface Wish { name: string; kind: "printer" | "mill"; look: Look; view: string; wait: number }
const WISHES: Wish[] = [
  { name: "page-machine", kind: "printer", look: { width: 1280, height: 860 }, view: "Machine", wait: 14000 },
  { name: "page-mill", kind: "mill", look: { width: 1280, height: 860 }, view: "Machine", wait: 7000 },
  { name: "page-phone", kind: "printer", look: { width: 390, height: 780, touch: true }, view: "Machine", wait: 13000 },
  { name: "page-dark", kind: "printer", look: { width: 1280, height: 860, dark: true }, view: "Job", wait: 13000 },
];

export async function pictures(folder: string, only: string): Promise<void> {
  for (const { name, kind, look, view, wait } of WISHES) {
    if (!name.includes(only)) continue;
    const { page, close } = await open({ kind, speed: 8 }, look);
    await ready(page);
    await visit(page, "Files");
    await page.getByRole("button", { name: kind === "mill" ? /pocket-and-outline/ : /ribbon-vase/ }).click();
    await page.getByRole("button", { name: "Start", exact: true }).click({ noWaitAfter: true });
    await visit(page, view);
    await page.waitForTimeout(wait);
    await page.screenshot({ path: join(folder, `${name}.png`) });
    await close();
  }
  await closeBrowser();
}
