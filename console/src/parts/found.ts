// How far a hotbed is that the search has found: a detector tells a direction, no distance. What
// stands in that direction tells it, or the height of the nozzle over the ground and how far down the
// foot of the fire is seen. The flatter that is, the more a wrong height makes of it.
import { bearingOf, bearingTo, DISTANCE_MAX_M, distanceTo, signedDegrees, type Place, type Tank } from './geometry';

/** As GetHotbed tells them: arc-minutes. */
export interface HotbedBox {
  x1: number;
  x2: number;
  y1: number;
  y2: number;
  brightness: number;
}

export interface Sight {
  /** Middle, and foot: where the flames stand on what burns. */
  horizontal_arcmin: number;
  foot_arcmin: number;
}

export type Reckoned = Sight &
  (
    | { how: 'tank'; distance_m: number; give_m: number; tank: string }
    | { how: 'height'; distance_m: number; give_m: number; height_m: number }
    | { how: 'level' }
    | { how: 'no_height' }
    | { how: 'far'; distance_m: number; height_m: number }
  );

/** What a height is known to, at best. */
export const HEIGHT_GIVE_M = 0.5;
/** From so much of the distance on, it is a guess. */
const DOUBTFUL = 0.25;
/** Flatter than this height says nothing. */
const FLATTEST = (1 / 180) * Math.PI;

export function sightOfBox(box: HotbedBox): Sight {
  return { horizontal_arcmin: Math.round((box.x1 + box.x2) / 2), foot_arcmin: Math.min(box.y1, box.y2) };
}

/** `height_m` null: nobody has told how high it stands. */
export function reckon(
  stand: { at: Place; heading: number; height_m: number | null },
  box: HotbedBox,
  tanks: readonly Tank[],
): Reckoned {
  const sight = sightOfBox(box);
  const down = (-sight.foot_arcmin / 60 / 180) * Math.PI;
  const { height_m } = stand;
  const steep = height_m !== null && height_m > 0 && down >= FLATTEST;
  const ground_m = steep ? height_m / Math.tan(down) : null;
  const hit = tankAt(stand, sight.horizontal_arcmin, tanks);
  if (hit && (ground_m === null || hit.range <= ground_m)) {
    return { ...sight, how: 'tank', distance_m: hit.range, give_m: hit.tank.diameter / 2, tank: hit.tank.name };
  }
  if (height_m === null) return { ...sight, how: 'no_height' };
  if (ground_m === null) return { ...sight, how: 'level' };
  if (ground_m > DISTANCE_MAX_M) return { ...sight, how: 'far', distance_m: ground_m, height_m };
  const give_m = (ground_m * HEIGHT_GIVE_M) / height_m;
  return { ...sight, how: 'height', distance_m: ground_m, give_m, height_m };
}

/** Half a metre of height makes so much of it that nobody should rely on it. */
export function isDoubtful(of: Reckoned): boolean {
  return of.how === 'height' && of.give_m > of.distance_m * DOUBTFUL;
}

/** The nearest tank across whose width the line of sight goes. */
function tankAt(stand: { at: Place; heading: number }, horizontal_arcmin: number, tanks: readonly Tank[]) {
  const bearing = bearingOf(stand.heading, horizontal_arcmin);
  return tanks
    .map((tank) => ({ tank, range: distanceTo(stand.at, tank.at) }))
    .filter(({ tank, range }) => {
      const off = Math.abs(signedDegrees(bearingTo(stand.at, tank.at) - bearing));
      return off < 90 && Math.sin((off / 180) * Math.PI) * range <= tank.diameter / 2;
    })
    .sort((a, b) => a.range - b.range)[0];
}
