import { describe, expect, it } from 'vitest';
import {
  bearingOf,
  bearingTo,
  boundsOf,
  groundAt,
  horizontalOf,
  inSector,
  type Place,
  placeAt,
  quenchSector,
  roundStep,
  sectorBetween,
  sectorMiddle,
  sightOf,
  signedDegrees,
  toScreen,
  toSite,
  viewOf,
  zoomed,
} from '../../src/parts/geometry';

const stand = { at: [-20, -20] as Place, heading: 45, height: 6 };
const tanks = [{ name: 'T-1', at: [0, 0] as Place, diameter: 10, height: 6 }];

describe('bearing and Horizontal', () => {
  it('turns left for positive positions', () => {
    expect(bearingOf(45, 0)).toBe(45);
    expect(bearingOf(45, 60 * 45)).toBe(0);
    expect(bearingOf(10, 60 * 30)).toBe(340);
    expect(bearingOf(350, -60 * 30)).toBe(20);
  });

  it('is its own inverse inside the limits', () => {
    for (const heading of [0, 45, 312]) {
      for (let position = -10_799; position <= 10_799; position += 611) {
        expect(horizontalOf(heading, bearingOf(heading, position))).toBe(position);
      }
    }
  });

  it('takes the turn that the limits allow', () => {
    const beyond = { min: 0, max: 21_600 };
    expect(horizontalOf(0, 10, beyond)).toBe(21_600 - 600);
    expect(horizontalOf(0, 10, { min: -900, max: 900 })).toBe(-600);
    // No turn within the limits does: the nearest one, so that the caller sees that it is beyond them.
    expect(horizontalOf(0, 90, { min: -900, max: 900 })).toBe(-5400);
  });

  it('knows the quarters', () => {
    expect(bearingTo([0, 0], [0, 5])).toBe(0);
    expect(bearingTo([0, 0], [5, 0])).toBe(90);
    expect(bearingTo([0, 0], [0, -5])).toBe(180);
    expect(bearingTo([0, 0], [-5, 0])).toBe(270);
    expect(signedDegrees(350)).toBe(-10);
    expect(signedDegrees(-180)).toBe(180);
  });
});

describe('sectors', () => {
  it('goes the shorter way round, across north too', () => {
    const one = placeAt([0, 0], 350, 20);
    const other = placeAt([0, 0], 20, 30);
    const sector = sectorBetween([0, 0], one, other);
    expect(sector.bearing).toBeCloseTo(5);
    expect(sector.width).toBeCloseTo(30);
    expect(sector.near_m).toBeCloseTo(20);
    expect(sector.far_m).toBeCloseTo(30);
    expect(sectorBetween([0, 0], other, one)).toEqual(sector);
  });

  it('finds what is in it', () => {
    const sector = { bearing: 5, width: 30, near_m: 20, far_m: 30 };
    expect(inSector([0, 0], sector, placeAt([0, 0], 351, 25))).toBe(true);
    expect(inSector([0, 0], sector, placeAt([0, 0], 349, 25))).toBe(false);
    expect(inSector([0, 0], sector, placeAt([0, 0], 5, 31))).toBe(false);
  });

  it('becomes the numbers of StartQuench: a roof as high as the nozzle', () => {
    const sector = { bearing: 45, width: 6, near_m: 26, far_m: 30 };
    const quench = quenchSector(stand, sector, tanks, null);
    expect(quench.centre_arcmin).toEqual([0, 0]);
    expect(quench.width_arcmin).toBe(360);
    expect(quench.height_arcmin).toBe(60);
    expect(quench.distance_m).toBe(28);
    expect(quench.clipped).toBe(false);
  });

  it('looks down to the ground, and is as high as near and far edge are apart', () => {
    const sector = { bearing: 135, width: 10, near_m: 10, far_m: 20 };
    const quench = quenchSector(stand, sector, tanks, null);
    expect(quench.centre_arcmin[0]).toBe(-5400);
    expect(quench.centre_arcmin[1]).toBe(sightOf(-6, 15));
    expect(quench.centre_arcmin[1]).toBeLessThan(-1200);
    expect(quench.height_arcmin).toBe(sightOf(-6, 20) - sightOf(-6, 10));
  });

  it('says when a part is beyond the limits, and keeps the distance in its byte', () => {
    const limits = { Horizontal: { min: -5400, max: 4200 } };
    const at = (bearing: number, far_m: number) =>
      quenchSector(stand, { bearing, width: 10, near_m: 10, far_m }, tanks, limits);
    expect(at(135 - 5.1, 20).clipped).toBe(false);
    expect(at(135 - 4.9, 20).clipped).toBe(true);
    expect(at(45, 400).distance_m).toBe(127);
    expect(sectorMiddle(at(45, 20).sector)).toBe(15);
  });

  it('knows the surface at a place', () => {
    expect(groundAt([4.9, 0], tanks)).toBe(6);
    expect(groundAt([5.1, 0], tanks)).toBe(0);
  });
});

describe('view', () => {
  it('goes to the screen and back', () => {
    const view = viewOf(
      boundsOf([
        [[0, 0], 5],
        [[30, 10], 2],
      ]),
      800,
      600,
      40,
    );
    for (const place of [
      [0, 0],
      [12.5, -7],
      [30, 10],
    ] as Place[]) {
      const [east, north] = toSite(view, 800, 600, toScreen(view, 800, 600, place));
      expect(east).toBeCloseTo(place[0]);
      expect(north).toBeCloseTo(place[1]);
    }
    // North is up.
    expect(toScreen(view, 800, 600, [0, 10])[1]).toBeLessThan(toScreen(view, 800, 600, [0, 0])[1]);
  });

  it('shows everything', () => {
    const places = [
      [[-20, -20], 4],
      [[33, 30], 5],
    ] as [Place, number][];
    const view = viewOf(boundsOf(places), 500, 300, 30);
    for (const [[east, north], radius] of places) {
      const [x, y] = toScreen(view, 500, 300, [east, north]);
      expect(x - radius * view.scale).toBeGreaterThanOrEqual(29.9);
      expect(x + radius * view.scale).toBeLessThanOrEqual(470.1);
      expect(y - radius * view.scale).toBeGreaterThanOrEqual(29.9);
      expect(y + radius * view.scale).toBeLessThanOrEqual(270.1);
    }
  });

  it('zooms around the pointer', () => {
    const view = { east: 3, north: -4, scale: 8 };
    const under = toSite(view, 800, 600, [200, 150]);
    const next = zoomed(view, 800, 600, [200, 150], 1.7);
    const after = toSite(next, 800, 600, [200, 150]);
    expect(after[0]).toBeCloseTo(under[0]);
    expect(after[1]).toBeCloseTo(under[1]);
    expect(next.scale).toBeCloseTo(13.6);
  });

  it('has round steps', () => {
    expect([0.7, 1, 4.9, 5, 37, 100].map(roundStep)).toEqual([0.5, 1, 2, 5, 20, 100]);
  });
});
