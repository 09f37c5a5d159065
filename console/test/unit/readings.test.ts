import { afterEach, describe, expect, it } from 'vitest';
import { reading, readingOf, validOf } from '../../src/hub/readings';
import { store } from '../../src/hub/store';
import { field, position } from '../../src/pages/operate/state';
import { jetAsked, planMonitor } from '../../src/parts/plan/model';

const site = {
  monitors: { M1: { at: [0, 0] as [number, number], heading: 0, height: 2 } },
  tanks: [],
  walls: [],
  keep_outs: [],
};

const status = (bad: { General?: string; Vertical?: string }) => ({
  at_ms: 1,
  stale: false,
  error: null,
  subsystems: {
    General: {
      bits: 0,
      flags: [],
      severity: 'warning' as const,
      pressure: 0,
      flowrate: 18,
      ...(bad.General ? { bad: { pressure: bad.General } } : {}),
    },
    Vertical: {
      bits: 0,
      flags: [],
      severity: 'info' as const,
      position: 300,
      ...(bad.Vertical ? { bad: { position: bad.Vertical } } : {}),
    },
    Horizontal: { bits: 0, flags: [], severity: 'info' as const, position: 0 },
    Valve1: { bits: 0, flags: ['Open'], severity: 'info' as const },
  },
});

describe('the quality of a value', () => {
  afterEach(() => store.replace({ now_ms: 1, set: {} }));

  it('goes with the value, and what is bad is computed with nowhere', () => {
    const bad = status({ General: 'PressureSensorBreak', Vertical: 'PosEncoderFault' });
    expect(readingOf(bad.subsystems.General, 'pressure')).toEqual({ value: 0, bad: 'PressureSensorBreak' });
    expect(validOf(bad.subsystems.General, 'pressure')).toBeNull();
    expect(validOf(bad.subsystems.General, 'flowrate')).toBe(18);
    store.replace({ now_ms: 1, set: { 'monitors/M1/status': bad } });
    expect(reading('M1', 'Vertical', 'position')).toEqual({ value: 300, bad: 'PosEncoderFault' });
    expect([field('M1', 'General', 'pressure'), position('M1', 'Vertical'), position('M1', 'Horizontal')]).toEqual([
      null,
      null,
      0,
    ]);
    expect(reading('M1', 'Nozzle', 'position')).toEqual({ value: null, bad: null });
  });

  it('no jet is drawn over a position that is not known', () => {
    const flight = {
      points: [
        [0, 0, 0],
        [30, -2, 1],
      ] as [number, number, number][],
      lands_m: 30,
      core_m: 20,
      speed_mps: 39,
    };
    const jet = { pressure_datm: 79, reach_m: 44, flight, fault: null, throw: null, no_throw: null };
    const good = planMonitor('M1', site, { status: status({}), jet })!;
    expect(good.lands).not.toBeNull();
    const bad = planMonitor('M1', site, { status: status({ Vertical: 'PosEncoderFault' }), jet })!;
    expect([bad.vertical_arcmin, bad.lands]).toEqual([null, null]);
    expect(jetAsked(site.monitors.M1, status({}), null)!.elevation_arcmin).toBe(300);
    for (const bad of [{ General: 'PressureSensorBreak' }, { Vertical: 'PosEncoderFault' }]) {
      expect(jetAsked(site.monitors.M1, status(bad), null), JSON.stringify(bad)).toBeNull();
    }
  });
});
