// Which drives to move: stick on screen, keyboard and gamepad together. Pure.
import { DEAD_ZONE_BACK, type Holding, ofStick } from '../../parts/hold';

/** What a key means; the same wherever the key is. */
const MOVES = {
  up: { Vertical: 'max' },
  down: { Vertical: 'min' },
  left: { Horizontal: 'max' },
  right: { Horizontal: 'min' },
  narrow: { Nozzle: 'max' },
  wide: { Nozzle: 'min' },
} as const satisfies Record<string, Holding>;

/** Keys that have one place on every keyboard. */
const BY_CODE: Record<string, keyof typeof MOVES> = {
  ArrowUp: 'up',
  ArrowDown: 'down',
  ArrowLeft: 'left',
  ArrowRight: 'right',
  NumpadAdd: 'narrow',
  NumpadSubtract: 'wide',
};

/** What a key moves, with its meaning from what it types: `+` is where others have `-`; null: nothing. */
export function moveOf({ code, key, shiftKey }: Pick<KeyboardEvent, 'code' | 'key' | 'shiftKey'>): string | null {
  const move = BY_CODE[code];
  if (move) return move;
  if (key === '+') return 'narrow';
  if (key === '-' || key === '−') return 'wide';
  // The keys of + and − with the other state of Shift. Elsewhere Shift types a = or no Shift a _ beside other signs.
  if (key === '=') return shiftKey ? null : 'narrow';
  return key === '_' && shiftKey ? 'wide' : null;
}

/** Opposite keys together mean nothing. */
export function ofMoves(moves: Iterable<string>): Holding {
  const sum: Holding = {};
  const both = new Set<string>();
  for (const move of moves) {
    const of = Object.entries(MOVES[move as keyof typeof MOVES] ?? {}) as [keyof Holding, 'min' | 'max'][];
    for (const [drive, toward] of of) {
      if (sum[drive] && sum[drive] !== toward) both.add(drive);
      sum[drive] = toward;
    }
  }
  for (const drive of both) delete sum[drive as keyof Holding];
  return sum;
}

export interface PadLike {
  index: number;
  /** Only of a `standard` one it is known which axis and which button is which. */
  mapping: string;
  axes: readonly number[];
  buttons: readonly { pressed: boolean }[];
  /** When it has sent something last. Some browsers have none. */
  timestamp?: number;
}

/** Left stick or cross: the barrel; shoulder buttons: the nozzle. */
export function ofPad(pad: PadLike, held: Holding): Holding {
  const pressed = (n: number) => (pad.buttons[n]?.pressed ? 1 : 0);
  const right = clamp((pad.axes[0] ?? 0) + pressed(15) - pressed(14));
  const up = clamp(-(pad.axes[1] ?? 0) + pressed(12) - pressed(13));
  const holding = ofStick(right, up, held);
  const nozzle = pressed(5) + pressed(7) - (pressed(4) + pressed(6));
  if (nozzle !== 0) holding.Nozzle = nozzle > 0 ? 'max' : 'min';
  return holding;
}

const NOTHING: Holding = {};

/** A stick that a hand holds between its ends trembles: without anything new for this time, ms, its radio is dead. */
export const SILENT_STICK_MS = 2000;
/** A button, the cross, and a stick at its end may have nothing new to send; after this time, ms, it is not believed. */
export const SILENT_MOST_MS = 5000;
/** A stick this far out is at its end. */
const END = 0.95;

/** When a gamepad has sent something last, by its own word. */
interface Sent {
  timestamp: number | undefined;
  /** When that was new, by the clock of this page. */
  at: number;
  /** It was new once: a browser that never changes it says nothing by it. */
  counts: boolean;
}

/**
 * Gamepads that move only what was at rest before: since they were connected, since they were blocked, and since they
 * were silent while they held something. A browser shows the last state of one whose radio is dead for a long time.
 */
export class Pads {
  private readonly free = new Set<number>();
  private readonly sent = new Map<number, Sent>();

  /** `silent`: one that held something is not believed any longer. */
  constructor(private readonly silent: () => void = () => {}) {}

  /** Nothing moves until each is at rest again: after the focus, a STOP, a dialog, an end that was no release. */
  block(): void {
    this.free.clear();
  }

  /** What they want to move. */
  read(all: readonly PadLike[], held: Holding, now = performance.now()): Holding {
    const standard = all.filter(({ mapping }) => mapping === 'standard');
    for (const known of [this.free, this.sent]) {
      for (const index of known.keys()) if (!standard.some((pad) => pad.index === index)) known.delete(index);
    }
    const wanted = standard.map((pad) => {
      const silent_ms = this.silence(pad, now);
      // At rest by the wide dead zone, that of a stick that moves nothing.
      if (isEmpty(ofPad(pad, NOTHING))) this.free.add(pad.index);
      const wants = this.free.has(pad.index) ? ofPad(pad, held) : NOTHING;
      if (isEmpty(wants) || silent_ms <= silenceMost(pad)) return wants;
      this.free.delete(pad.index);
      this.silent();
      return NOTHING;
    });
    return together(wanted);
  }

  /** For how long it has sent nothing new, ms; 0 where the browser does not say. */
  private silence({ index, timestamp }: PadLike, now: number): number {
    const before = this.sent.get(index);
    if (before && before.timestamp === timestamp) return before.counts ? now - before.at : 0;
    this.sent.set(index, { timestamp, at: now, counts: before !== undefined && Boolean(timestamp) });
    return 0;
  }
}

function silenceMost({ axes }: PadLike): number {
  const trembles = axes.slice(0, 2).some((at) => Math.abs(at) > DEAD_ZONE_BACK && Math.abs(at) < END);
  return trembles ? SILENT_STICK_MS : SILENT_MOST_MS;
}

export function isEmpty(holding: Holding): boolean {
  return Object.values(holding).every((toward) => toward === undefined);
}

/** The first source that requests a drive gets it. */
export function together(sources: Iterable<Holding>): Holding {
  const sum: Holding = {};
  for (const source of sources) {
    for (const drive of ['Horizontal', 'Vertical', 'Nozzle'] as const) sum[drive] ??= source[drive];
  }
  return sum;
}

function clamp(x: number): number {
  return Math.max(-1, Math.min(1, x));
}
