// Small charts of the panel: a histogram of volumes, and bars of stages.

import { textElement } from "./dom";
import { counted, times, volume } from "./format";
import type { ResultHead } from "./result";

const SVG = "http://www.w3.org/2000/svg";

/** Number of bars of a histogram. */
const BINS = 18;

function svg(name: string, attributes: Record<string, string | number>, text = ""): SVGElement {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  element.textContent = text;
  return element;
}

/** Draws a histogram of volumes on a logarithmic axis, with the number of pieces in the highest bar. */
export function histogram(into: HTMLElement, volumesM3: number[]): void {
  const positive = volumesM3.filter((value) => value > 0);
  into.replaceChildren();
  if (positive.length === 0) return;
  const [least, most] = [Math.min(...positive), Math.max(...positive)];
  const [low, high] = [Math.log(least) - 1e-9, Math.log(most) + 1e-9];
  const bins = new Array<number>(BINS).fill(0);
  for (const value of positive) bins[Math.min(BINS - 1, Math.floor((BINS * (Math.log(value) - low)) / (high - low)))]! += 1;
  const tallest = Math.max(...bins);
  const [width, top, height] = [280, 6, 60];
  const left = 6 + 7 * String(tallest).length;
  const step = (width - left) / BINS;
  const label = `Histogram of ${positive.length} volumes, ${volume(least)} to ${volume(most)}; at most ${counted(tallest, "piece")} in a bar`;
  const root = svg("svg", { viewBox: `0 0 ${width} ${height + 16}`, role: "img", "aria-label": label });
  bins.forEach((count, at) => {
    const h = ((height - top) * count) / tallest;
    root.append(svg("rect", { x: left + at * step + 1, y: height - h, width: step - 2, height: h, rx: 1.5, fill: "var(--bar)" }));
  });
  const line = (x1: number, y1: number, x2: number, y2: number) => svg("line", { x1, y1, x2, y2, stroke: "var(--soft)", "stroke-width": 0.5 });
  root.append(line(left, height + 0.5, width, height + 0.5), line(left, top, left, height), line(left - 3, top, left, top));
  const text = (x: number, y: number, words: string, anchor: string) =>
    svg("text", { x, y, "text-anchor": anchor, "font-size": 11, fill: "var(--soft)" }, words);
  root.append(text(left - 5, top + 4, String(tallest), "end"), text(left - 5, height + 2, "0", "end"));
  root.append(text(left, height + 13, volume(least), "start"), text(width, height + 13, volume(most), "end"));
  into.append(root);
}

/** Draws the times of the stages and effects that ran. */
export function stageBars(into: HTMLElement, head: ResultHead): void {
  const rows = [...head.stages, ...head.effects.filter((effect) => effect.ns > 0)].filter((row) => row.ran);
  const most = Math.max(1, ...rows.map((row) => row.ns));
  const grid = document.createElement("div");
  grid.className = "bars";
  const values = times(rows.map((row) => row.ns));
  rows.forEach((row, at) => {
    const bar = document.createElement("i");
    bar.style.width = `${(100 * row.ns) / most}%`;
    grid.append(textElement("span", row.name), bar, textElement("b", values[at]!));
  });
  into.replaceChildren(grid);
}
