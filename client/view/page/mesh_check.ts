// What is wrong with a mesh file, in plain words, before its parser reads it.

/** Endings of the names of mesh files that are read: one file holds all. */
export const ENDINGS = ["obj", "ply", "stl", "glb", "gltf", "msh", "vtk", "mesh"];

/** The endings as a list of words. */
export const ENDING_LIST = ENDINGS.map((ending) => `.${ending}`).join(", ");

/** Ending of the name of a file, in small letters. */
export function endingOf(name: string): string {
  return name.includes(".") ? name.split(".").pop()!.toLowerCase() : "";
}

/** Longest header of a PLY file, bytes. */
const PLY_HEAD_BYTES_MAX = 1 << 16;

/** Bytes before the triangles of a binary STL file, and of one triangle. */
const STL_HEAD_BYTES = 84;
const STL_TRIANGLE_BYTES = 50;

/** Extensions of glTF files whose triangles only a decoder reads. */
const COMPRESSIONS = ["KHR_draco_mesh_compression", "EXT_meshopt_compression"];

/** Why a file cannot be one of its ending; `undefined` if nothing speaks against it. */
export function problemOf(ending: string, contents: ArrayBuffer): string | undefined {
  switch (ending) {
    case "obj":
      return objProblem(new TextDecoder().decode(contents));
    case "stl":
      return stlProblem(contents);
    case "ply":
      if (textAt(contents, 0, 3) !== "ply") return "it is no PLY file: its first line is not “ply”";
      return textAt(contents, 0, PLY_HEAD_BYTES_MAX).includes("end_header") ? undefined : damaged("ply");
    case "glb":
    case "gltf":
      return gltfProblem(contents);
    default:
      return undefined;
  }
}

/** What a parser that fails at such a file says. */
export function damaged(ending: string): string {
  return `the file ends early or is no ${ending.toUpperCase()} file`;
}

function textAt(contents: ArrayBuffer, first: number, count: number): string {
  return new TextDecoder("latin1").decode(contents.slice(first, first + count));
}

function objProblem(text: string): string | undefined {
  const [hasVertex, hasFace] = [/^\s*v\s+\S/m.test(text), /^\s*f\s+-?\d/m.test(text)];
  if (!hasVertex && !hasFace) return "it is no OBJ file: no line of it is a vertex or a face";
  return hasFace ? undefined : "it has vertices, but no faces";
}

function stlProblem(contents: ArrayBuffer): string | undefined {
  if (/^\s*solid/.test(textAt(contents, 0, 80)) && /\bfacet\b/.test(textAt(contents, 0, 1000))) return undefined;
  const count = contents.byteLength < STL_HEAD_BYTES ? Infinity : new DataView(contents).getUint32(STL_HEAD_BYTES - 4, true);
  return STL_HEAD_BYTES + STL_TRIANGLE_BYTES * count > contents.byteLength ? damaged("stl") : undefined;
}

/** What the page looks at in the JSON of a glTF file. */
interface GltfJson {
  buffers?: { uri?: string }[];
  extensionsRequired?: string[];
}

function gltfProblem(contents: ArrayBuffer): string | undefined {
  const isBinary = textAt(contents, 0, 4) === "glTF";
  const view = new DataView(contents);
  if (isBinary && (contents.byteLength < 20 || view.getUint32(8, true) > contents.byteLength)) return "the file ends early";
  const bytes = isBinary ? contents.slice(20, 20 + view.getUint32(12, true)) : contents;
  let json: GltfJson;
  try {
    json = JSON.parse(new TextDecoder().decode(bytes)) as GltfJson;
  } catch {
    return isBinary ? "its description is damaged" : "it is no glTF file: it begins with neither “glTF” nor a description in JSON";
  }
  const other = json.buffers?.find(({ uri }) => uri !== undefined && !uri.startsWith("data:"))?.uri;
  if (other !== undefined) return `its triangles are in another file (${other}); save it as .glb, which holds all`;
  const compression = json.extensionsRequired?.find((name) => COMPRESSIONS.includes(name));
  return compression && `its triangles are compressed (${compression}); save it without compression`;
}
