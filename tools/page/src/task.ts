// A task for who pokes a body with an inclusion: find it by touch alone, mark it, see it.

import { Box3, Vector3 } from "three";
import type { BodyView } from "./body";
import { type Contents, floats } from "./contents";
import { button, html } from "./dom";
import type { Place } from "./surface";
import { millimetres } from "./words";

interface Lump {
  centre: Vector3;
  radius_m: number;
  isStiff: boolean;
}

/** The inclusions of the scene, each as the ball about as large. */
function lumpsOf(contents: Contents): Lump[] {
  return (contents.set_up?.inclusions ?? []).flatMap((inclusion): Lump[] => {
    const { center_m, radius_m, low_m, high_m, vertices_m, is_stiffer: isStiff } = inclusion;
    if (center_m && radius_m) return [{ centre: new Vector3().fromArray(center_m), radius_m, isStiff }];
    const corners = low_m && high_m ? [...low_m, ...high_m] : floats(vertices_m);
    if (!corners.length) return [];
    const box = new Box3().setFromArray(corners);
    const { x, y, z } = box.getSize(new Vector3());
    return [{ centre: box.getCenter(new Vector3()), radius_m: (x + y + z) / 6, isStiff }];
  });
}

/** Distance at which a finger that presses straight in passes the middle of a lump. */
function passes_m({ position, outward }: Place, lump: Lump): number {
  const to = lump.centre.clone().sub(position);
  return to.addScaledVector(outward, -to.dot(outward)).length();
}

export class Task {
  readonly element: HTMLElement;
  private readonly lumps: Lump[];
  private readonly message = html("p", { id: "task-said", role: "status" });
  private began_ms: number | undefined;
  private deepest_m = 0;
  private result: { place: Place; seconds: number; deepest_m: number } | undefined;

  /** place: where the tool presses or pressed. reveal: shows the inclusions, or hides them and the map. */
  constructor(
    contents: Contents,
    private readonly view: BodyView,
    private readonly place: () => Place | undefined,
    private readonly reveal: (isShown: boolean) => void,
  ) {
    this.lumps = lumpsOf(contents);
    this.element = html(
      "div",
      { class: "task", id: "task" },
      this.message,
      button("task-mark", "Mark here", () => this.mark()),
      button("task-reveal", "Reveal", () => this.end()),
      button("task-again", "Start again", () => this.begin()),
    );
    this.ask();
  }

  /** Nothing is hidden in a body without inclusions. */
  static of(...parameters: ConstructorParameters<typeof Task>): Task | undefined {
    return lumpsOf(parameters[0]).length ? new Task(...parameters) : undefined;
  }

  private ask(): void {
    const thing = this.lumps.every(({ isStiff }) => isStiff) ? "tumour, stiffer than what is around it," : "lump";
    this.message.textContent = `A ${thing} is hidden under the window. Find it: press, feel where the force grows, mark the place.`;
  }

  private begin(): void {
    this.began_ms = undefined;
    this.result = undefined;
    this.deepest_m = 0;
    this.view.select(undefined);
    this.reveal(false);
    this.ask();
  }

  /** Records a depth of the tool; time runs from the first touch on. */
  record(depth_m: number): void {
    if (this.result || !(depth_m > 0)) return;
    this.began_ms ??= performance.now();
    this.deepest_m = Math.max(this.deepest_m, depth_m);
  }

  private mark(): void {
    const place = this.place();
    if (!place || this.began_ms === undefined) {
      this.message.textContent = "Press somewhere first: the mark is where the tool is, or was last.";
      return;
    }
    const seconds = (performance.now() - this.began_ms) / 1e3;
    this.result = { place, seconds, deepest_m: this.deepest_m };
    this.view.select(place.position.toArray());
    this.message.textContent = `Marked after ${seconds.toFixed(0)} s. Reveal shows whether it is there.`;
  }

  private end(): void {
    this.reveal(true);
    if (!this.result) {
      this.message.textContent = "There it is. Start again hides it.";
      return;
    }
    const { place, seconds, deepest_m } = this.result;
    const nearest = this.lumps
      .map((lump) => ({ by_m: passes_m(place, lump), lump }))
      .sort((a, b) => a.by_m - a.lump.radius_m - (b.by_m - b.lump.radius_m))[0];
    const isFound = nearest.by_m <= nearest.lump.radius_m;
    this.message.textContent =
      `${isFound ? "Found" : "Missed"}: your mark is ${millimetres(nearest.by_m)} beside its middle, its radius is ` +
      `${millimetres(nearest.lump.radius_m)}. It took ${seconds.toFixed(0)} s; the deepest press was ${millimetres(deepest_m)}.`;
  }
}
