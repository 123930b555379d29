// The latest touch, tick by tick: poses of the tools and forces on them.

import { kPose } from "./engine";

const kRecorded = 600e3; // ticks; ten minutes
const kPart = 4096; // ticks that room is made for at a time
const kRow = 10; // numbers of a tool at a tick: its pose and its force

export class Recording {
  ticks = 0;
  private readonly parts: Float64Array[] = [];
  /** Tools that came down, up to this one; others are left out of the table. */
  private used = 1;

  constructor(private readonly tools: number) {}

  use(tool: number): void {
    this.used = Math.max(this.used, tool + 1);
  }

  /** places [m] and forces [N] are a row a tool; turn: w, x, y, z of all. */
  add(places: number[][], turn: number[], forces: number[][]): void {
    if (this.ticks === kRecorded) return;
    const size = kRow * this.tools;
    const at = this.ticks++ % kPart;
    if (at === 0) this.parts.push(new Float64Array(kPart * size));
    const part = this.parts[this.parts.length - 1];
    places.forEach((place, k) => {
      part.set([...place, ...turn, ...forces[k]], at * size + k * kRow);
    });
  }

  private row(tick: number, tool: number): Float64Array {
    const at = ((tick % kPart) * this.tools + tool) * kRow;
    return this.parts[Math.floor(tick / kPart)].subarray(at, at + kRow);
  }

  /** As `palpate replay` takes a path, with the forces beside it. */
  table(rate_Hz: number): string {
    const turns =
      this.ticks > 0 && Array.from({ length: this.ticks }, (_, i) => this.row(i, 0)[3]).some((w) => w !== 1);
    const several = this.used > 1;
    const header = ["t_s,x_m,y_m,z_m", turns ? "qw,qx,qy,qz" : "", several ? "tool" : "", "fx_N,fy_N,fz_N"];
    const lines = [header.filter((part) => part).join(",")];
    for (let i = 0; i < this.ticks; ++i)
      for (let k = 0; k < this.used; ++k) {
        const row = this.row(i, k);
        const pose = row.subarray(0, turns ? kPose : 3);
        lines.push([i / rate_Hz, ...pose, ...(several ? [k] : []), ...row.subarray(kPose)].join(","));
      }
    return `${lines.join("\n")}\n`;
  }
}
