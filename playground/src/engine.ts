// The simulator as WebAssembly: commands and answers are JSON in its memory.
import type { Command, Words } from './wire';

interface Exports {
  memory: WebAssembly.Memory;
  buffer(len: number): number;
  call(): number;
  answer(): number;
  message(): number;
  message_len(): number;
}

/** An error of the simulator in both languages: what is wrong with what was asked. */
export class Refused extends Error {
  constructor(readonly words: Words) {
    super(words.en);
  }
}

/** The simulator has failed and cannot be used any more. */
export class Failed extends Error {}

export class Engine {
  private constructor(private readonly exports: Exports) {}

  /** From the bytes: a file server need not know what a module is. */
  static async of(bytes: BufferSource): Promise<Engine> {
    const { instance } = await WebAssembly.instantiate(bytes, {});
    return new Engine(instance.exports as unknown as Exports);
  }

  /** The answer as it is: `{"ok": …}` or `{"error": …}`. */
  ask(command: unknown): string {
    const bytes = new TextEncoder().encode(JSON.stringify(command));
    const { exports } = this;
    try {
      const at = exports.buffer(bytes.length);
      if (at === 0) throw new Failed(`a command of ${bytes.length} bytes`);
      new Uint8Array(exports.memory.buffer).set(bytes, at);
      const length = exports.call();
      return this.text(exports.answer(), length);
    } catch (error) {
      throw new Failed(this.said() || String(error));
    }
  }

  call<T>(command: Command): T {
    const answer = JSON.parse(this.ask(command)) as { ok?: T; error?: Words };
    if (answer.error) throw new Refused(answer.error);
    return answer.ok as T;
  }

  private said(): string {
    try {
      return this.text(this.exports.message(), this.exports.message_len());
    } catch {
      return '';
    }
  }

  private text(at: number, length: number): string {
    return new TextDecoder().decode(new Uint8Array(this.exports.memory.buffer, at, length));
  }
}
