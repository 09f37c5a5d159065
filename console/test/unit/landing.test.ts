import { describe, expect, it, vi } from 'vitest';
import type { Thrown } from '../../src/hub/api';
import type { Jet } from '../../src/hub/jets';
import { loadLang } from '../../src/i18n';
import { type LandingArea, landingOf, strikesText, type Thrower, windOf } from '../../src/parts/plan/landing';
import { unshown } from '../../src/parts/plan/legend';
import type { PlanMonitor, PlanScene } from '../../src/parts/plan/model';
import { spanText } from '../../src/parts/words';

const thrower: Thrower = {
  at: [0, 0],
  heading: 90,
  water: true,
  horizontal_arcmin: 600,
  vertical_arcmin: 1800,
  pressure_datm: 79,
  flow_lps: 20,
};

const thrown: Thrown = {
  middle_m: { value: 35, low: 28.4, high: 41.6 },
  greatest_m: { value: 41.4, low: 37.3, high: 45.2 },
  left_m: { value: 0, low: 0, high: 0 },
  across_m: 1.2,
  flow_lps: 20,
  wind: null,
};

const jet = (more: Partial<Thrown> | null, no_throw: Jet['no_throw'] = null): Jet => ({
  pressure_datm: 79,
  reach_m: 44,
  flight: null,
  fault: null,
  throw: more && { ...thrown, ...more },
  no_throw,
});

const area = (more: Partial<Thrown> = {}): LandingArea => landingOf(thrower, jet(more)) as LandingArea;

describe('what the water strikes', () => {
  const strikes = { name: 'T-1', kind: 'tank', on_top: false, way_m: 20, height_m: 4, whole: true } as const;

  it('is named, with the part of the water and the side', async () => {
    vi.stubGlobal('document', { documentElement: { lang: '' } });
    vi.stubGlobal('localStorage', { getItem: () => 'en', setItem: () => undefined });
    await loadLang();
    const found = landingOf(thrower, { ...jet({}), throw_strikes: strikes }) as LandingArea;
    expect(found.strikes).toEqual(strikes);
    expect(strikesText(strikes)).toBe('it strikes the side of T-1');
    expect(strikesText({ ...strikes, on_top: true, whole: false })).toBe('a part of it lands on T-1');
    expect(strikesText({ ...strikes, name: '', kind: 'wall' })).toBe('it strikes the side of a wall');
    expect(area().strikes).toBeUndefined();
  });
});

describe('water that the picture cannot show as it flows', () => {
  const monitor = (more: Partial<PlanMonitor>) =>
    ({ id: 'M1', water: true, stale: false, flight: null, landing: null, ...more }) as PlanMonitor;

  it('is named, whether its path is not known or its monitor is silent', () => {
    const broken = monitor({ landing: 'pressure' });
    const silent = monitor({ id: 'M2', stale: true, flight: {} as never });
    expect(unshown([broken, silent], null)).toEqual([
      'M1: water flows; its path cannot be computed.',
      'M2 does not answer: its water, which may flow, is not shown.',
    ]);
  });

  it('is none where none flows, or its path is known', () => {
    const known = monitor({ flight: {} as never, landing: 'law' });
    expect(unshown([known, monitor({ water: false, landing: 'pressure' }), monitor({})], null)).toEqual([]);
    const dry = { jets: {} } as PlanScene;
    expect(unshown([monitor({ landing: 'pressure' })], dry), 'the valve is open before a dry main').toEqual([]);
  });
});

describe('the landing area', () => {
  it('goes from the nearest middle to the farthest drop, ahead of the barrel', () => {
    const { bearing, near_m, far_m, middle_m, greatest_m, width, with_wind } = area();
    // Ten degrees to the left of a monitor that looks east.
    expect([bearing, near_m, far_m, middle_m, greatest_m, with_wind]).toEqual([80, 28.4, 45.2, 35, 41.4, false]);
    expect(width).toBeCloseTo(3.93, 1);
  });

  it('follows the wind to its side, and is wider by what is not certain of it', () => {
    const left = area({ left_m: { value: 9.5, low: 6.3, high: 12.7 }, wind: { along_mps: 0, left_mps: 5 } });
    const right = area({ left_m: { value: -9.5, low: -12.7, high: -6.3 }, wind: { along_mps: 0, left_mps: -5 } });
    expect(left.bearing).toBeLessThan(66);
    expect(left.bearing + right.bearing).toBeCloseTo(160);
    expect([left.width > 10, left.width, left.with_wind]).toEqual([true, right.width, true]);
  });

  it('is hidden while no water flows, and before the answer', () => {
    expect(landingOf({ ...thrower, water: false }, jet({}))).toBeNull();
    expect(landingOf({ ...thrower, flow_lps: 0 }, jet({}))).toBeNull();
    expect(landingOf(thrower, null)).toBeNull();
    // Without a flow meter it is that of the outlet.
    expect(landingOf({ ...thrower, flow_lps: null }, jet({}))).toEqual(area());
  });

  it('says what is not known instead of showing a figure', () => {
    expect(landingOf({ ...thrower, pressure_datm: null }, jet({}))).toBe('pressure');
    expect(landingOf({ ...thrower, horizontal_arcmin: null }, jet({}))).toBe('direction');
    expect(landingOf({ ...thrower, vertical_arcmin: null }, jet({}))).toBe('direction');
    expect(landingOf(thrower, jet(null, 'pressure_unknown'))).toBe('pressure');
    expect(landingOf(thrower, jet(null, 'flow'))).toBe('law');
  });

  it('is rounded outwards', () => {
    expect(spanText(28.4, 45.2)).toBe('28–46\u202fm');
    expect(spanText(9, 12)).toBe('9–12\u202fm');
  });
});

describe('the wind of a jet', () => {
  it('is along it and to its left', () => {
    // To the north, for a jet to the north, the east, the west.
    expect(windOf([0, 5], 0)).toEqual({ along_mps: 5, left_mps: 0 });
    expect(windOf([0, 5], 90)).toEqual({ along_mps: 0, left_mps: 5 });
    expect(windOf([0, 5], 270)).toEqual({ along_mps: 0, left_mps: -5 });
    expect(windOf([3, 0], 0)).toEqual({ along_mps: 0, left_mps: -3 });
  });

  it('has coarse steps: gusts cause few queries', () => {
    expect(windOf([0.2, 5.2], 0)).toEqual(windOf([0, 5], 0));
  });
});
