// Placement of the monitors' names on the plan: behind the barrel, where nothing of interest is; near
// other monitors or the edge of the picture, on the side where most of them can be read.
import type { Place } from '../geometry';

/** The data of a monitor that place its name. */
export interface Named {
  id: string;
  /** On the screen. */
  at: Place;
  /** Bearing of the barrel, degrees. */
  barrel: number;
}

export const NAME_PX = 20;
const BODY_PX = 24;
/** Minimum distance of a name from its own monitor in a crowd, px. */
const CLOSE_PX = 17;
/** Closer than this to another monitor, px, a name would cover that one's name. */
const CROWD_PX = 130;
/** Clockwise from above, the sides before the corners. */
const SIDES = [0, 90, 180, 270, 45, 135, 225, 315];

export interface Box {
  x: number;
  y: number;
  wide: number;
  high: number;
}

export function nameWidth(id: string): number {
  return Math.max(id.length * 8 + 12, 26);
}

/**
 * The middle of each name, from the middle of its monitor, around which a circle stays clear. `fixed` is what the picture has
 * at its edges: buttons, scale, compass.
 */
export function namePlaces(
  monitors: readonly Named[],
  screen: Place,
  clear: number,
  fixed: readonly Box[] = [],
): Map<string, Place> {
  const places = new Map<string, Place>();
  const names: Box[] = [];
  for (const monitor of [...monitors].sort((a, b) => (a.id < b.id ? -1 : 1))) {
    const others = monitors.filter((other) => other !== monitor && near(other.at, monitor.at));
    const taken = [...fixed, ...names, ...others.map((other) => box(other.at, BODY_PX, BODY_PX))];
    // In a crowd whatever the barrel does: names that jump from side to side would be worse than a covered one.
    const sides = others.length ? SIDES : [monitor.barrel + 180, ...SIDES];
    const tried = [clear, Math.min(clear, CLOSE_PX)].flatMap((radius) =>
      sides.map((side) => toward(monitor, side, radius)),
    );
    const place = least(tried, (one) => hidden(nameBox(monitor, one), taken, screen));
    places.set(monitor.id, place);
    names.push(nameBox(monitor, place));
  }
  return places;
}

/** How much of it covers others or is outside the picture. */
export function hidden(own: Box, taken: readonly Box[], [wide, high]: Place): number {
  const outside = own.wide * own.high - shared(own, { x: 0, y: 0, wide, high });
  return outside + taken.reduce((sum, other) => sum + shared(own, other), 0);
}

/** The first of the best ones. */
function least(places: readonly Place[], cost: (place: Place) => number): Place {
  let best: { place: Place; cost: number } | null = null;
  for (const place of places) {
    const own = cost(place);
    if (own === 0) return place;
    if (!best || own < best.cost) best = { place, cost: own };
  }
  return best!.place;
}

function near(a: Place, b: Place): boolean {
  return Math.hypot(a[0] - b[0], a[1] - b[1]) < CROWD_PX;
}

function toward({ id }: Named, bearing: number, clear: number): Place {
  const angle = (bearing * Math.PI) / 180;
  const [x, y] = [Math.sin(angle), -Math.cos(angle)];
  const off = clear + (Math.abs(x) * nameWidth(id) + Math.abs(y) * NAME_PX) / 2;
  return [x * off, y * off];
}

export function nameBox(monitor: Named, place: Place): Box {
  const at: Place = [monitor.at[0] + place[0], monitor.at[1] + place[1]];
  return box(at, nameWidth(monitor.id), NAME_PX);
}

export function box(middle: Place, wide: number, high: number): Box {
  return { x: middle[0] - wide / 2, y: middle[1] - high / 2, wide, high };
}

function shared(a: Box, b: Box): number {
  const wide = Math.min(a.x + a.wide, b.x + b.wide) - Math.max(a.x, b.x);
  const high = Math.min(a.y + a.high, b.y + b.high) - Math.max(a.y, b.y);
  return wide > 0 && high > 0 ? wide * high : 0;
}
