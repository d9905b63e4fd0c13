// Keys of the page.

import type { App } from "./app";
import { element } from "./dom";

/** Step of the arrow keys, radians. */
const STEP = 0.12;

/** What keys can do beyond the app itself. */
export interface KeyActions {
  strikeCenter(): void;
  fold(): void;
  strengthen(by: number): void;
  nextColor(): void;
}

function toggle(id: string): void {
  element(id).click();
}

/** Binds the keys. Controls that take text keep theirs. */
export function bindKeys(app: App, actions: KeyActions): void {
  const keys: Record<string, () => void> = {
    ArrowLeft: () => app.stage.orbit(-STEP, 0),
    ArrowRight: () => app.stage.orbit(STEP, 0),
    ArrowUp: () => app.stage.orbit(0, -STEP),
    ArrowDown: () => app.stage.orbit(0, STEP),
    "+": () => app.stage.orbit(0, 0, 0.9),
    "=": () => app.stage.orbit(0, 0, 0.9),
    "-": () => app.stage.orbit(0, 0, 1.1),
    Enter: actions.strikeCenter,
    "[": () => actions.strengthen(1 / 1.25),
    "]": () => actions.strengthen(1.25),
    b: () => app.go(-1),
    n: () => app.go(1),
    r: () => app.go(-Infinity),
    e: () => app.moveApart(app.explode() > 0.05 ? 0 : 0.5),
    c: actions.nextColor,
    x: () => toggle("xray"),
    h: () => toggle("hulls"),
    k: () => toggle("cracks"),
    p: actions.fold,
    "?": () => element<HTMLDialogElement>("keys").showModal(),
  };
  document.addEventListener("keydown", (event) => {
    const target = event.target as HTMLElement;
    const isControl = ["INPUT", "SELECT", "TEXTAREA", "BUTTON", "SUMMARY"].includes(target.tagName);
    const isLetter = event.key.length === 1 && target.tagName !== "INPUT" && target.tagName !== "SELECT";
    if ((isControl && !isLetter) || event.ctrlKey || event.metaKey || event.altKey) return;
    const action = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action) return;
    event.preventDefault();
    action();
  });
}
