import { describe, expect, it } from 'vitest';
import type { Jet } from '../../src/hub/jets';
import { distanceTo, type Place, type Sector } from '../../src/parts/geometry';
import { changes, ofKeys, ofStick } from '../../src/parts/hold';
import { hotbedOf, jetAsked, planMonitor } from '../../src/parts/plan/model';
import { dragged, GRIPS, gripAt, keyed, tidy, usualSector } from '../../src/parts/plan/sector-tool';
import { Columns, curveOf } from '../../src/parts/plot/data';

describe('hold', () => {
  it('has a dead zone with hysteresis', () => {
    expect(ofStick(0.25, 0, {})).toEqual({});
    expect(ofStick(0.3, 0, {})).toEqual({ Horizontal: 'min' });
    expect(ofStick(0.25, 0, { Horizontal: 'min' })).toEqual({ Horizontal: 'min' });
    expect(ofStick(0.15, 0, { Horizontal: 'min' })).toEqual({});
  });

  it('left and up are max, as on the wire', () => {
    expect(ofStick(-1, 0, {})).toEqual({ Horizontal: 'max' });
    expect(ofStick(0, 1, {})).toEqual({ Vertical: 'max' });
    expect(ofStick(0.7, -0.7, {})).toEqual({ Horizontal: 'min', Vertical: 'min' });
    expect(ofStick(0.95, 0.2, {})).toEqual({ Horizontal: 'min' });
  });

  it('ends before it begins, and ends everything', () => {
    const held = ofStick(-0.7, 0.7, {});
    expect(changes(held, {}).ended).toHaveLength(2);
    const turned = changes({ Horizontal: 'max' }, { Horizontal: 'min' });
    expect(turned).toEqual({
      ended: [{ drive: 'Horizontal', toward: 'max' }],
      begun: [{ drive: 'Horizontal', toward: 'min' }],
    });
    expect(changes(held, held)).toEqual({ ended: [], begun: [] });
  });

  it('opposite keys move nothing', () => {
    expect(ofKeys(['ArrowLeft', 'ArrowRight', 'ArrowUp'])).toEqual({ Vertical: 'max' });
    expect(ofKeys(['a'])).toEqual({});
  });
});

describe('sector tool', () => {
  const from: Place = [5, -3];
  const sector: Sector = { bearing: 350, width: 30, near_m: 20, far_m: 30 };

  it('keeps the other edge where it is', () => {
    const left = gripAt(from, sector, 'left');
    const right = gripAt(from, sector, 'right');
    const wider = dragged(from, sector, 'right', gripAt(from, { ...sector, bearing: 10 }, 'right'));
    expect(wider.width).toBeCloseTo(50);
    expect(distanceTo(gripAt(from, wider, 'left'), left)).toBeLessThan(1e-6);
    const narrower = keyed(sector, 'left', 'ArrowRight', true)!;
    expect(narrower.width).toBeCloseTo(25);
    expect(distanceTo(gripAt(from, narrower, 'right'), right)).toBeLessThan(1e-6);
  });

  it('moves as a whole', () => {
    const moved = dragged(
      from,
      sector,
      'move',
      gripAt(from, { ...sector, bearing: 10, near_m: 24, far_m: 34 }, 'move'),
    );
    expect(moved.bearing).toBeCloseTo(10);
    expect([moved.near_m, moved.far_m, moved.width]).toEqual([24, 34, 30].map((n) => expect.closeTo(n)));
  });

  it('never turns inside out', () => {
    for (const grip of GRIPS) {
      let next = sector;
      for (const key of ['ArrowLeft', 'ArrowDown']) {
        for (let press = 0; press < 200; press++) next = tidy(keyed(next, grip, key, true) ?? next);
      }
      expect(next.width).toBeGreaterThan(0);
      expect(next.far_m).toBeGreaterThan(next.near_m);
      expect(next.near_m).toBeGreaterThanOrEqual(0.5);
    }
    const inverted = dragged(from, sector, 'near', gripAt(from, { ...sector, far_m: 60 }, 'far'));
    expect(inverted.near_m).toBeLessThan(inverted.far_m);
  });

  it('is drawn where the click was', () => {
    const at: Place = [20, 20];
    expect(distanceTo(gripAt(from, usualSector(from, at), 'move'), at)).toBeLessThan(0.01);
  });
});

