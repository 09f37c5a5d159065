// Where the names of the monitors stand on the plan: behind the barrel, where nothing of interest
// is; where monitors crowd, at that side where they cover the least of names and monitors.
import { bearingOf, type Place } from '../geometry';

/** What of a monitor its name has to know. */
export interface Named {
  id: string;
  /** On the screen. */
  at: Place;
  heading: number;
  horizontal_arcmin: number | null;
}

export const NAME_PX = 20;
const BODY_PX = 24;
/** So near another monitor a name would be in the way of its name. */
const CROWD_PX = 130;
/** Clockwise from above, the sides before the corners. */
const SIDES = [0, 90, 180, 270, 45, 135, 225, 315];

interface Box {
  x: number;
  y: number;
  wide: number;
  high: number;
}

export function nameWidth(id: string): number {
  return Math.max(id.length * 8 + 12, 26);
}

/** The middle of each name, from the middle of its monitor; `away` is how far it stands off. */
export function namePlaces(monitors: readonly Named[], away: number): Map<string, Place> {
  const places = new Map<string, Place>();
  const taken: Box[] = [];
  for (const monitor of [...monitors].sort((a, b) => (a.id < b.id ? -1 : 1))) {
    const others = monitors.filter((other) => other !== monitor && near(other.at, monitor.at));
    const place = others.length
      ? freest(monitor, [...taken, ...others.map((other) => box(other.at, BODY_PX, BODY_PX))], away)
      : toward(bearingOf(monitor.heading, monitor.horizontal_arcmin ?? 0) + 180, away);
    places.set(monitor.id, place);
    taken.push(nameBox(monitor, place));
  }
  return places;
}

/** Fixed while the barrel turns: names that jump from side to side would be worse than a covered one. */
function freest(monitor: Named, taken: readonly Box[], away: number): Place {
  let best = { place: [0, 0] as Place, covered: Infinity };
  for (const off of [away, away * 0.6]) {
    for (const side of SIDES) {
      const place = toward(side, off);
      const own = nameBox(monitor, place);
      const covered = taken.reduce((sum, other) => sum + shared(own, other), 0);
      if (covered < best.covered) best = { place, covered };
    }
  }
  return best.place;
}

function near(a: Place, b: Place): boolean {
  return Math.hypot(a[0] - b[0], a[1] - b[1]) < CROWD_PX;
}

function toward(bearing: number, off: number): Place {
  const angle = (bearing * Math.PI) / 180;
  return [Math.sin(angle) * off, -Math.cos(angle) * off];
}

function nameBox(monitor: Named, place: Place): Box {
  const at: Place = [monitor.at[0] + place[0], monitor.at[1] + place[1]];
  return box(at, nameWidth(monitor.id), NAME_PX);
}

function box(middle: Place, wide: number, high: number): Box {
  return { x: middle[0] - wide / 2, y: middle[1] - high / 2, wide, high };
}

function shared(a: Box, b: Box): number {
  const wide = Math.min(a.x + a.wide, b.x + b.wide) - Math.max(a.x, b.x);
  const high = Math.min(a.y + a.high, b.y + b.high) - Math.max(a.y, b.y);
  return wide > 0 && high > 0 ? wide * high : 0;
}
