import { describe, expect, it } from 'vitest';
import type { Flight } from '../../src/hub/jets';
import { Kind, Particles } from '../../src/parts/scene/particles';
import { roughFlight, Track } from '../../src/parts/scene/track';

/** A fall from 8 m over 36 m; over the roof of a tank of 6 m at 28 m. */
const flight: Flight = {
  points: [
    [0, 0, 0],
    [10, 3, 0.3],
    [20, 2, 0.7],
    [28, -2, 1.1],
    [32, -5, 1.4],
    [36, -8, 1.7],
  ],
  lands_m: 36,
  core_m: 15,
  speed_mps: 39,
};
const nozzle = { at: [10, -20] as [number, number], height: 8 };
/** Drawn 3 m ahead and 2 m too high. */
const mouth: [number, number, number] = [10, 10, 17];
const palette = { water: [0, 0, 1], foam: [1, 1, 1], smoke: [0, 0, 0], flame: [1, 0, 0], ember: [1, 1, 0], shine: 0 };

describe('water in three dimensions', () => {
  it('leaves the mouth and comes down where the flight does', () => {
    const track = new Track({ flight, nozzle, bearing: 0, mouth, lands: null, floor: 0 });
    expect(track.at(0)).toEqual(mouth.map((n) => expect.closeTo(n)));
    expect(track.at(track.end_s)).toEqual([10, 0, 20 - 36].map((n) => expect.closeTo(n)));
    expect(track.at(99)).toEqual(track.at(track.end_s));
  });

  it('comes down on a roof, where the plan shows it', () => {
    const lands: [number, number] = [11, 9];
    const track = new Track({ flight, nozzle, bearing: 0, mouth, lands, floor: 6 });
    const [x, y, z] = track.at(track.end_s);
    expect([x, y, z]).toEqual([11, 6, -9].map((n) => expect.closeTo(n)));
    expect(track.end_s).toBeCloseTo(1.1, 1);
  });

  it('is drawn by particles that fall there, within a metre at 28 m', () => {
    const lands: [number, number] = [10, 8];
    const track = new Track({ flight, nozzle, bearing: 0, mouth, lands, floor: 0 });
    const particles = new Particles(100, palette as never);
    const fallen: number[][] = [];
    for (let count = 0; count < 20; count++) {
      particles.add(Kind.Water, { track, stray: [0, 0, 0], age: count / 100, life: track.end_s + 1 });
    }
    for (let step = 0; step < 200; step++) {
      particles.step(
        1 / 60,
        [8, 8],
        () => 0,
        (body) => fallen.push([body.x, -body.z]),
      );
    }
    expect(fallen).toHaveLength(20);
    for (const [x, y] of fallen) expect(Math.hypot(x! - lands[0], y! - lands[1])).toBeLessThan(1);
    expect(particles.count).toBe(0);
  });

  it('that cannot be computed leaves along the barrel, and ends where it is seen to land', () => {
    const flight = roughFlight(30, { way_m: 40, rise_m: -8 });
    const [, first] = flight.points;
    expect(first![1] / first![0], 'along the barrel').toBeCloseTo(Math.tan(Math.PI / 6), 1);
    expect(flight.points.at(-1)).toEqual([40, expect.closeTo(-8), expect.any(Number)]);
    const lands: [number, number] = [10, 20];
    const track = new Track({ flight, nozzle, bearing: 0, mouth, lands, floor: 0 });
    expect(track.at(track.end_s)).toEqual([10, 0, -20].map((n) => expect.closeTo(n)));
    expect(track.end_s).toBeGreaterThan(1);
  });

  it('that cannot be computed has only its beginning, where no end is known', () => {
    const { points } = roughFlight(20, null);
    const [way, rise] = points.at(-1)!;
    expect(Math.hypot(way, rise)).toBeCloseTo(9);
    expect(rise / way).toBeCloseTo(Math.tan(Math.PI / 9));
    const above = roughFlight(0, { way_m: 20, rise_m: 3 });
    expect(above.points.at(-1)![1]).toBeCloseTo(3);
  });
});
