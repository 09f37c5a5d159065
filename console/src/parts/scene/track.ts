// The path of water in the picture: the flight computed by the hub, from the nozzle as drawn to the place
// where the plan shows the landing.
import type { Flight } from '../../hub/jets';
import type { Place } from '../geometry';

/** East, up, south: the axes of the scene. */
export type At = [x: number, y: number, z: number];

export interface TrackOf {
  flight: Flight;
  /** The nozzle over the site: where the flight starts. */
  nozzle: { at: Place; height: number };
  /** Degrees from north. */
  bearing: number;
  /** The mouth as drawn: larger than it is. */
  mouth: At;
  /** Where the water lands, as on the plan; null: where the flight ends. */
  lands: Place | null;
  /** Height of the surface there, m. */
  floor: number;
  /** Distance at which the side of a tank or a wall ends it, m. */
  until_m?: number | null;
}

export class Track {
  /** When the water lands, s. */
  readonly end_s: number;
  private readonly points: readonly { at: At; s: number }[];

  constructor({ flight, nozzle, bearing, mouth, lands, floor, until_m }: TrackOf) {
    const angle = (bearing / 180) * Math.PI;
    const [ahead_x, ahead_z] = [Math.sin(angle), -Math.cos(angle)];
    const cut = until_m ? endedAt(flight, until_m) : cutAt(flight, floor - nozzle.height);
    const [whole] = cut[cut.length - 1]!;
    const [x, z] = [nozzle.at[0], -nozzle.at[1]];
    const gap: At = [mouth[0] - x, mouth[1] - nozzle.height, mouth[2] - z];
    const shift = lands ? [lands[0] - x - ahead_x * whole, -lands[1] - z - ahead_z * whole] : [0, 0];
    this.points = cut.map(([way, rise, s]) => {
      const part = whole > 0 ? way / whole : 1;
      // The offset of the enlarged nozzle decreases along the path; the effect of the wind increases along it.
      const [before, after] = [1 - part, part * part];
      return {
        at: [
          x + ahead_x * way + gap[0] * before + shift[0]! * after,
          nozzle.height + rise + gap[1] * before,
          z + ahead_z * way + gap[2] * before + shift[1]! * after,
        ],
        s,
      };
    });
    this.end_s = this.points[this.points.length - 1]!.s;
  }

  /** Where the water is that left the nozzle this long ago. */
  at(seconds: number): At {
    const { points } = this;
    let next = 1;
    while (next < points.length - 1 && points[next]!.s < seconds) next++;
    const [a, b] = [points[next - 1]!, points[next]!];
    const part = Math.min(Math.max((seconds - a.s) / Math.max(b.s - a.s, 1e-6), 0), 1);
    return [0, 1, 2].map((axis) => a.at[axis]! + (b.at[axis]! - a.at[axis]!) * part) as At;
  }
}

/** Water whose end is not known is drawn so far. */
const STUB_M = 9;
/** How fast the drops of what is only drawn run. */
const DRAWN_MPS = 30;
const ROUGH_POINTS = 24;

/**
 * A curve in the place of a flight, while the hub computes none because the pressure is not known: along the barrel at first, and
 * to the place where the water is seen to land; without one only its beginning.
 */
export function roughFlight(elevation_deg: number, lands: { way_m: number; rise_m: number } | null): Flight {
  const angle = (elevation_deg / 180) * Math.PI;
  const way_m = lands?.way_m ?? STUB_M * Math.cos(angle);
  const straight = way_m * Math.tan(angle);
  const fall = lands ? straight - lands.rise_m : 0;
  // A place above the line of the barrel is reached on a straight one.
  const [slope, bend] = fall < 0 ? [lands!.rise_m / way_m, 0] : [straight / way_m, fall / way_m ** 2];
  const points = Array.from({ length: ROUGH_POINTS + 1 }, (_, n): Flight['points'][number] => {
    const way = (way_m * n) / ROUGH_POINTS;
    return [way, slope * way - bend * way ** 2, way / DRAWN_MPS];
  });
  return { points, lands_m: way_m, core_m: way_m, speed_mps: DRAWN_MPS };
}

/** The flight as far as a level distance. */
function endedAt({ points }: Flight, way_m: number): Flight['points'] {
  const beyond = points.findIndex(([way]) => way >= way_m);
  if (beyond <= 0) return points;
  const [before, now] = [points[beyond - 1]!, points[beyond]!];
  const part = (way_m - before[0]) / Math.max(now[0] - before[0], 1e-6);
  const end = before.map((value, axis) => value + (now[axis]! - value) * part) as Flight['points'][number];
  return [...points.slice(0, beyond), end];
}

/** The flight down to a height above the nozzle. */
function cutAt({ points }: Flight, rise_m: number): Flight['points'] {
  const kept: Flight['points'] = [points[0]!];
  for (let index = 1; index < points.length; index++) {
    const [before, now] = [points[index - 1]!, points[index]!];
    if (now[1] < before[1] && now[1] <= rise_m && before[1] >= rise_m) {
      const part = (before[1] - rise_m) / (before[1] - now[1]);
      kept.push(before.map((value, axis) => value + (now[axis]! - value) * part) as Flight['points'][number]);
      return kept;
    }
    kept.push(now);
  }
  return kept;
}
