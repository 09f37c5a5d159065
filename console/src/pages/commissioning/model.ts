// The order of commissioning, and what the browser stores of it. Pure.
import type { Key } from '../../i18n';

export const STEPS = [
  'prepare',
  'stop',
  'directions',
  'zero',
  'limits',
  'nozzle',
  'tune',
  'valves',
  'sensors',
  'buttons',
  'detector',
  'climatics',
  'lockout',
] as const;
export type StepId = (typeof STEPS)[number];

/** The procedure cannot continue without these: they cannot be skipped with a reason. */
export const BLOCKING: readonly StepId[] = ['prepare', 'stop', 'directions'];

/** What is measured again when a step is repeated. */
const UPON: Partial<Record<StepId, readonly StepId[]>> = {
  directions: ['zero', 'limits', 'tune'],
  zero: ['limits'],
  limits: ['tune'],
};

/** Subsystems that a step needs: one of them. */
const NEEDS: Partial<Record<StepId, readonly string[]>> = {
  nozzle: ['Nozzle'],
  tune: ['Horizontal', 'Vertical', 'Nozzle'],
  valves: ['Valve1', 'Valve2'],
  buttons: ['Buttons', 'ExtButtons'],
  detector: ['Detector'],
  climatics: ['Climatics'],
};

/** A fact for the report: a text with its parts, so that it can be read in both languages. */
export interface Fact {
  key: Key;
  args?: Record<string, string | number>;
}

export interface Done {
  state: 'passed' | 'failed';
  at_ms: number;
  by: string;
  /** Why it was not passed. */
  reason?: string;
  facts: Fact[];
}

export interface Progress {
  begun_ms: number;
  steps: Partial<Record<StepId, Done>>;
  /** What a step has found so far. */
  work: Partial<Record<StepId, Record<string, unknown>>>;
}

export function begun(now_ms: number): Progress {
  return { begun_ms: now_ms, steps: {}, work: {} };
}

/** The steps of a monitor with these subsystems. */
export function stepsOf(present: readonly string[]): StepId[] {
  return STEPS.filter((id) => !NEEDS[id] || NEEDS[id].some((name) => present.includes(name)));
}

/** The step that has to be done before this one; null: it may be done. */
export function gate(progress: Progress, steps: readonly StepId[], id: StepId): StepId | null {
  for (const before of steps.slice(0, steps.indexOf(id))) {
    const done = progress.steps[before];
    if (!done || (done.state === 'failed' && BLOCKING.includes(before))) return before;
  }
  return null;
}

/** The one to do next; null: all have been done. */
export function nextOf(progress: Progress, steps: readonly StepId[]): StepId | null {
  return (
    steps.find((id) => {
      const done = progress.steps[id];
      return !done || (done.state === 'failed' && BLOCKING.includes(id));
    }) ?? null
  );
}

export function finish(progress: Progress, id: StepId, done: Done): Progress {
  return { ...progress, steps: { ...progress.steps, [id]: done } };
}

/** Resets a step, and those that depend on it. */
export function redo(progress: Progress, id: StepId): Progress {
  const gone = [id, ...(UPON[id] ?? [])];
  const kept = <T extends object>(all: T): T =>
    Object.fromEntries(Object.entries(all).filter(([key]) => !gone.includes(key as StepId))) as T;
  return { ...progress, steps: kept(progress.steps), work: kept(progress.work) };
}

export function keepWork(progress: Progress, id: StepId, part: Record<string, unknown>): Progress {
  return { ...progress, work: { ...progress.work, [id]: { ...progress.work[id], ...part } } };
}

export type Verdict = 'open' | 'passed' | 'failed';

/** Passed only when every step is. */
export function verdict(progress: Progress, steps: readonly StepId[]): Verdict {
  const states = steps.map((id) => progress.steps[id]?.state);
  if (states.includes('failed')) return 'failed';
  return states.every((state) => state === 'passed') ? 'passed' : 'open';
}

const key = (monitor: string) => `lafet.commissioning.${monitor}`;

