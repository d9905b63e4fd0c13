// Layers of three.js: what both kinds of frames draw is in layer 0.

/** What frames with all details draw. */
export const DETAILED = 1;

/** What fast frames draw in its place. */
export const FAST = 2;
