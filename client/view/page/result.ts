// Results as they lie in shared memory: a head as JSON, then sections (see shatter-proto, `sections.rs`).

/** Facts of a result. */
export interface ResultHead {
  id: number;
  object: string;
  handle: string | null;
  sites: number;
  fracture_degree: number;
  degree_source: string;
  confidence: number;
  capped: boolean;
  stop_reason: string;
  elastic: string;
  quality: string | null;
  gamma_j_m2: number;
  e1_over_gamma: number;
  threshold_factor: number;
  strain_j: number | null;
  /** Absent in recordings of older versions. */
  impactor_j?: number | null;
  surface_j?: number | null;
  released_j?: number | null;
  stress_over_strength?: number | null;
  seed: string;
  radius_m: number;
  energy_error: number | null;
  cvd_gap: number | null;
  iterations: number;
  surface: string;
  time_ns: number;
  round_trip_ns: number;
  response_bytes: number;
  hit: { point_m: Vector; normal: Vector; distance_m: number } | null;
  stages: { name: string; ran: boolean; ns: number }[];
  effects: { name: string; ran: boolean; ns: number }[];
  /** Hashes of the sections and of all together, if the request asked for them. */
  hashes?: { name: string; hash: string }[];
  output_hash?: string;
  sections: { name: string; offset: number; bytes: number }[];
  name?: string;
  material?: string;
}

/** Three numbers. */
export type Vector = [number, number, number];

/** One fragment of a result. */
export interface FragmentRow {
  id: number;
  body: number;
  vertexFirst: number;
  vertexCount: number;
  indexFirst: number;
  indexCount: number;
  runFirst: number;
  runCount: number;
  mergeFirst: number;
  mergeCount: number;
  volumeM3: number;
  massKg: number;
  centerM: Vector;
  energyJM2: number;
}

/** Triangles of one fragment toward one neighbor, or the outside. */
export interface RunRow {
  vertexFirst: number;
  vertexCount: number;
  isCrack: boolean;
}

/** Two fragments that touch; the second is -1 for the world. */
export interface BondRow {
  fragments: [number, number];
  areaM2: number;
  centroidM: Vector;
}

/** Convex proxy of a fragment. */
export interface HullRow {
  vertexFirst: number;
  vertexCount: number;
  indexFirst: number;
  indexCount: number;
}

const FRAGMENT_BYTES = 144;
const RUN_BYTES = 32;
const BOND_BYTES = 64;
const HULL_BYTES = 32;
const WORLD = 0xffffffff;

/** A binary message with its sections, which are views of its buffer. */
export class ResultMessage {
  readonly fragments: FragmentRow[];

  constructor(
    readonly head: ResultHead,
    private readonly buffer: ArrayBuffer,
    private readonly base: number,
  ) {
    this.fragments = this.rows("fragments", FRAGMENT_BYTES, (view, at) => ({
      id: view.getUint32(at, true),
      body: view.getUint32(at + 4, true),
      vertexFirst: view.getUint32(at + 8, true),
      vertexCount: view.getUint32(at + 12, true),
      indexFirst: view.getUint32(at + 16, true),
      indexCount: view.getUint32(at + 20, true),
      runFirst: view.getUint32(at + 24, true),
      runCount: view.getUint32(at + 28, true),
      mergeFirst: view.getUint32(at + 32, true),
      mergeCount: view.getUint32(at + 36, true),
      volumeM3: view.getFloat64(at + 48, true),
      massKg: view.getFloat64(at + 56, true),
      centerM: vector(view, at + 64),
      energyJM2: view.getFloat64(at + 136, true),
    }));
  }

  /** Bytes of the whole message. */
  get bytes(): number {
    return this.buffer.byteLength;
  }

  /** Whether the object stayed whole. */
  get isWhole(): boolean {
    return this.fragments.length === 0;
  }

  private part(name: string): { offset: number; bytes: number } {
    const row = this.head.sections.find((section) => section.name === name);
    return row ? { offset: this.base + row.offset, bytes: row.bytes } : { offset: this.base, bytes: 0 };
  }

  /** A section of 32-bit floats; empty if it is absent. */
  floats(name: string): Float32Array {
    const { offset, bytes } = this.part(name);
    return new Float32Array(this.buffer, offset, bytes / 4);
  }

  /** A section of 32-bit integers; empty if it is absent. */
  integers(name: string): Uint32Array {
    const { offset, bytes } = this.part(name);
    return new Uint32Array(this.buffer, offset, bytes / 4);
  }

  /** The bytes of a section; empty if it is absent. */
  raw(name: string): Uint8Array<ArrayBuffer> {
    const { offset, bytes } = this.part(name);
    return new Uint8Array(this.buffer, offset, bytes);
  }

  /** Runs of all fragments. */
  runs(): RunRow[] {
    return this.rows("runs", RUN_BYTES, (view, at) => ({
      vertexFirst: view.getUint32(at + 8, true),
      vertexCount: view.getUint32(at + 12, true),
      isCrack: view.getUint32(at + 24, true) !== 0,
    }));
  }

  /** Bonds; empty unless the effect is on. */
  bonds(): BondRow[] {
    return this.rows("bonds", BOND_BYTES, (view, at) => {
      const second = view.getUint32(at + 4, true);
      return {
        fragments: [view.getUint32(at, true), second === WORLD ? -1 : second],
        areaM2: view.getFloat64(at + 8, true),
        centroidM: vector(view, at + 40),
      };
    });
  }

  /** Hulls, one per fragment; empty unless the effect is on. */
  hulls(): HullRow[] {
    return this.rows("hulls", HULL_BYTES, (view, at) => ({
      vertexFirst: view.getUint32(at, true),
      vertexCount: view.getUint32(at + 4, true),
      indexFirst: view.getUint32(at + 8, true),
      indexCount: view.getUint32(at + 12, true),
    }));
  }

  private rows<T>(name: string, size: number, read: (view: DataView, at: number) => T): T[] {
    const { offset, bytes } = this.part(name);
    const view = new DataView(this.buffer);
    return Array.from({ length: bytes / size }, (_, row) => read(view, offset + row * size));
  }
}

function vector(view: DataView, at: number): Vector {
  return [view.getFloat64(at, true), view.getFloat64(at + 8, true), view.getFloat64(at + 16, true)];
}

/** Reads a binary message. */
export function decode(buffer: ArrayBuffer): ResultMessage {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length))) as ResultHead;
  return new ResultMessage(head, buffer, 4 + length);
}
