// A gamepad is the tool, too (W3C, Gamepad, "standard" mapping): left stick moves it, right trigger
// sets the depth and presses, right stick turns the body, the lowest right button (A) presses and lifts.

import type { BodyView } from "./body";
import type { Poke } from "./poke";

const kDead = 0.15; // of a stick's travel: sticks do not come back to zero
const kTouch = 0.05; // of the trigger's travel, from which it presses
const kSpeed = 0.8; // of the range a second, the stick at its end
const kTurn = 1.5; // rad a second

function stick(x = 0, y = 0): [number, number] {
  const size = Math.hypot(x, y);
  const share = size > kDead ? Math.min((size - kDead) / (1 - kDead), 1) / size : 0;
  return [x * share, y * share];
}

/** Asks the gamepads before each frame while one is connected. announce: shows a sentence on its controls. */
export function listenForGamepad(view: BodyView, tool: Poke, announce: (sentence: string) => void): void {
  let isPolling = false;
  let before_ms = 0;
  let isTriggered = false;
  let wasDown = false;
  const poll = (now: number) => {
    const pad = navigator.getGamepads().find((p) => p?.connected);
    isPolling = pad !== undefined && pad !== null;
    if (!pad) return;
    requestAnimationFrame(poll);
    const seconds = Math.min((now - before_ms) / 1e3, 0.1);
    before_ms = now;
    const [left, up] = stick(pad.axes[0], pad.axes[1]);
    const [aside, down] = stick(pad.axes[2], pad.axes[3]);
    if (aside || down) view.turn(-aside * kTurn * seconds, down * kTurn * seconds);
    if (left || up) tool.moveBy(left, -up, Math.hypot(left, up) * kSpeed * seconds);
    const depth = pad.buttons[7]?.value ?? 0;
    if (depth > kTouch) {
      tool.setDepth(depth * tool.range_m);
      if (!tool.isPressed) tool.pressHere();
      isTriggered = true;
    } else if (isTriggered) {
      tool.lift();
      isTriggered = false;
    }
    const isDown = pad.buttons[0]?.pressed ?? false;
    if (isDown && !wasDown) {
      if (tool.isPressed) tool.lift();
      else tool.pressHere();
    }
    wasDown = isDown;
  };
  addEventListener("gamepadconnected", () => {
    announce(
      "Gamepad: left stick moves the tool, right trigger presses, right stick turns the body, A presses and lifts.",
    );
    if (isPolling) return;
    isPolling = true;
    before_ms = performance.now();
    requestAnimationFrame(poll);
  });
}
