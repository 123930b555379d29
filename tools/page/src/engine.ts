// The engine's WebAssembly behind plain calls: engine.cpp has the other side.

interface Exports {
  memory: WebAssembly.Memory;
  reserve(bytes: number): number;
  open(address: number, size: number): number;
  body_bytes(): number;
  embody(address: number): number;
  heal(): number;
  sentence(status: number): number;
  couples(): number;
  shape(): number;
  profile(): number;
  question(): number;
  answer(): number;
  start(tool: number, balls: number): number;
  tick(count: number, dt_s: number): number;
  vertices(): number;
  deform(address: number, count: number): number;
}

/** Offsets of the numbers of a tool's answer; forces act on the tool. */
export const Answer = {
  force_N: 0,
  contact_m: 3,
  normal: 6,
  normal_m: 9,
  lateral_m: 10,
  stored_J: 11,
  dissipated_J: 12,
  state: 13,
  flags: 14,
  torque_Nm: 15,
  touching: 18,
  size: 19,
} as const;

/** Ticks a second. */
export const kRate_Hz = 1000;
/** Balls of all tools together, as palpate.h has it. */
export const kMaxBalls = 8;

/** Points of a profile at most, as palpate.h has it. */
const kMaxProfile = 48;

/** End of a tool that is no ball: the slope of its surface over the distance from its axis. */
export interface Profile {
  r_m: readonly number[];
  slope: readonly number[];
}
/** Balls fixed to each other: where each is in the tool's own axes, and its radius; one of radius 0 is a tip. */
export interface Ball {
  centre_m: readonly [number, number, number];
  radius_m: number;
  profile?: Profile;
}
export const kTip: readonly Ball[] = [{ centre_m: [0, 0, 0], radius_m: 0 }];

export class Engine {
  /** Address of the displacements; 0 where the asset does not say how its surface moves. */
  private displacement = 0;
  private numbers = 0;
  private tools: (readonly Ball[])[] = [kTip];
  /** Contacts damage the body: it remembers them until it is healed. */
  remembers = false;

  private constructor(private readonly wasm: Exports) {}

  /** Throws an Error with the engine's sentence where it refuses the asset. */
  static async open(module: BufferSource, asset: Uint8Array): Promise<Engine> {
    const { instance } = await WebAssembly.instantiate(module, {});
    const wasm = instance.exports as unknown as Exports;
    const address = wasm.reserve(asset.length);
    if (address === 0) throw new Error("There is not enough memory for the asset.");
    new Uint8Array(wasm.memory.buffer, address, asset.length).set(asset);
    const engine = new Engine(wasm);
    const status = wasm.open(address, asset.length);
    if (status !== 0) throw new Error(engine.sentence(status));
    engine.numbers = 3 * wasm.vertices();
    if (engine.numbers > 0) engine.displacement = wasm.reserve(4 * engine.numbers);
    const bytes = wasm.body_bytes();
    if (bytes > 0) {
      const room = wasm.reserve(bytes);
      if (room === 0) throw new Error("There is not enough memory for the body.");
      wasm.embody(room);
      engine.remembers = true;
    }
    engine.start();
    return engine;
  }

  private doubles(address: number, count: number): Float64Array {
    return new Float64Array(this.wasm.memory.buffer, address, count);
  }

  /** One sentence on a status. */
  sentence(status: number): string {
    const bytes = new Uint8Array(this.wasm.memory.buffer, this.wasm.sentence(status));
    return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
  }

  /** A tool may have several balls, and tools interact. */
  get couples(): boolean {
    return this.wasm.couples() !== 0;
  }

  /** Sets the tools that are ticked together, in this order, from the next start on; kMaxBalls balls at most. */
  take(tools: (readonly Ball[])[]): void {
    this.tools = tools;
  }

  /** Ends contact and sets all sums to zero. */
  start(): void {
    this.tools.forEach((balls, tool) => {
      const shape = this.doubles(this.wasm.shape(), 4 * balls.length);
      balls.forEach((ball, i) => {
        shape.set([...ball.centre_m, ball.radius_m], 4 * i);
        const size = 1 + 2 * kMaxProfile;
        const profile = this.doubles(this.wasm.profile() + 8 * size * i, size);
        profile[0] = ball.profile?.r_m.length ?? 0;
        profile.set(ball.profile?.r_m ?? [], 1);
        profile.set(ball.profile?.slope ?? [], 1 + kMaxProfile);
      });
      const status = this.wasm.start(tool, balls.length);
      if (status !== 0) throw new Error(this.sentence(status));
    });
  }

  /** The body is as it was before any touch. */
  heal(): void {
    this.wasm.heal();
  }

  /** One tick with each tool in its pose, x, y, z [m] and the quaternion w, x, y, z, a millisecond after the one before; returns the status, 0 for good. */
  tick(poses: ArrayLike<number>): number {
    this.doubles(this.wasm.question(), poses.length).set(poses);
    return this.wasm.tick(this.tools.length, 1 / kRate_Hz);
  }

  get deforms(): boolean {
    return this.displacement !== 0;
  }

  /** Displacements of the vertices under the tools [m], three numbers each; a view that the next call writes anew. */
  deform(): Float32Array {
    this.wasm.deform(this.displacement, this.numbers / 3);
    return new Float32Array(this.wasm.memory.buffer, this.displacement, this.numbers);
  }

  /** The latest tick's numbers, Answer.size of each tool; a view that the next tick writes anew. */
  answer(): Float64Array {
    return this.doubles(this.wasm.answer(), Answer.size * this.tools.length);
  }
}
