// Defects of a mesh file, found in the page before the bake, each with its place.

/** A mesh as triangles, in the unit of its file. */
export interface TriangleMesh {
  /** Three coordinates per corner. */
  positions: Float32Array;
  /** Three corners per triangle. */
  indices: Uint32Array;
}

/** Kinds of [`Defect`]. */
export type DefectKind = "hole" | "open" | "edge" | "winding" | "flat";

/** One defect. */
export interface Defect {
  kind: DefectKind;
  /** Lines that show it: six coordinates each. */
  lines: number[];
  /** Middle of it. */
  center: [number, number, number];
  /** Number of edges or triangles. */
  count: number;
}

/** What one defect of a kind is called, and several. */
export const NAMES: Record<DefectKind, [string, string]> = {
  hole: ["hole", "holes"],
  open: ["open edge", "open edges"],
  edge: ["edge of three or more triangles", "edges of three or more triangles"],
  winding: ["edge between faces that face opposite ways", "edges between faces that face opposite ways"],
  flat: ["triangle without area", "triangles without area"],
};

/** Numbers of vertices by position: equal positions have one number. */
function weld(positions: Float32Array): Uint32Array {
  const numbers = new Map<string, number>();
  const welded = new Uint32Array(positions.length / 3);
  for (let at = 0; at < welded.length; at++) {
    const key = `${positions[3 * at]! + 0},${positions[3 * at + 1]! + 0},${positions[3 * at + 2]! + 0}`;
    const known = numbers.get(key);
    if (known === undefined) numbers.set(key, at);
    welded[at] = known ?? at;
  }
  return welded;
}

/** All defects of a mesh. */
export function findDefects(mesh: TriangleMesh): Defect[] {
  const welded = weld(mesh.positions);
  const uses = new Map<number, number[]>();
  const flat: number[] = [];
  const count = mesh.positions.length / 3;
  for (let at = 0; at + 2 < mesh.indices.length; at += 3) {
    const corners = [0, 1, 2].map((k) => welded[mesh.indices[at + k]!]!);
    if (corners[0] === corners[1] || corners[1] === corners[2] || corners[2] === corners[0]) {
      flat.push(corners[0]!, corners[1]!, corners[1]!, corners[2]!);
      continue;
    }
    for (let k = 0; k < 3; k++) {
      const [a, b] = [corners[k]!, corners[(k + 1) % 3]!];
      const key = Math.min(a, b) * count + Math.max(a, b);
      const sides = uses.get(key) ?? [];
      sides.push(a < b ? 1 : -1);
      uses.set(key, sides);
    }
  }
  const found = [...uses].filter(([, sides]) => sides.length !== 2 || sides[0] === sides[1]);
  const ends = (key: number): [number, number] => [Math.floor(key / count), key % count];
  const open = found.filter(([, sides]) => sides.length === 1).map(([key]) => ends(key));
  const crowded = found.filter(([, sides]) => sides.length > 2).map(([key]) => ends(key));
  const twisted = found.filter(([, sides]) => sides.length === 2).map(([key]) => ends(key));
  const all: Defect[] = groups(open).map((edges) => defect(hasLoop(edges) ? "hole" : "open", edges, mesh.positions));
  for (const [kind, edges] of [["edge", crowded], ["winding", twisted]] as const) {
    all.push(...groups(edges).map((own) => defect(kind, own, mesh.positions)));
  }
  const pairs: [number, number][] = [];
  for (let at = 0; at < flat.length; at += 2) pairs.push([flat[at]!, flat[at + 1]!]);
  for (const group of groups(pairs)) all.push({ ...defect("flat", group, mesh.positions), count: group.length / 2 });
  return all.sort((a, b) => b.count - a.count);
}

/** Edges that hang together, largest groups first. */
function groups(edges: [number, number][]): [number, number][][] {
  const parent = new Map<number, number>();
  const root = (vertex: number): number => {
    let at = vertex;
    for (let up = parent.get(at); up !== undefined && up !== at; up = parent.get(at)) at = up;
    parent.set(vertex, at);
    return at;
  };
  for (const [a, b] of edges) parent.set(root(a), root(b));
  const found = new Map<number, [number, number][]>();
  for (const edge of edges) {
    const own = root(edge[0]);
    const group = found.get(own);
    if (group) group.push(edge);
    else found.set(own, [edge]);
  }
  return [...found.values()];
}

/** Whether connected edges close a loop. The border of a sheet that ends at an edge of three or more triangles does not. */
function hasLoop(edges: [number, number][]): boolean {
  return edges.length >= new Set(edges.flat()).size;
}

function defect(kind: DefectKind, edges: [number, number][], positions: Float32Array): Defect {
  const lines = edges.flatMap((edge) => edge.flatMap((vertex) => [0, 1, 2].map((axis) => positions[3 * vertex + axis]!)));
  const center = [0, 1, 2].map((axis) => {
    let sum = 0;
    for (let at = axis; at < lines.length; at += 3) sum += lines[at]!;
    return sum / (lines.length / 3);
  });
  return { kind, lines, center: center as [number, number, number], count: edges.length };
}
