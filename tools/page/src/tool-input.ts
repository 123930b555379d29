// Input devices of the tool: mouse, pen, fingers and keys on the body's view.

import type { BodyView } from "./body";
import type { Poke } from "./poke";

export const kKeyStep = 0.05; // of the range, a key

export function listenForTool(view: BodyView, tool: Poke): void {
  const canvas = view.canvas;
  const held: (number | undefined)[] = []; // the pointer that holds each tool
  // Before the view's own listeners: a pointer that presses does not turn the body. One beside the
  // window does, and so does the right button.
  canvas.addEventListener(
    "pointerdown",
    (event) => {
      if (!tool.isPoking || event.button !== 0) return;
      const place = view.under(event.clientX, event.clientY);
      if (place) tool.note(place.isMeasured);
      const free = Array.from({ length: tool.fingers }, (_, i) => held[i]).indexOf(undefined);
      if (!place?.isMeasured || free < 0) return;
      view.setOrbit(false);
      canvas.setPointerCapture(event.pointerId);
      held[free] = event.pointerId;
      tool.press(place, free);
    },
    { capture: true },
  );
  canvas.addEventListener("pointermove", (event) => {
    const finger = held.indexOf(event.pointerId);
    if (finger < 0 && event.buttons === 0)
      canvas.classList.toggle("pressable", tool.isPoking && !!view.under(event.clientX, event.clientY)?.isMeasured);
    if (finger < 0) return;
    if (event.pointerType === "pen" && event.pressure > 0) tool.setDepth(event.pressure * tool.range_m);
    tool.drag(view.under(event.clientX, event.clientY), finger);
  });
  const end = (event: PointerEvent) => {
    const finger = held.indexOf(event.pointerId);
    if (finger < 0) return;
    held[finger] = undefined;
    tool.lift(finger);
    view.setOrbit(held.every((pointer) => pointer === undefined));
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
    if (event.key.toLowerCase() === "v" && !event.ctrlKey && !event.metaKey) tool.set(!tool.isPoking);
    if (!tool.isPoking || event.ctrlKey || event.metaKey || event.altKey) return;
    const arrow = (right: number, up: number) => (event.shiftKey ? tool.turnBy(-up, right, 0) : tool.moveBy(right, up));
    const keys: Record<string, () => void> = {
      " ": () => (tool.isPressed ? tool.lift() : tool.pressHere()),
      Escape: () => tool.lift(),
      ArrowLeft: () => arrow(-1, 0),
      ArrowRight: () => arrow(1, 0),
      ArrowUp: () => arrow(0, 1),
      ArrowDown: () => arrow(0, -1),
      q: () => tool.turnBy(0, 0, 1),
      e: () => tool.turnBy(0, 0, -1),
      PageDown: () => tool.setDepth(tool.depth_m + kKeyStep * tool.range_m),
      PageUp: () => tool.setDepth(tool.depth_m - kKeyStep * tool.range_m),
    };
    const act = keys[event.key] ?? keys[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    act();
  });
}
