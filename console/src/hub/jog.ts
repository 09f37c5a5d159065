// A held motion (docs/hub-api.md, Jog): heartbeats from the main thread while the control is held, and
// an end for every way in which it can be released.
import { onHalt } from './halt';
import { type Said, socket } from './socket';
import { LINKED, store } from './store';
import type { Drive, JogSeen, JogState, Text, Toward } from './types';

export interface HoldState {
  state: JogState;
  /** Why it ended, if the hub reported it. */
  end: JogSeen['end'] | 'link' | 'left';
  text: Text | null;
}

/** The functions of the page that jog needs; tests use their own. */
export interface JogWays {
  send: (message: Said) => boolean;
  now: () => number;
  beat_ms: () => number;
  allowed: () => boolean;
}

export class Hold {
  /** No longer held, whatever the drive does; a new motion needs a new hold after a release. */
  ended = false;
  /** The hub has reported that it moves: what it reports after that is about this hold, not about the one before. */
  moves = false;

  constructor(
    readonly monitor: string,
    readonly drive: Drive,
    readonly toward: Toward,
    private readonly jog: Jog,
    readonly onState?: (state: HoldState) => void,
  ) {}

  end(): void {
    this.jog.release(this, 'left');
  }
}

/** For so long after a release, ms, the hub may still report the end of what was released. */
const FORMER_MS = 1000;
const OF_FORMER: readonly HoldState['end'][] = [null, 'stopped', 'replaced'];

export class Jog {
  private readonly holds = new Map<string, Hold>();
  private readonly releasedAt = new Map<string, number>();
  private timer: ReturnType<typeof setInterval> | undefined;

  constructor(private readonly ways: JogWays) {}

  /** Starts to move a drive for as long as it is held. `hold.end()` releases it. */
  hold(monitor: string, drive: Drive, toward: Toward, onState?: (s: HoldState) => void): Hold {
    const hold = new Hold(monitor, drive, toward, this, onState);
    const before = this.holds.get(key(hold));
    if (before) before.ended = true;
    if (!this.ways.allowed()) {
      hold.ended = true;
      onState?.({ state: 'ended', end: 'link', text: null });
      return hold;
    }
    this.holds.set(key(hold), hold);
    this.beat(hold);
    if (hold.ended) return hold;
    this.timer ??= setInterval(() => this.beatAll(), this.ways.beat_ms());
    return hold;
  }

  /** Releases everything, or one monitor: blur, a hidden page, a dialog, STOP. */
  endAll(why: 'left' | 'link' = 'left', monitor?: string): void {
    for (const hold of [...this.holds.values()]) {
      if (!monitor || hold.monitor === monitor) this.release(hold, why);
    }
  }

  /** Something is held. */
  get busy(): boolean {
    return this.holds.size > 0;
  }

  held(monitor: string, drive: Drive): Hold | undefined {
    return this.holds.get(`${monitor}/${drive}`);
  }

  release(hold: Hold, why: 'left' | 'link'): void {
    if (hold.ended) return;
    this.forget(hold);
    this.releasedAt.set(key(hold), this.ways.now());
    this.ways.send({ type: 'jog_end', monitor: hold.monitor, drive: hold.drive });
    hold.onState?.({ state: 'ended', end: why, text: null });
  }

  /** The hub's report of a motion. After `ended` the hold is over: the control must be released first. */
  heard(message: JogSeen): void {
    const hold = this.holds.get(key(message));
    if (!hold) return;
    if (message.state === 'moving') hold.moves = true;
    if (message.state === 'ended' || message.state === 'stopping') {
      if (!hold.moves && this.ofFormer(message)) return;
      this.forget(hold);
      // Heartbeats in flight must not start another motion.
      this.ways.send({ type: 'jog_end', monitor: hold.monitor, drive: hold.drive });
    }
    hold.onState?.({ state: message.state, end: message.end, text: message.text });
  }

  private ofFormer(message: JogSeen): boolean {
    const at = this.releasedAt.get(key(message)) ?? -Infinity;
    return this.ways.now() - at < FORMER_MS && OF_FORMER.includes(message.end);
  }

  private forget(hold: Hold): void {
    hold.ended = true;
    if (this.holds.get(key(hold)) === hold) this.holds.delete(key(hold));
    if (this.holds.size > 0) return;
    clearInterval(this.timer);
    this.timer = undefined;
  }

  private beatAll(): void {
    for (const hold of [...this.holds.values()]) this.beat(hold);
  }

  private beat(hold: Hold): void {
    const sent = this.ways.send({
      type: 'jog',
      monitor: hold.monitor,
      drive: hold.drive,
      toward: hold.toward,
      t: this.ways.now(),
    });
    if (!sent) this.release(hold, 'link');
  }
}

function key(of: { monitor: string; drive: string }): string {
  return `${of.monitor}/${of.drive}`;
}

export const jog = new Jog({
  send: (message) => socket.send(message),
  now: () => performance.now(),
  beat_ms: () => store.hello?.jog.beat_ms ?? 60,
  allowed: () => store.linked && store.source === 'live' && !document.hidden,
});

/** Every way in which a control is released without a release event. */
export function guardJog(): void {
  socket.on('jog', (message) => jog.heard(message));
  const leave = () => jog.endAll();
  window.addEventListener('blur', leave);
  window.addEventListener('pagehide', leave);
  window.addEventListener('pointercancel', leave, true);
  document.addEventListener('visibilitychange', leave);
  document.addEventListener('freeze', leave);
  // The hub ends them with a Close too. One of another client it ends by itself, and reports why.
  onHalt(({ monitor, own }) => own && jog.endAll('left', monitor ?? undefined));
  store.subscribe(LINKED, () => {
    if (!store.linked || store.source === 'replay') jog.endAll('link');
  });
}
