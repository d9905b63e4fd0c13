// States of the object, for back and forward: results are kept in the page, up to a limit.

import type { Aim } from "./object_facts";
import type { Pieces } from "./pieces";
import type { ResultMessage } from "./result";
import type { ImpactRequest } from "./impact_request";

/** Pieces of one result; some of them may have been struck again, and are shown by another layer. */
export interface Layer {
  pieces: Pieces;
  /** The request that made them; `undefined`: the object as it was. */
  request: ImpactRequest | undefined;
  /** Pieces that later layers replace. */
  replaced: Set<number>;
}

/** A request and its result, with what was struck. */
export interface Answer {
  request: ImpactRequest;
  result: ResultMessage;
  /** Time from the request to the drawn picture, ms; 0 if it is unknown. */
  pictureMs: number;
  /** Layers before the request; one of them holds the struck fragment. */
  before: Layer[];
  struck: Layer;
  fragment: number;
  /** What was struck, with its threshold; `undefined` in a recording. */
  aim?: Aim;
}

/** One state. */
export interface State {
  layers: Layer[];
  /** The request that led to the state. */
  last: Answer | undefined;
}

/** The impulse of a request, as a multiple of the one that just breaks. */
export function multipleOf({ request, result, aim }: Answer): number {
  return aim?.thresholdNs === undefined ? 1 / result.head.threshold_factor : request.impulseNs / aim.thresholdNs;
}

/** Number of pieces that are shown. */
export function countShown(layers: Layer[]): number {
  return layers.reduce((sum, layer) => sum + layer.pieces.result.fragments.length - layer.replaced.size, 0);
}

/** Layers after a request: `made` replaces the struck fragment. Without `made` it stays whole. */
export function layersAfter(answer: Pick<Answer, "before" | "struck" | "fragment">, made: Layer | undefined): Layer[] {
  const { before, struck, fragment } = answer;
  if (!made) return before;
  const replaced = new Set(struck.replaced).add(fragment);
  // The result of a request on the object itself holds all its bodies.
  const isAll = !struck.request || replaced.size === struck.pieces.result.fragments.length;
  const rest = before.flatMap((layer) => (layer.pieces !== struck.pieces ? [layer] : isAll ? [] : [{ ...layer, replaced }]));
  return [...rest, made];
}

/** Most states that are kept, and most bytes of their results. */
const STATES_MAX = 24;
const BYTES_MAX = 384 << 20;

/** The states, the oldest first. */
export class History {
  private states: State[] = [];
  private at = -1;

  /** The state that is shown. */
  get now(): State | undefined {
    return this.states[this.at];
  }

  get canGoBack(): boolean {
    return this.at > 0;
  }

  get canGoForward(): boolean {
    return this.at + 1 < this.states.length;
  }

  /** Number of states that are kept. */
  get count(): number {
    return this.states.length;
  }

  /** The result of the whole object. */
  get intact(): ResultMessage | undefined {
    return this.states[0]?.layers[0]?.pieces.result;
  }

  /** The latest state of which `holds` is true. */
  latest(holds: (state: State) => boolean): State | undefined {
    return this.states.findLast(holds);
  }

  /** Adds a state at the end, and moves to it. */
  append(state: State): void {
    this.states.push(state);
    this.at = this.states.length - 1;
  }

  /** Adds a state after the present one; later ones are forgotten. */
  push(state: State): void {
    this.states.splice(this.at + 1);
    this.states.push(state);
    this.at++;
    // The first state is the whole object: it stays.
    while (this.states.length > 2 && (this.states.length > STATES_MAX || this.bytes() > BYTES_MAX)) {
      this.states.splice(1, 1);
      this.at--;
    }
  }

  /** Replaces the present state. */
  replace(state: State): void {
    this.states[this.at] = state;
  }

  /** Moves by so many states, if there are any. */
  move(by: number): boolean {
    const next = this.at + by;
    if (next < 0 || next >= this.states.length) return false;
    this.at = next;
    return true;
  }

  /** Moves to the whole object. */
  first(): boolean {
    return this.move(-this.at);
  }

  /** Forgets everything. */
  clear(): void {
    this.states = [];
    this.at = -1;
  }

  /** All pieces of all states, each once. */
  pieces(): Set<Pieces> {
    const layers = this.states.flatMap((state) => [...state.layers, ...(state.last?.before ?? [])]);
    return new Set(layers.map((layer) => layer.pieces));
  }

  private bytes(): number {
    let sum = 0;
    for (const pieces of this.pieces()) sum += pieces.result.bytes;
    return sum;
  }
}
