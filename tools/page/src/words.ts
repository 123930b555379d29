// Numbers and names for people.

const prefixes: [number, string][] = [
  [1e6, "M"],
  [1e3, "k"],
  [1, ""],
  [1e-3, "m"],
  [1e-6, "µ"],
  [1e-9, "n"],
];

const kLeast = 1e-12; // what is less is rounding, not a quantity

/** Three significant digits, never in powers of ten. */
export function digits(value: number, count = 3): string {
  if (!Number.isFinite(value)) return "unknown";
  if (value === 0) return "0";
  const decimals = Math.max(0, count - 1 - Math.floor(Math.log10(Math.abs(value))));
  return value.toFixed(Math.min(decimals, 12));
}

const kNothing = "no row counts"; // in place of a number that is null

/** "2.13 mm", "41 mN"; 0, or what rounds to it, has no prefix. */
export function quantity(value: number | null, unit: string, count = 3): string {
  if (value === null) return kNothing;
  if (!Number.isFinite(value)) return "unknown";
  const scaled = scaleFor(Math.abs(value), unit);
  return `${digits(Math.abs(value) < kLeast ? 0 : value * scaled.scale, count)} ${scaled.unit}`;
}

/** The unit with the prefix that suits values of this size, and what they are multiplied by. */
export function scaleFor(size: number, unit: string): { unit: string; scale: number } {
  const [factor, prefix] = size > kLeast ? (prefixes.find(([f]) => size >= f * 0.9995) ?? prefixes[5]) : prefixes[2];
  return { unit: prefix + unit, scale: 1 / factor };
}

/** 0.0213 is "2.1 %". */
export function percent(share: number | null, decimals = 1): string {
  if (share === null) return kNothing;
  return Number.isFinite(share) ? `${(100 * share).toFixed(decimals)} %` : "unknown";
}

/** A tick of the engine [ns], in seconds with their prefix. */
export function tick(tick_ns: number | null): string {
  return tick_ns === null ? "unknown" : quantity(tick_ns * 1e-9, "s");
}

export function millimetres(length_m: number, decimals = 1): string {
  return Number.isFinite(length_m) ? `${(1e3 * length_m).toFixed(decimals)} mm` : "unknown";
}

/** "back_and_forth" is "back and forth". */
export function plain(name: string): string {
  return name.replaceAll("_", " ");
}

export function counted(count: number, one: string, several: string): string {
  return `${count} ${count === 1 ? one : several}`;
}

/** Round numbers that divide a range into at most `count` steps. */
export function ticks(low: number, high: number, count = 5): number[] {
  const rough = (high - low) / count;
  if (!(rough > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5, 10].find((s) => s * power >= rough) ?? 10);
  const out: number[] = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) out.push(k * step);
  return out;
}

/** A tick's label with the digits that its step needs. */
export function tickLabel(value: number, step: number): string {
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return value.toFixed(Math.min(decimals, 8));
}
