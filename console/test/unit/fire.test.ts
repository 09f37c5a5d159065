// The sound of the fire alarm: where the browser blocks it, the page says so, and the next press brings it.
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import type { Alarm } from '../../src/hub/types';

const FIRE = { priority: 'fire', state: 'unack', active: true } as Alarm;

/** What the browser makes of a context: it plays after a press. */
class Context extends EventTarget {
  static all: Context[] = [];
  static pressed = false;
  state = 'suspended';
  currentTime = 0;
  destination = {};
  tones = 0;

  constructor() {
    super();
    Context.all.push(this);
  }

  resume(): Promise<void> {
    if (!Context.pressed) return new Promise(() => {});
    this.turn('running');
    return Promise.resolve();
  }

  turn(to: string): void {
    this.state = to;
    this.dispatchEvent(new Event('statechange'));
  }

  createOscillator() {
    this.tones += 1;
    return { frequency: {}, connect: (next: unknown) => next, start: () => {}, stop: () => {} };
  }

  createGain() {
    return { gain: {}, connect: (next: unknown) => next };
  }
}

let fire: typeof import('../../src/shell/fire');
let kept: Map<string, string>;
let page: EventTarget;

beforeEach(async () => {
  vi.useFakeTimers();
  vi.resetModules();
  Context.all = [];
  Context.pressed = false;
  kept = new Map([['lafet.sound', 'on']]);
  page = new EventTarget();
  Object.assign(globalThis, {
    AudioContext: Context,
    localStorage: {
      getItem: (key: string) => kept.get(key) ?? null,
      setItem: (key: string, value: string) => kept.set(key, value),
    },
    window: Object.assign(page, { setInterval, setTimeout }),
  });
  // Modules are loaded for each test: this is the store of this one.
  const { store: own } = await import('../../src/hub/store');
  vi.spyOn(own, 'alarmsLive').mockReturnValue([FIRE]);
  fire = await import('../../src/shell/fire');
});
afterEach(() => {
  vi.useRealTimers();
  vi.restoreAllMocks();
});

const tones = () => Context.all.reduce((sum, { tones }) => sum + tones, 0);

test.each(['pointerdown', 'keydown'])(
  'blocked: nothing is scheduled, the page says so, and %s ends it',
  async (type) => {
    const turned = vi.fn();
    fire.soundTurned.addEventListener('change', turned);
    fire.followFire();
    expect(fire.soundBlocked(), 'a context needs a moment').toBe(false);
    await vi.advanceTimersByTimeAsync(10_000);
    expect([fire.soundBlocked(), tones(), Context.all.length, turned.mock.calls.length]).toEqual([true, 0, 1, 1]);
    Context.pressed = true;
    page.dispatchEvent(new Event(type));
    expect(fire.soundBlocked()).toBe(false);
    await vi.advanceTimersByTimeAsync(4000);
    expect(tones()).toBe(4);
  },
);

test('that it is blocked is known before there is a fire, and not where no sound is wanted', async () => {
  const { store: own } = await import('../../src/hub/store');
  vi.mocked(own.alarmsLive).mockReturnValue([]);
  fire.followFire();
  await vi.advanceTimersByTimeAsync(2000);
  expect(fire.soundBlocked()).toBe(true);
  fire.setSound(false);
  expect(fire.soundBlocked()).toBe(false);
  await vi.advanceTimersByTimeAsync(4000);
  expect(fire.soundBlocked()).toBe(false);
});

test('without the wish for sound there is no context', async () => {
  kept.delete('lafet.sound');
  fire.followFire();
  page.dispatchEvent(new Event('pointerdown'));
  await vi.advanceTimersByTimeAsync(10_000);
  expect(Context.all).toEqual([]);
});

test('what the system silences later is said, too', async () => {
  Context.pressed = true;
  fire.followFire();
  await vi.advanceTimersByTimeAsync(2000);
  expect([fire.soundBlocked(), tones()]).toEqual([false, 2]);
  Context.pressed = false;
  Context.all[0]!.turn('interrupted');
  await vi.advanceTimersByTimeAsync(2000);
  expect(fire.soundBlocked()).toBe(true);
});

test('silenced on this page: what there is now, until something is new, comes again, or a login', async () => {
  const { store: own } = await import('../../src/hub/store');
  const see = (...fires: Alarm[]) => vi.mocked(own.alarmsLive).mockReturnValue(fires);
  const [one, other] = [
    { ...FIRE, id: 'M1/fire', since_ms: 1 },
    { ...FIRE, id: 'M2/fire', since_ms: 2 },
  ];
  see(one);
  Context.pressed = true;
  fire.followFire();
  await vi.advanceTimersByTimeAsync(2000);
  expect([fire.sounding(), tones()]).toEqual(['sounds', 2]);
  fire.silenceHere();
  await vi.advanceTimersByTimeAsync(10_000);
  expect([fire.sounding(), tones()]).toEqual(['silenced', 2]);
  expect(fire.soundWanted(), 'the setting stays').toBe(true);
  see(one, other);
  await vi.advanceTimersByTimeAsync(2000);
  expect([fire.sounding(), tones()], 'another fire').toEqual(['sounds', 4]);
  fire.silenceHere();
  see();
  await vi.advanceTimersByTimeAsync(2000);
  expect([fire.sounding(), tones()]).toEqual(['none', 4]);
  see(one);
  await vi.advanceTimersByTimeAsync(2000);
  expect(tones(), 'the same again').toBe(6);
  fire.silenceHere();
  fire.soundAgain();
  await vi.advanceTimersByTimeAsync(2000);
  expect(tones(), 'after a login').toBe(8);
});

test('what is switched on is heard at once', async () => {
  kept.delete('lafet.sound');
  Context.pressed = true;
  fire.setSound(true);
  await vi.advanceTimersByTimeAsync(0);
  expect(tones()).toBe(2);
});