describe('plot', () => {
  it('has a gap without values', () => {
    const columns = new Columns(1, 60_000, 3000);
    columns.push(1000, [5]);
    columns.push(2000, [6]);
    columns.push(6000, [7]);
    expect(columns.table[1]).toEqual([5, 6, null, 7]);
    expect(columns.at(2500)).toEqual([null]);
    expect(columns.at(2000)).toEqual([6]);
    expect(columns.at(500)).toEqual([null]);
  });

  it('distinguishes an unknown value from one that was not sent', () => {
    const columns = new Columns(2, 60_000);
    columns.fill([
      [
        [1000, 1],
        [2000, null],
      ],
      [[1000, 8]],
    ]);
    expect(columns.at(2000)).toEqual([null, 8]);
  });

  it('has a gap where an interval of the history is missing, and none between adjacent ones', () => {
    const minute = 60_000;
    const { value, low, high } = curveOf(
      [
        [0, 5, 1, 9],
        [minute, 6, 6, 6],
        [5 * minute, 7, 2, 8],
      ],
      minute,
    );
    const columns = new Columns(3, Infinity);
    columns.fill([value, low, high]);
    expect(columns.at(30_000)).toEqual([5, 1, 9]);
    expect(columns.at(minute + 1)).toEqual([6, 6, 6]);
    expect(columns.at(2 * minute)).toEqual([null, null, null]);
    expect(columns.at(5 * minute + 1)).toEqual([7, 2, 8]);
    expect(columns.at(6 * minute)).toEqual([null, null, null]);
    expect(value.slice(0, 3)).toEqual([
      [0, 5],
      [minute - 1, 5],
      [minute, 6],
    ]);
    expect(curveOf([], minute)).toEqual({ value: [], low: [], high: [] });
  });

  it('keeps a month of intervals', () => {
    const step = 75 * 60_000;
    const spans = Array.from({ length: 600 }, (_, n): [number, number, number, number] => [n * step, n, n - 1, n + 1]);
    const columns = new Columns(1, Infinity);
    columns.fill([curveOf(spans, step).value]);
    expect(columns.first_ms).toBe(0);
    expect(columns.at(299 * step)).toEqual([299]);
  });

  it('drops old values and refuses late ones', () => {
    const columns = new Columns(1, 10_000);
    for (let at = 0; at <= 100_000; at += 1000) columns.push(at, [at]);
    expect(columns.first_ms!).toBeGreaterThanOrEqual(100_000 - 10_000 - 30_000);
    const { length } = columns;
    columns.push(50_000, [1]);
    expect(columns.length).toBe(length);
  });
});

