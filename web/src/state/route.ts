// Which view is shown: in the address behind #, so that back, forward and bookmarks work.
import { signal } from "@preact/signals";

export type View = "machine" | "job" | "files" | "console" | "bed" | "work" | "settings" | "system";
const VIEWS: View[] = ["machine", "job", "files", "console", "bed", "work", "settings", "system"];

function read(): View {
  const name = location.hash.slice(2) as View;
  return VIEWS.includes(name) ? name : "machine";
}
export const view = signal<View>(read());
window.addEventListener("hashchange", () => { view.value = read(); });
export function go(to: View): void {
  location.hash = `#/${to}`;
}
