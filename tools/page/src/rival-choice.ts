// The switch between the engine and other methods, and how far their forces are apart.

import { Vector3 } from "three";
import { choice, html } from "./dom";
import { Answer } from "./engine";
import type { FeltRival } from "./rivals";
import { ask } from "./terms";
import type { Batch } from "./worker";
import { quantity } from "./words";

export class RivalChoice {
  /** None where the page holds no other method. */
  readonly elements: HTMLElement[];
  /** What is felt in place of the engine. */
  chosen: FeltRival | undefined;
  private readonly select: HTMLSelectElement;
  private readonly line = html("p", { class: "small", id: "poke-difference", hidden: true });

  constructor(
    rivals: readonly FeltRival[],
    private readonly changed: (rival: FeltRival | undefined) => void,
  ) {
    const names = rivals.map(({ name }, i): [string, string] => [String(i), name]);
    const { element, select } = choice("Method", [["", "Palpate"], ...names], (value) => {
      this.choose(value ? rivals[Number(value)] : undefined);
    });
    select.id = "poke-rival";
    element.insertBefore(ask("method"), select);
    select.before(" ");
    this.select = select;
    this.elements = rivals.length ? [element, this.line] : [];
  }

  private choose(rival: FeltRival | undefined): void {
    this.chosen = rival;
    this.line.hidden = !rival;
    this.line.textContent = rival ? `${rival.settings}. Depth and contact stay Palpate's.` : "";
    this.changed(rival);
  }

  /** Other methods know the probe alone. */
  offer(isProbe: boolean): void {
    this.select.disabled = !isProbe;
    if (isProbe || !this.chosen) return;
    this.select.value = "";
    this.choose(undefined);
  }

  write(batch: Batch): void {
    if (!this.chosen || !batch.own_N) return;
    const own = new Vector3(...batch.own_N);
    const off_N = new Vector3().fromArray(batch.answer[0], Answer.force_N).sub(own).length();
    const share = own.length() > 0 ? ` (${((100 * off_N) / own.length()).toFixed(0)} %)` : "";
    this.line.textContent = `Palpate: ${quantity(own.length(), "N")}; this method is off by ${quantity(off_N, "N")}${share}.`;
  }
}
