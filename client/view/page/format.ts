// Numbers with units, for people.

/** A number with three significant digits. */
export function digits(value: number, count = 3): string {
  if (value === 0 || !Number.isFinite(value)) return String(value);
  if (Math.abs(value) >= 1e5 || Math.abs(value) < 1e-4) return value.toExponential(count - 1).replace(/e\+?(-?\d+)/, (_, power: string) => `·10${superscript(power)}`);
  return Number(value.toPrecision(count)).toLocaleString("en-US", { maximumFractionDigits: 8 });
}

function superscript(power: string): string {
  return [...power].map((letter) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(letter)] ?? "⁻").join("");
}

/** A value with the prefix that makes `scale` short: values of one scale have one unit. */
export function withUnit(value: number, unit: string, scale = value): string {
  for (const [factor, prefix] of [[1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"], [1e-12, "p"]] as const) {
    if (Math.abs(scale) >= factor) return `${digits(value / factor)} ${prefix}${unit}`;
  }
  return `${digits(value)} ${unit}`;
}

/** A length in millimeters, m: places and radii that stand side by side have one unit. */
export function millimeters(valueM: number): string {
  return `${digits(1000 * valueM)} mm`;
}

/** A length, m. */
export function length(valueM: number): string {
  if (valueM >= 1) return `${digits(valueM)} m`;
  return valueM >= 0.01 ? `${digits(valueM * 100)} cm` : `${digits(valueM * 1000)} mm`;
}

/** A volume, m³. */
export function volume(valueM3: number): string {
  if (valueM3 >= 1e-3) return `${digits(valueM3 * 1e3)} L`;
  return valueM3 >= 1e-7 ? `${digits(valueM3 * 1e6)} cm³` : `${digits(valueM3 * 1e9)} mm³`;
}

/** An area in the unit that makes `scale` short, m². */
export function area(valueM2: number, scale = valueM2): string {
  if (scale >= 0.1) return `${digits(valueM2)} m²`;
  return scale >= 1e-5 ? `${digits(valueM2 * 1e4)} cm²` : `${digits(valueM2 * 1e6)} mm²`;
}

/** A unit of times in ns, and its name: that which makes `ns` short. */
function timeUnit(ns: number): [number, string] {
  if (ns >= 1e9) return [1e9, "s"];
  return ns >= 1e5 ? [1e6, "ms"] : [1e3, "µs"];
}

/** A time, ns. */
export function time(ns: number): string {
  const [unit, name] = timeUnit(ns);
  return `${digits(ns / unit)} ${name}`;
}

/** Times of a column, ns: one unit and one number of decimals, so that the longest has three digits. */
export function times(column: number[]): string[] {
  const most = Math.max(1, ...column);
  const [unit, name] = timeUnit(most);
  const decimals = Math.max(0, 2 - Math.floor(Math.log10(most / unit)));
  return column.map((ns) => {
    const text = (ns / unit).toFixed(decimals);
    return `${ns > 0 && Number(text) === 0 ? `< ${(10 ** -decimals).toFixed(decimals)}` : text} ${name}`;
  });
}

/** Coordinates of a place of an object, mm: as many decimals as three digits of its size need. */
export function place(coordinatesM: number[], sizeM: number): string {
  const decimals = Math.max(0, 2 - Math.floor(Math.log10(1000 * sizeM)));
  // Adding 0 makes a zero of the negative one.
  return coordinatesM.map((x) => (Number((1000 * x).toFixed(decimals)) + 0).toFixed(decimals)).join(", ");
}

/** A share. */
export function percent(share: number): string {
  return `${digits(100 * share, 2)} %`;
}

/** A number of things. */
export function counted(count: number, one: string): string {
  return `${count.toLocaleString("en-US")} ${count === 1 ? one : `${one}s`}`;
}
