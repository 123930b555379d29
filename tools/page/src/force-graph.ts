// Normal and lateral force over the latest ticks.

import { seriesColour } from "./colours";
import { html } from "./dom";
import { quantity } from "./words";

const kShown = 4000; // ticks: four seconds

export class ForceGraph {
  readonly canvas = html("canvas", {
    class: "graph",
    role: "img",
    "aria-label": "Force over the last four seconds",
  });
  private readonly pressing = new Float32Array(kShown);
  private readonly sliding = new Float32Array(kShown);
  private ticks = 0;

  /** least_N: what the graph's height stands for at least. */
  constructor(private readonly least_N: number) {}

  /** Adds the forces of ticks; draw() shows them. */
  add(pressing_N: Float32Array, sliding_N: Float32Array): void {
    pressing_N.forEach((force, i) => {
      this.pressing[this.ticks % kShown] = force;
      this.sliding[this.ticks % kShown] = sliding_N[i];
      ++this.ticks;
    });
  }

  draw(): void {
    const ratio = Math.min(devicePixelRatio, 2);
    const { clientWidth, clientHeight } = this.canvas;
    if (this.canvas.width !== Math.round(clientWidth * ratio)) {
      this.canvas.width = Math.round(clientWidth * ratio);
      this.canvas.height = Math.round(clientHeight * ratio);
    }
    const context = this.canvas.getContext("2d");
    if (!context) return;
    const { width, height } = this.canvas;
    const style = getComputedStyle(this.canvas);
    const most = Math.max(...this.pressing, ...this.sliding, this.least_N) * 1.2;
    context.clearRect(0, 0, width, height);
    context.lineWidth = 1.5 * ratio;
    for (const [k, values] of [this.pressing, this.sliding].entries()) {
      this.canvas.style.color = seriesColour(k);
      context.strokeStyle = style.color;
      context.beginPath();
      for (let t = Math.max(0, this.ticks - kShown); t < this.ticks; ++t) {
        const x = ((t - this.ticks + kShown) / kShown) * width;
        context.lineTo(x, height - 2 - (values[t % kShown] / most) * (height - 4));
      }
      context.stroke();
    }
    this.canvas.style.color = "";
    context.fillStyle = style.color;
    context.font = `${11 * ratio}px sans-serif`;
    context.fillText(quantity(most, "N", 2), 3 * ratio, 11 * ratio);
  }
}
