// How much is drawn while something moves: adapted to the time between frames.

/** Longest time between two frames that is aimed at, ms. */
const FRAME_MS = 60;

/** Least share of the resolution. */
const SCALE_MIN = 0.5;

/** Pause after the last movement before a frame with all details, ms; at least two frames, so that slow ones do not end a movement. */
const REST_MS = 240;
const REST_MAX_MS = 1500;

/** Names of renderers that draw without a graphics processor. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/** Whether the browser draws without a graphics processor. */
export function isSoftwareRenderer(): boolean {
  const context = document.createElement("canvas").getContext("webgl2");
  if (!context) return false;
  const extension = context.getExtension("WEBGL_debug_renderer_info");
  const name = String(context.getParameter(extension?.UNMASKED_RENDERER_WEBGL ?? context.RENDERER));
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return SOFTWARE.test(name);
}

/** Detail of the frames of a movement. */
export class Pace {
  /** Share of the resolution. */
  scale = 1;
  /** Time between the last two frames of a movement, ms. */
  private frameMs = 0;
  /** Time at which the last frame of a movement began, ms; `undefined` at rest. */
  private last: number | undefined;

  /** `isFast`: whether pieces have the fast look; a slow frame turns it on for good. */
  constructor(public isFast: boolean) {}

  /** Notes a frame that begins: the browser draws after `render` returns, and asks for frames as it gets on. */
  frame(now: number): void {
    if (this.last !== undefined) {
      this.frameMs = now - this.last;
      const isSlow = this.frameMs > FRAME_MS;
      if (isSlow && !this.isFast) this.isFast = true;
      else this.scale = Math.min(1, Math.max(SCALE_MIN, this.scale * (isSlow ? 0.8 : 1.05)));
    }
    this.last = now;
  }

  /** Notes that nothing moves. */
  rest(): void {
    this.last = undefined;
  }

  /** Pause after the last movement before a frame with all details, ms. */
  restMs(): number {
    return Math.min(REST_MAX_MS, Math.max(REST_MS, 2 * this.frameMs));
  }
}
