// The report of a bake in words.

import { volume } from "./format";

/** What the page reads of the report of `shatterd bake --json`. */
export interface BakeReport {
  object: string;
  surface: { kind: string; reason: string | null };
  lattice_volume_m3: number;
  defects: { kind: string; counted: string; first: string; action: string }[];
  warnings: string[];
  seconds: number;
}

/** What is wrong with the counted items of each kind of defect (`DefectKind` of the service); others are clear by their count or action. */
const PROBLEMS: Record<string, string> = {
  flipped_shell: "that faced inward",
  mixed_winding: "wound against their neighbors",
  non_orientable: "without a consistent side",
  self_intersection: "that intersect",
  several_shells: "apart from each other",
  nested_shells: "inside others",
  duplicate_triangles: "with the corners of an earlier one",
  duplicate_vertices: "at the position of an earlier one",
  degenerate_triangles: "without area",
  non_manifold_edge: "shared by three or more triangles",
  non_manifold_vertex: "where surfaces touch in a point alone",
  unreferenced_vertices: "used by no triangle",
  ambiguous_inside: "neither clearly inside nor outside",
  lost_precision: "far from the origin, so rounded visibly",
  thin_wall: "on walls thinner than the lattice resolves",
  narrow_gap: "at gaps narrower than the lattice resolves",
  severed_part: "joined by less than the lattice resolves",
  coarse_elastic: "on limbs thinner than the elastic lattice resolves",
};

/** Rows for the defects: what was wrong, where, and what the bake did. */
export function reportRows(report: BakeReport): string[] {
  const rows = report.defects.map(({ kind, counted, first, action }) => {
    const problem = PROBLEMS[kind];
    return `${counted}${problem ? ` ${problem}` : ""} (first at ${first}): ${action}`;
  });
  if (report.defects.some(({ kind }) => kind === "holes")) {
    // First: it changes the object most.
    const solid = `The object is a solid of ${volume(report.lattice_volume_m3)}.`;
    rows.unshift(`${solid} A sheet has no thickness, so what open sheets enclose was filled. For a hollow object, add an inner wall to the mesh.`);
  }
  return rows;
}

/** A warning as a sentence, with what the page calls the options of `shatterd bake`. */
export function warningText(warning: string): string {
  const text = warning
    .replaceAll("`", "")
    .replaceAll("check --unit", "check the unit")
    .replace(/--unit (\w+)/g, "unit $1")
    .replace(/--up (\w+)/g, "up $1")
    .replace(/try (--[\w-]+)/g, "try shatterd bake $1");
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}${/[.!?]$/.test(text) ? "" : "."}`;
}