export function readProgress(monitor: string, storage: Pick<Storage, 'getItem'> = localStorage): Progress | null {
  try {
    const found = JSON.parse(storage.getItem(key(monitor)) ?? 'null') as Progress | null;
    return found && typeof found.begun_ms === 'number' && found.steps && found.work ? found : null;
  } catch {
    return null;
  }
}

export function writeProgress(monitor: string, progress: Progress | null): void {
  try {
    if (progress) localStorage.setItem(key(monitor), JSON.stringify(progress));
    else localStorage.removeItem(key(monitor));
  } catch {
    // The page works without it; a reload would start over.
  }
}

/** The test of STOP: something moves, STOP is pressed, and the monitor reports that it is at rest. */
export interface StopTest {
  phase: 'idle' | 'moving' | 'stopping' | 'passed' | 'failed';
  why?: 'let_go' | 'moves_on';
  /** By the hub's clock. */
  pressed_ms?: number;
  took_ms?: number;
}

/** Time within which the monitor must report that it is at rest. */
export const STOP_MOST_MS = 2000;

export type StopSeen = { kind: 'status'; moving: boolean; at_ms: number } | { kind: 'stop'; at_ms: number };

export function stopTest(test: StopTest, seen: StopSeen): StopTest {
  if (test.phase === 'passed') return test;
  if (seen.kind === 'stop') {
    return test.phase === 'moving' ? { phase: 'stopping', pressed_ms: seen.at_ms } : test;
  }
  const { moving, at_ms } = seen;
  switch (test.phase) {
    case 'idle':
    case 'failed':
      return moving ? { phase: 'moving' } : test;
    case 'moving':
      return moving ? test : { phase: 'idle', why: 'let_go' };
    default: {
      const took_ms = at_ms - (test.pressed_ms ?? at_ms);
      // Reports from before STOP was pressed do not count.
      if (took_ms < 0) return test;
      if (!moving) return { phase: 'passed', pressed_ms: test.pressed_ms, took_ms };
      return took_ms > STOP_MOST_MS ? { phase: 'failed', why: 'moves_on' } : test;
    }
  }
}

/** Limits closer than this are wrong: 5°, or 5 mm. */
export function leastTravel(drive: string): number {
  return drive === 'Nozzle' ? 5 : 300;
}

/** What is wrong with the new limits, together with the unchanged ones; empty: they may be switched on. */
export function whyNotLimits(
  drive: string,
  taken: { min?: number; max?: number },
  now: { min: number; max: number } | null,
): '' | 'order' | 'narrow' {
  const min = taken.min ?? now?.min;
  const max = taken.max ?? now?.max;
  if (min === undefined || max === undefined) return '';
  if (max <= min) return 'order';
  return max - min < leastTravel(drive) ? 'narrow' : '';
}

/** Smallest travel that shows the direction of a drive: 1°, or 2 mm. */
export function leastWay(drive: string): number {
  return drive === 'Nozzle' ? 2 : 60;
}

export type Way = 'right' | 'wrong' | 'little';

/** Whether the position changed in the commanded direction. */
export function wayOf(drive: string, toward: 'min' | 'max', from: number, to: number): Way {
  const delta = to - from;
  if (Math.abs(delta) < leastWay(drive)) return 'little';
  return delta > 0 === (toward === 'max') ? 'right' : 'wrong';
}

/** Whether two positions are equal within the stopping accuracy of a drive. */
export function near(drive: string, a: number, b: number): boolean {
  return Math.abs(a - b) <= (drive === 'Nozzle' ? 1 : 30);
}

export const BUTTONS = ['Left', 'Right', 'Up', 'Down', 'Wide', 'Narrow', 'Open', 'Close'] as const;
export type ButtonName = (typeof BUTTONS)[number];
export type ButtonState = 'Released' | 'Pressed' | 'Short' | 'Open';

/** State of a button from the flags of its post: `LeftButtonState=Pressed`; none: released. */
export function buttonState(flags: readonly string[], button: ButtonName): ButtonState {
  const found = flags.find((flag) => flag.startsWith(`${button}ButtonState=`));
  return (found?.split('=')[1] as ButtonState | undefined) ?? 'Released';
}
