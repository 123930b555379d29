// The engine's WebAssembly behind plain calls: engine.cpp has the other side.

interface Exports {
  memory: WebAssembly.Memory;
  reserve(bytes: number): number;
  open(address: number, size: number): number;
  body_bytes(): number;
  embody(address: number): number;
  heal(): number;
  sentence(status: number): number;
  start(interpolates: number): number;
  tick(x: number, y: number, z: number, dt_s: number): number;
  answer(): number;
  vertices(): number;
  deform(address: number, count: number): number;
}

/** Where each number of a tick's answer stands; forces act on the tool. */
export const Answer = {
  force_N: 0,
  contact_m: 3,
  normal: 6,
  normal_m: 9,
  lateral_m: 10,
  stored_J: 11,
  dissipated_J: 12,
  state: 13,
  triangle: 14,
  flags: 15,
  size: 16,
} as const;

/** PALPATE_FLAG_CHANNEL: the tool is in a hole. */
export const kInChannel = 2048;
/** PALPATE_FLAG_PUNCTURED: at this tick it made one. */
export const kPunctured = 4096;

export class Engine {
  /** Of its displacements in the engine's memory; 0 where the asset does not say how its surface moves. */
  private displacement = 0;
  private numbers = 0;
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

  /** One sentence on a status. */
  sentence(status: number): string {
    const bytes = new Uint8Array(this.wasm.memory.buffer, this.wasm.sentence(status));
    return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
  }

  /** Ends contact and sets all sums to zero. Without interpolation each facet has one curve and its own normal. */
  start(interpolates = true): void {
    this.wasm.start(interpolates ? 1 : 0);
  }

  /** The body is as it was before any touch. */
  heal(): void {
    this.wasm.heal();
  }

  /** One tick with the tip at a place [m] a millisecond after the one before; returns the status, 0 for good. */
  tick(x: number, y: number, z: number): number {
    return this.wasm.tick(x, y, z, 1e-3);
  }

  /** Whether the engine knows how the surface moves. */
  get deforms(): boolean {
    return this.displacement !== 0;
  }

  /** How far the tool has moved each vertex [m], three numbers each; a view that the next call writes anew. */
  deform(): Float32Array {
    this.wasm.deform(this.displacement, this.numbers / 3);
    return new Float32Array(this.wasm.memory.buffer, this.displacement, this.numbers);
  }

  /** The latest tick's numbers; a view that the next tick writes anew. */
  answer(): Float64Array {
    return new Float64Array(this.wasm.memory.buffer, this.wasm.answer(), Answer.size);
  }

  /** Forces on the tool [N], three a tick, along places [m], three a tick, from a fresh start. */
  replay(path: Float64Array, interpolates = true): Float64Array {
    this.start(interpolates);
    const forces = new Float64Array(path.length);
    const answer = this.answer();
    for (let i = 0; i + 2 < path.length; i += 3) {
      this.tick(path[i], path[i + 1], path[i + 2]);
      forces.set(answer.subarray(0, 3), i);
    }
    return forces;
  }
}
