// Distance of a found fire spot: a detector reports a direction, not a distance. It follows from the
// tank in that direction, or from the height of the nozzle above the ground and the angle at which the
// foot of the fire is seen. The flatter the angle, the larger the effect of a wrong height.
import {
  bearingOf,
  bearingTo,
  DISTANCE_MAX_M,
  distanceTo,
  type Place,
  placeAt,
  signedDegrees,
  type Tank,
} from './geometry';

/** As in the answer to GetHotbed: arc-minutes. */
export interface HotbedBox {
  x1: number;
  x2: number;
  y1: number;
  y2: number;
  brightness: number;
}

/** Which of them is the one that was chosen: the one that it overlaps most. -1: none, it is gone. */
export function sameOf(all: readonly HotbedBox[], chosen: HotbedBox): number {
  const overlaps = all.map(
    (box) => overlap(box.x1, box.x2, chosen.x1, chosen.x2) * overlap(box.y1, box.y2, chosen.y1, chosen.y2),
  );
  const most = Math.max(0, ...overlaps);
  return most > 0 ? overlaps.indexOf(most) : -1;
}

/** Of two ranges, in wire units; one that touches overlaps by the least. */
function overlap(a1: number, a2: number, b1: number, b2: number): number {
  const [from, to] = [Math.max(Math.min(a1, a2), Math.min(b1, b2)), Math.min(Math.max(a1, a2), Math.max(b1, b2))];
  return to < from ? 0 : to - from + 1;
}

export function brightest(all: readonly HotbedBox[]): number {
  return all.reduce((best, box, n) => (box.brightness > all[best]!.brightness ? n : best), 0);
}

export interface Sight {
  /** Centre, and foot: where the flames meet the burning surface. */
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

/** Best accuracy of a known height, m. */
export const HEIGHT_GIVE_M = 0.5;
/** From this relative error on, the distance is only an estimate. */
const DOUBTFUL = 0.25;
/** At flatter angles the height gives no distance. */
const FLATTEST = (1 / 180) * Math.PI;

export function sightOfBox(box: HotbedBox): Sight {
  return { horizontal_arcmin: Math.round((box.x1 + box.x2) / 2), foot_arcmin: Math.min(box.y1, box.y2) };
}

/** `height_m` null: the height of the nozzle is unknown. */
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

/** An error of half a metre in height changes it so much that it is not reliable. */
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

/** A fire that detectors have found: its computed place, and the monitors that see it. */
export interface Spot {
  at: Place;
  seen_by: string[];
  /** Lines of sight of two monitors cross there; else the distance is computed from one. */
  crossed: boolean;
}

/** A line of sight of a monitor to a fire spot. */
export interface Seen {
  id: string;
  at: Place;
  bearing: number;
  /** As computed from one monitor; null: unknown. */
  distance_m: number | null;
}

/** Lines closer to parallel than this give no distance. */
const CROSSING_LEAST_DEG = 12;
/** Crossings this close to one another, or to a distance that one monitor gives, are one fire. */
const SAME_FIRE_M = 8;

/** Where lines of sight cross, and where one alone has a distance. One line makes one spot at most. */
export function spotsOf(all: readonly Seen[]): Spot[] {
  const crossings = all.flatMap((a, index) =>
    all.slice(index + 1).flatMap((b) => {
      const at = a.id === b.id ? null : crossing(a, b);
      if (!at) return [];
      const off = [a, b].map((one) =>
        one.distance_m === null ? 0 : Math.abs(distanceTo(one.at, at) - one.distance_m),
      );
      return Math.max(...off) > SAME_FIRE_M * 2 ? [] : [{ at, by: [a, b], off: off[0]! + off[1]! }];
    }),
  );
  const used = new Set<Seen>();
  const spots: Spot[] = [];
  for (const { at, by } of crossings.sort((a, b) => a.off - b.off)) {
    const same = spots.find((spot) => distanceTo(spot.at, at) < SAME_FIRE_M);
    if (!same && by.some((one) => used.has(one))) continue;
    by.forEach((one) => used.add(one));
    const ids = by.map(({ id }) => id);
    if (same) same.seen_by = [...new Set([...same.seen_by, ...ids])].sort();
    else spots.push({ at, seen_by: ids.sort(), crossed: true });
  }
  for (const one of all.filter((seen) => !used.has(seen) && seen.distance_m !== null)) {
    spots.push({ at: placeAt(one.at, one.bearing, one.distance_m!), seen_by: [one.id], crossed: false });
  }
  return spots;
}

/** Where two lines of sight cross, ahead of both and no farther than a jet could ever go. */
function crossing(a: Seen, b: Seen): Place | null {
  const turn = ((b.bearing - a.bearing) * Math.PI) / 180;
  if (Math.abs(Math.sin(turn)) < Math.sin((CROSSING_LEAST_DEG * Math.PI) / 180)) return null;
  const between = distanceTo(a.at, b.at);
  const toward = bearingTo(a.at, b.at);
  const far_a = (between * Math.sin(((b.bearing - toward) * Math.PI) / 180)) / Math.sin(turn);
  const far_b = (between * Math.sin(((a.bearing - toward) * Math.PI) / 180)) / Math.sin(turn);
  if (Math.min(far_a, far_b) < 1 || Math.max(far_a, far_b) > DISTANCE_MAX_M) return null;
  return placeAt(a.at, a.bearing, far_a);
}
