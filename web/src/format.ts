// Numbers, sizes and times as people read them.

const whole = new Intl.NumberFormat("en");

export function count(n: number): string {
  return whole.format(Math.round(n));
}

function short(n: number): string {
  return n >= 99.95 ? n.toFixed(0) : n >= 9.995 ? n.toFixed(1) : n.toFixed(2);
}

export function bytes(n: number): string {
  const units = ["B", "KiB", "MiB", "GiB", "TiB"];
  let unit = 0;
  while (n >= 1024 && unit + 1 < units.length) {
    n /= 1024;
    ++unit;
  }
  return `${unit === 0 ? n : short(n)} ${units[unit]}`;
}

const units: Record<string, string> = {metre: "m", foot: "ft", "US survey foot": "US ft", degree: "°"};

// "20.21 m": a number with at most so many digits after the point; `unit` as the service calls it, empty where nobody knows.
export function withUnit(value: number, unit: string, digits = 2): string {
  const number = value.toLocaleString("en", {maximumFractionDigits: digits});
  return unit === "degree" ? `${number}°` : unit ? `${number} ${units[unit] ?? unit}` : number;
}

// "1 h 04 min", "3 min 20 s", "12 s", "0.4 s"
export function duration(seconds: number): string {
  if (seconds < 9.95) return `${seconds.toFixed(1)} s`;
  const s = Math.round(seconds);
  const two = (n: number) => String(n).padStart(2, "0");
  if (s < 60) return `${s} s`;
  if (s < 3600) return `${Math.floor(s / 60)} min ${two(s % 60)} s`;
  if (s < 86400) return `${Math.floor(s / 3600)} h ${two(Math.floor(s / 60) % 60)} min`;
  return `${Math.floor(s / 86400)} d ${Math.floor(s / 3600) % 24} h`;
}

export function secondsBetween(from: string | undefined, to: string | undefined): number | null {
  if (!from) return null;
  const end = to ? Date.parse(to) : Date.now();
  const seconds = (end - Date.parse(from)) / 1000;
  return Number.isFinite(seconds) ? Math.max(0, seconds) : null;
}

const sameDay = new Intl.DateTimeFormat("en-GB", {hour: "2-digit", minute: "2-digit", second: "2-digit"});
const otherDay = new Intl.DateTimeFormat("en-GB", {day: "numeric", month: "short", hour: "2-digit", minute: "2-digit"});
const otherYear = new Intl.DateTimeFormat("en-GB", {day: "numeric", month: "short", year: "numeric"});

// "today 14:03:22", "24 Nov, 14:03", "24 Nov 2025". In the zone of who looks.
export function moment(rfc3339: string | undefined): string {
  if (!rfc3339) return "–";
  const at = new Date(rfc3339);
  if (Number.isNaN(at.getTime())) return rfc3339;
  const now = new Date();
  if (at.toDateString() === now.toDateString()) return `today ${sameDay.format(at)}`;
  return (at.getFullYear() === now.getFullYear() ? otherDay : otherYear).format(at);
}

// "tile_points" as "Tile points"
export function words(name: string): string {
  const text = name.replaceAll("_", " ");
  return text.charAt(0).toUpperCase() + text.slice(1);
}

// A sentence begins with a capital and ends with a full stop.
export function sentence(text: string): string {
  const trimmed = text.trim();
  if (trimmed === "") return "";
  return trimmed.charAt(0).toUpperCase() + trimmed.slice(1) + (/[.!?]$/.test(trimmed) ? "" : ".");
}
