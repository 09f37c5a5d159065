// Which drives are held, and how a hold ends. Pure: the joystick and the buttons feed it, it returns
// what started and what ended. Nothing may stay held by accident.

export type Drive = 'Horizontal' | 'Vertical' | 'Nozzle';
export type Toward = 'min' | 'max';

export interface HoldDetail {
  drive: Drive;
  toward: Toward;
}

export interface Holding {
  Horizontal?: Toward;
  Vertical?: Toward;
  Nozzle?: Toward;
}

/** The messages for a change of the held drives; ends come first. */
export function changes(from: Holding, to: Holding): { ended: HoldDetail[]; begun: HoldDetail[] } {
  const ended: HoldDetail[] = [];
  const begun: HoldDetail[] = [];
  for (const drive of ['Horizontal', 'Vertical', 'Nozzle'] as const) {
    const [before, after] = [from[drive], to[drive]];
    if (before === after) continue;
    if (before) ended.push({ drive, toward: before });
    if (after) begun.push({ drive, toward: after });
  }
  return { ended, begun };
}

/** A stick must be pulled this far, of its whole travel, before anything moves … */
export const DEAD_ZONE = 0.28;
/** … and returned this far before it stops, as hysteresis. */
export const DEAD_ZONE_BACK = 0.2;
/** Of two axes the smaller counts only if it is at least this part of the larger: tan 22.5°. */
export const DIAGONAL = 0.4142;

/** Drives that a stick moves: right and up positive, −1 … 1. */
export function ofStick(right: number, up: number, held: Holding): Holding {
  const far = Math.hypot(right, up);
  const moves = held.Horizontal !== undefined || held.Vertical !== undefined;
  if (far < (moves ? DEAD_ZONE_BACK : DEAD_ZONE)) return {};
  const holding: Holding = {};
  const [across, along] = [Math.abs(right), Math.abs(up)];
  if (across >= along * DIAGONAL) holding.Horizontal = right > 0 ? 'min' : 'max';
  if (along >= across * DIAGONAL) holding.Vertical = up > 0 ? 'max' : 'min';
  return holding;
}

const KEYS: Record<string, HoldDetail> = {
  ArrowUp: { drive: 'Vertical', toward: 'max' },
  ArrowDown: { drive: 'Vertical', toward: 'min' },
  ArrowLeft: { drive: 'Horizontal', toward: 'max' },
  ArrowRight: { drive: 'Horizontal', toward: 'min' },
};

export function ofKey(key: string): HoldDetail | null {
  return KEYS[key] ?? null;
}

/** Opposite keys together mean nothing. */
export function ofKeys(keys: Iterable<string>): Holding {
  const wanted = new Map<Drive, Set<Toward>>();
  for (const key of keys) {
    const hold = ofKey(key);
    if (!hold) continue;
    const towards = wanted.get(hold.drive) ?? new Set();
    wanted.set(hold.drive, towards.add(hold.toward));
  }
  const holding: Holding = {};
  for (const [drive, towards] of wanted) {
    if (towards.size === 1) holding[drive] = [...towards][0]!;
  }
  return holding;
}
