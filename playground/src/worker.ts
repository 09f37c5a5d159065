/// <reference lib="webworker" />
// The simulator runs here, so that nothing it does can stop the page.
import { Engine, Failed, Refused } from './engine';
import moduleUrl from './lafet.wasm?url';
import type { FromWorker, ToWorker } from './messages';
import type { View } from './wire';

/** How often time passes, ms. */
const BEAT_MS = 50;
/** How long the simulator may work in a beat, ms; what it is behind then is given up. */
const WORK_MS = 30;
/** Simulated time of one call, ms. */
const SLICE_MS = 500;
/** What a beat may skip at most when a recorded session is wanted at its end, ms of simulated time. */
const SKIP_MS = 2000;

const post = (message: FromWorker): void => self.postMessage(message);

let engine: Engine | null = null;
let speed = 0;
let skips = false;
let owed = 0;
let last = 0;
let sent = 0;
let repeating = false;

self.onmessage = ({ data }: MessageEvent<ToWorker>): void => {
  if (!engine) return;
  guarded(() => {
    if (data.kind === 'pace') {
      speed = data.speed;
      owed = 0;
      last = performance.now();
      show({ op: 'advance', ms: 0, since: sent });
    } else if (data.kind === 'skip') {
      skips = true;
    } else {
      answer(data);
    }
  });
};

function answer({ id, command }: Extract<ToWorker, { kind: 'command' }>): void {
  try {
    const ok = engine!.call<unknown>(command);
    if (command.op === 'start' || command.op === 'open' || command.op === 'act') seen(ok as View, command.op !== 'act');
    post({ kind: 'answer', id, ok });
  } catch (error) {
    if (!(error instanceof Refused)) throw error;
    post({ kind: 'answer', id, error: error.words });
  }
}

function seen(view: View, anew: boolean): void {
  if (anew) {
    skips = false;
    owed = 0;
    last = performance.now();
  }
  sent = view.count;
  repeating = view.replay_ms !== null;
}

function show(command: { op: 'advance'; ms: number; since: number }): View {
  const view = engine!.call<View>(command);
  // A recorded session stops where it was shared, so that the same link can be made of it.
  if ((repeating && view.replay_ms === null) || view.over) {
    speed = 0;
    skips = false;
  }
  seen(view, false);
  post({ kind: 'view', view, speed });
  return view;
}

function beat(): void {
  const now = performance.now();
  if (skips && !repeating) skips = false;
  if (speed === 0 && !skips) {
    last = now;
    return;
  }
  owed += (now - last) * speed;
  last = now;
  const end = now + WORK_MS;
  while ((skips || owed >= 10) && performance.now() < end) {
    const ms = skips ? SKIP_MS : Math.floor(Math.min(owed, SLICE_MS) / 10) * 10;
    owed = skips ? 0 : owed - ms;
    show({ op: 'advance', ms, since: sent });
    if (speed === 0 && !skips) owed = 0;
  }
  owed = Math.min(owed, SLICE_MS);
}

/** What the simulator cannot survive is reported, and nothing is asked of it any more. */
function guarded(work: () => void): void {
  try {
    work();
  } catch (error) {
    engine = null;
    post({ kind: 'failed', why: error instanceof Failed ? error.message : String(error) });
  }
}

async function begin(): Promise<void> {
  const response = await fetch(moduleUrl);
  if (!response.ok) throw new Failed(`${moduleUrl}: ${response.status}`);
  engine = await Engine.of(await response.arrayBuffer());
  last = performance.now();
  post({ kind: 'ready' });
  setInterval(() => engine && guarded(beat), BEAT_MS);
}

begin().catch((error: unknown) => post({ kind: 'failed', why: String(error) }));
