// Numbers and times as people read them.

export function num(value: number | undefined | null, digits = 2): string {
  if (value === undefined || value === null || Number.isNaN(value)) return "–";
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "\u2212");
}

/** 75 s is 1:15, an hour and more has hours. */
export function duration(seconds: number | undefined | null): string {
  if (seconds === undefined || seconds === null || !Number.isFinite(seconds)) return "–";
  const whole = Math.max(0, Math.round(seconds));
  const h = Math.floor(whole / 3600);
  const m = Math.floor(whole / 60) % 60;
  if (h >= 48) return `${Math.floor(h / 24)} d ${h % 24} h`;
  if (h) return `${h} h ${String(m).padStart(2, "0")} min`;
  if (m >= 10) return `${m} min`;
  return m ? `${m} min ${whole % 60} s` : `${whole} s`;
}

export function bytes(size: number | undefined): string {
  if (size === undefined) return "–";
  if (size < 1000) return `${size} B`;
  const units = ["kB", "MB", "GB"];
  let value = size / 1000;
  let unit = 0;
  while (value >= 1000 && unit < 2) { value /= 1000; unit++; }
  return `${value.toFixed(value < 10 ? 1 : 0)} ${units[unit]}`;
}

/** Hours and minutes of a Unix time, with the date where that is not today. */
export function clock(time: number): string {
  const at = new Date(time * 1000);
  const hours = at.toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" });
  return at.toDateString() === new Date().toDateString() ? hours : `${at.toLocaleDateString([], { day: "numeric", month: "short" })}, ${hours}`;
}

export function baseName(path: string): string {
  return path.slice(path.lastIndexOf("/") + 1);
}
export function plainName(path: string): string {
  return baseName(path).replace(/\.(gcode|gco|g|ngc|nc)$/i, "");
}

const HEATERS: Record<string, string> = { extruder: "Hot end", extruder1: "Hot end 2", heater_bed: "Bed" };
export function heaterLabel(name: string): string {
  const known = HEATERS[name];
  if (known) return known;
  const word = name.includes(" ") ? name.slice(name.indexOf(" ") + 1) : name;
  return word.charAt(0).toUpperCase() + word.slice(1).replaceAll("_", " ");
}