describe('plan model', () => {
  const site = {
    monitors: { M1: { at: [-20, -20] as Place, heading: 45, height: 6 } },
    tanks: [{ name: 'T-1', at: [0, 0] as Place, diameter: 10, height: 6 }],
    walls: [],
    keep_outs: [],
  };
  const status = (flags: string[]) => ({
    stale: false,
    at_ms: 1,
    subsystems: {
      Horizontal: { position: 0 },
      Vertical: { position: 300 },
      Nozzle: { position: 60 },
      General: { pressure: 79 },
      Valve1: { flags },
    },
  });

  it('puts a fire spot on the tank in its direction', () => {
    const box = { x1: -60, x2: 60, y1: 0, y2: 30, brightness: 9 };
    expect(hotbedOf(site.monitors.M1, box, site.tanks).distance_m).toBeCloseTo(28.28, 1);
    const ground = { ...box, x1: 3000, x2: 3060, y1: -1200, y2: -1200 };
    expect(hotbedOf(site.monitors.M1, ground, site.tanks).distance_m).toBeCloseTo(16.5, 0);
  });

  const jet: Jet = {
    pressure_datm: 79,
    reach_m: 44,
    flight: {
      points: [
        [0, 0, 0],
        [20, 2, 0.6],
        [38, -6, 1.5],
      ],
      lands_m: 38,
      core_m: 20,
      speed_mps: 39,
    },
    fault: null,
    throw: null,
    no_throw: 'height',
  };

  it('shows the landing that the hub has computed, and only while water flows', () => {
    const shut = planMonitor('M1', site, { status: status(['Closed']), jet })!;
    expect([shut.lands, shut.flight, shut.reach_m]).toEqual([null, null, 44]);
    const open = planMonitor('M1', site, { status: status(['Open']), jet })!;
    expect(open.lands![0]).toBeCloseTo(open.lands![1]);
    expect(distanceTo(open.at, open.lands!)).toBeCloseTo(38);
    // Nothing is shown before the answer.
    const early = planMonitor('M1', site, { status: status(['Open']) })!;
    expect([early.lands, early.flight ?? null, early.reach_m]).toEqual([null, null, null]);
  });

  it('shows the landing at the tank that the jet strikes, and asks again when the barrel turns', () => {
    const strikes = { name: 'T-1', kind: 'tank', on_top: false, way_m: 12, height_m: 4, whole: true } as const;
    const open = planMonitor('M1', site, { status: status(['Open']), jet: { ...jet, strikes } })!;
    expect(distanceTo(open.at, open.lands!)).toBeCloseTo(12);
    expect(open.strikes).toEqual(strikes);
    expect(planMonitor('M1', site, { status: status(['Closed']), jet: { ...jet, strikes } })!.strikes).toBeNull();
    const turned = (built: number) => jetAsked(site.monitors.M1, status(['Open']), null, built)!.horizontal_arcmin;
    expect([turned(0), typeof turned(1)]).toEqual([undefined, 'number']);
  });

  it('asks about the water that flows, else about the usual one, whatever the barrel does meanwhile', () => {
    const of = (flags: string[], pressure: number) => {
      const known = status(flags);
      known.subsystems.General.pressure = pressure;
      return jetAsked(site.monitors.M1, known, { wind: [0, 4] })!;
    };
    const wind = expect.objectContaining({ along_mps: expect.any(Number) });
    const live = {
      pressure_datm: 5,
      nozzle_mm: 60,
      height_cm: 600,
      elevation_arcmin: 300,
      flow_lps: null,
      wind,
      live: true,
    };
    expect(of(['Open'], 5)).toEqual(live);
    expect(of(['Closed'], 5)).toEqual({ ...live, pressure_datm: 79, elevation_arcmin: 0, wind: null, live: false });
    expect(of(['Closed'], 60).pressure_datm).toBe(60);
    expect(jetAsked(undefined, status([]), null)).toBeNull();
  });

  it('never shows what is not known as live', () => {
    expect(planMonitor('M1', site, {})!.stale).toBe(true);
    expect(planMonitor('M1', site, { status: { ...status([]), stale: true } })!.stale).toBe(true);
    expect(planMonitor('M1', site, { status: status([]), down: true })!.stale).toBe(true);
    expect(planMonitor('M9', site, {})).toBeNull();
  });
});

describe('landing in a simulation', () => {
  const site = {
    monitors: { M1: { at: [0, 0] as Place, heading: 0, height: 2 } },
    tanks: [],
    walls: [],
    keep_outs: [],
  };
  const scene = (splashes: { monitor: string; at: Place; litres: number; foam: number }[]) => ({
    t_s: 1,
    wind: [0, 0] as Place,
    fires: [],
    jets: { M1: { lps: 20, lands: [0, 40] as Place, litres: 1 } },
    splashes,
  });

  it('is where the water fell, by litres; else where it would fall', () => {
    const at = (splashes: Parameters<typeof scene>[0]) => planMonitor('M1', site, { scene: scene(splashes) })!.lands;
    expect(at([])).toEqual([0, 40]);
    expect(at([{ monitor: 'M2', at: [9, 9], litres: 5, foam: 0 }])).toEqual([0, 40]);
    expect(
      at([
        { monitor: 'M1', at: [0, 20], litres: 3, foam: 0 },
        { monitor: 'M1', at: [4, 28], litres: 1, foam: 0 },
      ]),
    ).toEqual([1, 22]);
  });
});
