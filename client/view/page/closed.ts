// Whether fragments are closed: after welding the vertices that the result declares equal, each edge has two opposite half-edges.

import type { FragmentRow, ResultMessage } from "./result";

/** Whether one fragment is closed. */
export function isClosed(result: ResultMessage, fragment: FragmentRow): boolean {
  const merges = result.integers("merges");
  const indices = result.integers("indices");
  const welded = new Uint32Array(fragment.vertexCount);
  for (let vertex = 0; vertex < welded.length; vertex++) welded[vertex] = vertex;
  const root = (vertex: number) => {
    let at = vertex;
    while (welded[at] !== at) at = welded[at] = welded[welded[at]!]!;
    return at;
  };
  for (let at = fragment.mergeFirst; at < fragment.mergeFirst + fragment.mergeCount; at++) {
    welded[root(merges[2 * at]!)] = root(merges[2 * at + 1]!);
  }
  const [edges, opposite] = [new Float64Array(fragment.indexCount), new Float64Array(fragment.indexCount)];
  for (let at = 0; at < fragment.indexCount; at++) {
    const next = at % 3 === 2 ? at - 2 : at + 1;
    const from = root(indices[fragment.indexFirst + at]!);
    const to = root(indices[fragment.indexFirst + next]!);
    if (from === to) return false;
    edges[at] = from * fragment.vertexCount + to;
    opposite[at] = to * fragment.vertexCount + from;
  }
  edges.sort();
  opposite.sort();
  return edges.length > 0 && edges.every((edge, at) => edge === opposite[at] && (at === 0 || edge !== edges[at - 1]));
}

/** Counts the closed fragments, a few at a time, so that the page stays responsive; ends early once `isNeeded` is false. */
export async function countClosed(result: ResultMessage, isNeeded: () => boolean): Promise<number> {
  let count = 0;
  let begun = performance.now();
  for (const fragment of result.fragments) {
    if (!isNeeded()) break;
    if (isClosed(result, fragment)) count++;
    if (performance.now() - begun > 8) {
      await new Promise((resolve) => setTimeout(resolve, 4));
      begun = performance.now();
    }
  }
  return count;
}
