// The simulator in its worker, as the page sees it.
import type { FromWorker, ToWorker } from './messages';
import type { Anatomy, Command, Description, Entry, View, Words } from './wire';

/** What was refused, in both languages. */
export class Refusal extends Error {
  constructor(readonly words: Words) {
    super(words.en);
  }
}

interface Waiting {
  done(answer: unknown): void;
  refused(error: Error): void;
}

export class Session extends EventTarget {
  view: View | null = null;
  entries: Entry[] = [];
  description: Description | null = null;
  speed = 0;
  /** Why the simulator has stopped working. */
  failure: string | null = null;

  private worker: Worker | null = null;
  private readonly waiting = new Map<number, Waiting>();
  private last = 0;

  /** Starts the simulator, again if it has failed; resolves when it answers. */
  async begin(): Promise<void> {
    this.worker?.terminate();
    for (const one of this.waiting.values()) one.refused(new Error('ended'));
    this.waiting.clear();
    this.failure = null;
    await new Promise<void>((ready) => {
      this.worker = new Worker(new URL('./worker.ts', import.meta.url), { type: 'module' });
      this.worker.onmessage = ({ data }: MessageEvent<FromWorker>) => {
        this.hear(data);
        if (data.kind === 'ready' || data.kind === 'failed') ready();
      };
      this.worker.onerror = (event) => {
        this.hear({ kind: 'failed', why: event.message || 'worker' });
        ready();
      };
    });
    this.description = await this.ask<Description>({ op: 'describe' });
  }

  async start(seed: number, profile: string, wind: [number, number]): Promise<void> {
    this.take(await this.ask<View>({ op: 'start', seed, profile, wind }), true);
  }

  async open(fragment: string): Promise<void> {
    this.take(await this.ask<View>({ op: 'open', fragment }), true);
  }

  /** Does something; the numbers of its entries. */
  async act(act: Extract<Command, { op: 'act' }>['act']): Promise<number[]> {
    const view = await this.ask<View>({ op: 'act', act });
    this.take(view, false);
    return view.entries.map((entry) => entry.index);
  }

  read(bytes: boolean, text: string): Promise<Anatomy> {
    return this.ask<Anatomy>({ op: 'read', input: { bytes, text } });
  }

  share(): Promise<string> {
    return this.ask<string>({ op: 'share' });
  }

  pace(speed: number): void {
    this.speed = speed;
    this.post({ kind: 'pace', speed });
    this.changed();
  }

  skip(): void {
    this.post({ kind: 'skip' });
  }

  private ask<T>(command: Command): Promise<T> {
    this.last += 1;
    const id = this.last;
    return new Promise<T>((done, refused) => {
      if (this.failure !== null) {
        refused(new Error(this.failure));
        return;
      }
      this.waiting.set(id, { done: done as (answer: unknown) => void, refused });
      this.post({ kind: 'command', id, command });
    });
  }

  private post(message: ToWorker): void {
    if (!this.failure) this.worker?.postMessage(message);
  }

  private hear(message: FromWorker): void {
    if (message.kind === 'answer') {
      const waiting = this.waiting.get(message.id);
      this.waiting.delete(message.id);
      if (message.error) waiting?.refused(new Refusal(message.error));
      else waiting?.done(message.ok);
    } else if (message.kind === 'view') {
      this.speed = message.speed;
      this.take(message.view, false);
    } else if (message.kind === 'failed') {
      this.failure = message.why;
      for (const one of this.waiting.values()) one.refused(new Error(message.why));
      this.waiting.clear();
      this.changed();
    }
  }

  private take(view: View, anew: boolean): void {
    if (anew) this.entries = [];
    for (const entry of view.entries) this.entries[entry.index] = entry;
    this.view = view;
    this.changed();
  }

  private changed(): void {
    this.dispatchEvent(new Event('change'));
  }
}
