import { describe, expect, it } from 'vitest';
import type { LandingArea } from '../../src/parts/plan/landing';
import { Area } from '../../src/parts/scene/area';

const AREA: LandingArea = {
  bearing: 90,
  width: 20,
  near_m: 20,
  far_m: 40,
  middle_m: 28,
  greatest_m: 36,
  with_wind: true,
};

/** Bearing and distance of each corner from the monitor, and its height. */
function corners(area: Area, [east, north]: readonly [number, number]) {
  const places = area.mesh.geometry.getAttribute('position');
  return Array.from({ length: places.count }, (_, n) => {
    const [x, y] = [places.getX(n) - east, -places.getZ(n) - north];
    return { bearing: (Math.atan2(x, y) * 180) / Math.PI, range: Math.hypot(x, y), height: places.getY(n) };
  });
}

describe('the landing area in 3D', () => {
  it('lies where the plan has it, on the ground, around its monitor', () => {
    const area = new Area('#08f');
    area.set([5, -7], AREA);
    const all = corners(area, [5, -7]);
    expect(area.mesh.visible).toBe(true);
    expect(Math.min(...all.map(({ bearing }) => bearing))).toBeCloseTo(80, 3);
    expect(Math.max(...all.map(({ bearing }) => bearing))).toBeCloseTo(100, 3);
    for (const [n, { range, height }] of all.entries()) {
      expect(range).toBeCloseTo(n % 2 ? 40 : 20, 3);
      expect(height).toBeGreaterThan(0);
      expect(height).toBeLessThan(0.2);
    }
  });

  it('covers the whole of it: every triangle has an area, and none leaves the ring', () => {
    const area = new Area('#08f');
    area.set([0, 0], AREA);
    const places = area.mesh.geometry.getAttribute('position');
    const index = area.mesh.geometry.getIndex()!;
    let covered = 0;
    for (let n = 0; n < index.count; n += 3) {
      const [a, b, c] = [0, 1, 2].map((k) => index.getX(n + k)).map((k) => [places.getX(k), places.getZ(k)] as const);
      const twice = Math.abs((b![0] - a![0]) * (c![1] - a![1]) - (c![0] - a![0]) * (b![1] - a![1]));
      expect(twice).toBeGreaterThan(0.01);
      covered += twice / 2;
    }
    const ring = (Math.PI * (40 ** 2 - 20 ** 2) * 20) / 360;
    expect(covered / ring).toBeCloseTo(1, 2);
  });

  it('is taken away when the place is not known', () => {
    const area = new Area('#08f');
    area.set([0, 0], AREA);
    area.set([0, 0], null);
    expect(area.mesh.visible).toBe(false);
  });
});
