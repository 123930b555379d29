// What hands do with the tool: mouse, pen, fingers and keys on the body's view.

import type { BodyView } from "./body";
import type { Place } from "./surface";

export const kKeyStep = 0.05; // of the range, a key

/** What they do it to. */
export interface Tool {
  readonly isPoking: boolean;
  readonly isPressed: boolean;
  readonly range_m: number;
  readonly depth_m: number;
  press(place: Place): void;
  pressHere(): void;
  drag(place: Place | undefined): void;
  lift(): void;
  setDepth(depth_m: number): void;
  /** Along the surface, as the screen has right and up, by a share of the range; not given: a key's. */
  moveBy(right: number, up: number, share?: number): void;
}

export function listenForTool(view: BodyView, tool: Tool): void {
  const canvas = view.canvas;
  let second: { id: number; y: number; depth: number } | undefined;
  let held: number | undefined;
  // Before the view's own listeners: a pointer that presses does not turn the body.
  canvas.addEventListener(
    "pointerdown",
    (event) => {
      if (!tool.isPoking || event.button !== 0) return;
      if (held !== undefined) {
        second = { id: event.pointerId, y: event.clientY, depth: tool.depth_m };
        return;
      }
      const place = view.under(event.clientX, event.clientY);
      if (!place) return;
      view.setOrbit(false);
      canvas.setPointerCapture(event.pointerId);
      held = event.pointerId;
      tool.press(place);
    },
    { capture: true },
  );
  canvas.addEventListener("pointermove", (event) => {
    if (second?.id === event.pointerId) {
      tool.setDepth(second.depth + ((event.clientY - second.y) / 150) * tool.range_m);
      return;
    }
    if (event.pointerId !== held) return;
    if (event.pointerType === "pen" && event.pressure > 0) tool.setDepth(event.pressure * tool.range_m);
    tool.drag(view.under(event.clientX, event.clientY));
  });
  const end = (event: PointerEvent) => {
    if (second?.id === event.pointerId) second = undefined;
    if (event.pointerId !== held) return;
    held = undefined;
    tool.lift();
    view.setOrbit(true);
  };
  canvas.addEventListener("pointerup", end);
  canvas.addEventListener("pointercancel", end);
  canvas.addEventListener(
    "wheel",
    (event) => {
      if (!tool.isPressed) return;
      event.preventDefault();
      event.stopImmediatePropagation();
      tool.setDepth(tool.depth_m - Math.sign(event.deltaY) * 0.03 * tool.range_m);
    },
    { capture: true, passive: false },
  );
  canvas.addEventListener("keydown", (event) => {
    if (!tool.isPoking || event.ctrlKey || event.metaKey || event.altKey) return;
    const keys: Record<string, () => void> = {
      " ": () => (tool.isPressed ? tool.lift() : tool.pressHere()),
      Escape: () => tool.lift(),
      ArrowLeft: () => tool.moveBy(-1, 0),
      ArrowRight: () => tool.moveBy(1, 0),
      ArrowUp: () => tool.moveBy(0, 1),
      ArrowDown: () => tool.moveBy(0, -1),
      PageDown: () => tool.setDepth(tool.depth_m + kKeyStep * tool.range_m),
      PageUp: () => tool.setDepth(tool.depth_m - kKeyStep * tool.range_m),
    };
    const act = keys[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  });
}
