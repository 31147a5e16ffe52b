// Pictures of the page, to look at: node tests/run.mjs shots FOLDER
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { closeBrowser, type Look, open, ready, visit } from "./harness";

const PHONE: Look = { width: 390, height: 844, touch: true, scale: 2 };
const WIDE: Look = { width: 1360, height: 900 };

export async function shots(folder: string, only: string): Promise<void> {
  mkdirSync(folder, { recursive: true });
  const looks: [string, Look][] = [["desktop-light", WIDE], ["desktop-dark", { ...WIDE, dark: true }], ["phone-light", PHONE], ["phone-dark", { ...PHONE, dark: true }]];
  for (const kind of ["printer", "mill"] as const) {
    for (const [name, look] of looks) {
      if (only && !`${kind}-${name}`.includes(only)) continue;
      const { page, close, errors } = await open({ kind, speed: 8 }, look);
      const shot = async (what: string, fullPage = false) => page.screenshot({ path: join(folder, `${kind}-${name}-${what}.png`), fullPage });
      await ready(page);
      await visit(page, "Files");
      await page.waitForTimeout(700);
      await shot("files");
      await page.getByRole("button", { name: kind === "mill" ? /pocket-and-outline/ : /ribbon-vase/ }).click();
      await page.waitForTimeout(600);
      await shot("file");
      await page.getByRole("button", { name: "Start", exact: true }).click({ noWaitAfter: true });
      await page.waitForTimeout(kind === "mill" ? 6000 : 14000);
      await shot("job");
      await visit(page, "Machine");
      await page.waitForTimeout(2500);
      await shot("machine");
      await shot("machine-whole", true);
      await page.getByRole("button", { name: "Make and change buttons" }).click();
      await page.waitForTimeout(400);
      await shot("buttons");
      await page.keyboard.press("Escape");
      for (const view of kind === "mill" ? ["Work"] : ["Bed", "Settings", "System", "Console"]) {
        await visit(page, view);
        await page.waitForTimeout(700);
        if (view === "Console") { await page.getByLabel("Line to send").pressSequentially("M10"); await page.waitForTimeout(200); }
        await shot(view.toLowerCase());
      }
      if (errors.length) console.log(name, errors);
      await close();
    }
  }
  await closeBrowser();
}
