// Keys that are held. The release of a key may never be reported: macOS reports none while Cmd is down, a menu takes
// it, and with NumLock the release has another name than the press. Then nothing is held any more, rather than for ever.

/** Without any key event for this time, ms, nothing is held: where the system does not repeat keys … */
const SILENT_MOST_MS = 30_000;
/** … and where it has repeated since the last press or release. */
const REPEATS_MOST_MS = 1500;
const LOOK_MS = 250;
/** They take the releases of other keys away, or change what those are called. */
const TAKERS = ['Meta', 'OS', 'Alt', 'AltGraph', 'NumLock', 'ContextMenu'];

type Sign = Pick<KeyboardEvent, 'type' | 'code' | 'key' | 'repeat' | 'metaKey'>;

/** What an event of the window says of the keys that are held: null, nothing. */
export function lapses(event: Partial<Sign> & { type: string }): boolean {
  return (
    event.type === 'contextmenu' ||
    event.metaKey === true ||
    (event.type === 'keydown' && TAKERS.includes(event.key ?? ''))
  );
}

const SIGNS = ['contextmenu', 'keydown', 'keyup', 'pointerdown', 'pointermove', 'wheel'] as const;

export class HeldKeys {
  /** What each key is held for, by its code. */
  private readonly held = new Map<string, string>();
  private timer: ReturnType<typeof setInterval> | undefined;
  private heardAt = 0;
  private repeats = false;

  /** `changed`: other keys are held, or none. */
  constructor(private readonly changed: () => void) {}

  get size(): number {
    return this.held.size;
  }

  has(code: string): boolean {
    return this.held.has(code);
  }

  /** What the keys are held for. */
  values(): string[] {
    return [...this.held.values()];
  }

  /** A press; one that repeats was pressed before, and holds nothing that has ended. */
  press(event: Sign, means = event.code): void {
    if (event.repeat || event.metaKey) return;
    this.held.set(event.code, means);
    this.heard(false);
    this.watch(true);
    this.changed();
  }

  release(code: string): void {
    if (!this.held.delete(code)) return;
    this.heard(false);
    if (this.held.size === 0) this.watch(false);
    this.changed();
  }

  clear(): void {
    if (this.held.size === 0) return;
    this.held.clear();
    this.watch(false);
    this.changed();
  }

  private heard(repeats: boolean): void {
    this.heardAt = performance.now();
    this.repeats = repeats;
  }

  private watch(on: boolean): void {
    clearInterval(this.timer);
    this.timer = on ? setInterval(() => this.look(), LOOK_MS) : undefined;
    for (const type of SIGNS) {
      if (on) window.addEventListener(type, this.sign, { capture: true, passive: true });
      else window.removeEventListener(type, this.sign, true);
    }
  }

  private readonly sign = (given: Event): void => {
    const event = given as KeyboardEvent;
    if (lapses(event)) this.clear();
    else if (event.type === 'keyup') this.release(event.code);
    else if (event.type === 'keydown') this.heard(event.repeat && this.held.has(event.code));
  };

  private look(): void {
    const most = this.repeats ? REPEATS_MOST_MS : SILENT_MOST_MS;
    if (performance.now() - this.heardAt > most) this.clear();
  }
}
