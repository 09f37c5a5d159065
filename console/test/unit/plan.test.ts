import { describe, expect, it } from 'vitest';
import { compassAt } from '../../src/parts/plan/layers';
import { type PlanMonitor, type PlanScene, type PlanSite, shownPlaces } from '../../src/parts/plan/model';

const SITE: PlanSite = {
  monitors: { M1: { at: [0, 0], heading: 0, height: 6 }, M2: { at: [40, 0], heading: 0, height: 6 } },
  tanks: [],
  walls: [],
};
const sees = (id: string, at: [number, number], bearing: number) =>
  ({ id, at, hotbeds: [{ bearing, distance_m: null, guessed: false }] }) as unknown as PlanMonitor;

describe('the plan', () => {
  it('has room for a fire that detectors have found, where no simulation names it', () => {
    const monitors = [sees('M1', [0, 0], 30), sees('M2', [40, 0], 330)];
    const north = (scene: PlanScene | null) => Math.max(...shownPlaces(SITE, scene, monitors).map(([at]) => at[1]));
    expect(north(null)).toBeCloseTo(34.6, 1);
    expect(north({ fires: [] } as unknown as PlanScene)).toBe(0);
  });

  it('shows wind and north below what the page has on the picture', () => {
    expect(compassAt({ width: 900, above: 0 })[1]).toBe(34);
    const strip = 72;
    const [x, y] = compassAt({ width: 900, above: strip + 60 });
    expect([x, y - 22 > strip, y + 22 < strip + 60 + 20]).toEqual([866, true, true]);
  });
});
