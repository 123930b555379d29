// Force as sound: a step of the force is a click, as a hand senses it; a smooth touch is next to
// silent.

import { checkbox, html } from "./dom";
import type { Batch } from "./worker";
import { quantity } from "./words";

const kTicks_Hz = 1000;
const kFullShare = 0.05; // of the largest force of the curves: a step as loud as it gets
const kAhead_s = 0.04; // of what is heard, so that batches follow without gaps

/** Force, high-passed and resampled, batch after batch. */
export class ForceSignal {
  private before: [number, number] | undefined; // the last force and the one before it
  private last = 0;
  private at = 0; // of the next sample, in ticks behind the last one

  /** full_N: a step that reaches 1; rate_Hz: of the samples. */
  constructor(
    private readonly full_N: number,
    private readonly rate_Hz: number,
  ) {}

  /** Second differences: a step keeps its height, 10 Hz, as hands move, a 250th. */
  private highPass(force_N: number): number {
    const [a, b] = this.before ?? [force_N, force_N];
    this.before = [force_N, a];
    return Math.min(Math.max((force_N - 2 * a + b) / this.full_N, -1), 1);
  }

  /** Samples from -1 to 1 of a batch's ticks, straight from each to the next. */
  samples(batch: Pick<Batch, "pressing_N" | "sliding_N">): Float32Array<ArrayBuffer> {
    const out: number[] = [];
    batch.pressing_N.forEach((pressing, i) => {
      const next = this.highPass(pressing + batch.sliding_N[i]);
      for (; this.at < 1; this.at += kTicks_Hz / this.rate_Hz) out.push(this.last + this.at * (next - this.last));
      this.at -= 1;
      this.last = next;
    });
    return Float32Array.from(out);
  }
}

/** The switch, and what plays while it is on. */
export class ForceSound {
  readonly element: HTMLElement;
  private context: AudioContext | undefined;
  private signal: ForceSignal | undefined;
  private next_s = 0;

  constructor(private readonly fullForce_N: number) {
    const box = checkbox("poke-sound", false, () => this.set(box.checked));
    this.element = html(
      "label",
      {},
      box,
      ` sound (a step of ${quantity(kFullShare * fullForce_N, "N", 2)} is as loud as it gets)`,
    );
  }

  private set(isOn: boolean): void {
    if (!isOn) {
      this.context?.close();
      this.context = undefined;
      return;
    }
    this.context = new AudioContext();
    this.signal = new ForceSignal(kFullShare * this.fullForce_N, this.context.sampleRate);
    this.next_s = 0;
  }

  play(batch: Batch): void {
    if (!this.context || !this.signal) return;
    const samples = this.signal.samples(batch);
    if (samples.length === 0) return;
    const buffer = this.context.createBuffer(1, samples.length, this.context.sampleRate);
    buffer.copyToChannel(samples, 0);
    const source = this.context.createBufferSource();
    source.buffer = buffer;
    source.connect(this.context.destination);
    this.next_s = Math.max(this.next_s, this.context.currentTime + kAhead_s);
    source.start(this.next_s);
    this.next_s += buffer.duration;
  }
}
