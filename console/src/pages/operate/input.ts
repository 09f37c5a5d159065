// Which drives to move: stick on screen, keyboard and gamepad together. Pure.
import { type Holding, ofStick } from '../../parts/hold';

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

/** Gamepads that move only what was at rest before: since they were connected, and since they were blocked. */
export class Pads {
  private readonly free = new Set<number>();

  /** Nothing moves until each is at rest again: after the focus, a STOP, a dialog, an end that was no release. */
  block(): void {
    this.free.clear();
  }

  /** What they want to move. */
  read(all: readonly PadLike[], held: Holding): Holding {
    const standard = all.filter(({ mapping }) => mapping === 'standard');
    for (const index of this.free) if (!standard.some((pad) => pad.index === index)) this.free.delete(index);
    const wanted = standard.map((pad) => {
      // At rest by the wide dead zone, that of a stick that moves nothing.
      if (isEmpty(ofPad(pad, NOTHING))) this.free.add(pad.index);
      return this.free.has(pad.index) ? ofPad(pad, held) : NOTHING;
    });
    return together(wanted);
  }
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
