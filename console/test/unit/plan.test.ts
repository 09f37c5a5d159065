import { describe, expect, it } from 'vitest';
import type { FirePlace, KeepOut } from '../../src/hub/api';
import { type Camera, compassAt, keepOuts } from '../../src/parts/plan/layers';
import { type PlanMonitor, type PlanScene, type PlanSite, shownPlaces } from '../../src/parts/plan/model';

const SITE: PlanSite = {
  monitors: { M1: { at: [0, 0], heading: 0, height: 6 }, M2: { at: [40, 0], heading: 0, height: 6 } },
  tanks: [],
  walls: [],
  keep_outs: [],
};
const sees = (id: string, at: [number, number], bearing: number) =>
  ({ id, at, hotbeds: [{ bearing, distance_m: null, guessed: false }] }) as unknown as PlanMonitor;

describe('the plan', () => {
  it('has room for a fire that detectors have found, where no simulation names it', () => {
    const monitors = [sees('M1', [0, 0], 30), sees('M2', [40, 0], 330)];
    const north = (scene: PlanScene | null) => Math.max(...shownPlaces(SITE, scene, monitors, []).map(([at]) => at[1]));
    expect(north(null)).toBeCloseTo(34.6, 1);
    expect(north({ fires: [] } as unknown as PlanScene)).toBe(0);
  });

  it('has room for a place where bearings cross, and none for a ghost', () => {
    const at = (standing: FirePlace['standing'], north: number) =>
      ({ zone: 'hall', standing, at: [0, north], major_m: 2 }) as unknown as FirePlace;
    const places = shownPlaces(SITE, null, [], [at('sure', 50), at('ghost', 90)]);
    expect(places.at(-1)).toEqual([[0, 50], 2]);
  });

  it('shows the keep-outs of the chosen monitor, through north too', () => {
    const camera: Camera = { view: { east: 0, north: 0, scale: 10 }, width: 800, height: 600, mini: false, above: 0 };
    const sector = (name: string, monitor: string | null, bearings: [number, number]): KeepOut => ({
      name,
      for: 'people',
      monitor,
      bearings,
      elevations: [-90, 90],
    });
    const site = {
      ...SITE,
      keep_outs: [sector('stand', 'M1', [350, 10]), sector('gate', 'M2', [80, 90]), sector('roof', null, [0, 360])],
    };
    const shown = keepOuts(camera, site, { id: 'M1', at: [0, 0], reach_m: 30 } as unknown as PlanMonitor);
    const parts = shown.values[0] as { values: unknown[] }[];
    expect(parts.map(({ values }) => values[0])).toEqual(['stand', 'roof']);
    const path = String(parts[0]!.values[3]);
    // 10° to each side of north, 300 px long.
    const [x, y] = [Math.sin(Math.PI / 18) * 300, -Math.cos(Math.PI / 18) * 300].map((value) => value.toFixed(2));
    expect(path).toContain(`M-${x} ${y}`);
    expect(path).toContain(`${x} ${y}L0 0Z`);
  });

  it('shows wind and north below what the page has on the picture', () => {
    expect(compassAt({ width: 900, above: 0 })[1]).toBe(34);
    const strip = 72;
    const [x, y] = compassAt({ width: 900, above: strip + 60 });
    expect([x, y - 22 > strip, y + 22 < strip + 60 + 20]).toEqual([866, true, true]);
  });
});
