// What this browser remembers: theme, steps, speeds. Nothing of it is the machine's.
import { effect, type Signal, signal } from "@preact/signals";

export function kept<T>(name: string, first: T): Signal<T> {
  let value = first;
  try {
    const found = localStorage.getItem(`velvet.${name}`);
    if (found !== null) value = JSON.parse(found) as T;
  } catch { /* No storage, or none of ours in it: the default does. */ }
  const one = signal(value);
  effect(() => {
    try { localStorage.setItem(`velvet.${name}`, JSON.stringify(one.value)); } catch { /* Private windows keep nothing. */ }
  });
  return one;
}

export type Theme = "auto" | "light" | "dark";
export const theme = kept<Theme>("theme", "auto");
effect(() => {
  if (theme.value === "auto") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme.value;
});
/** Whatever is drawn by hand looks its colours up anew when this changes. */
export const themeTurn = signal(0);
const dark = matchMedia("(prefers-color-scheme: dark)");
dark.addEventListener("change", () => { themeTurn.value += 1; });
effect(() => { theme.value; themeTurn.value = themeTurn.peek() + 1; });

/** A colour of the style sheet, as the canvas wants it. */
export function colour(name: string): string {
  const probe = document.createElement("i");
  probe.style.color = `var(--${name})`;
  document.body.append(probe);
  const found = getComputedStyle(probe).color;
  probe.remove();
  return found;
}
