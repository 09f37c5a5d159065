// Angles and places of a site. Metres east and north; bearings in degrees clockwise from north;
// angles of the monitor in arc-minutes, left and up positive. A barrel at Horizontal = h points to
// the bearing heading − h/60 (docs/hub-api.md).

export type Place = readonly [east: number, north: number];

const RADIANS = Math.PI / 180;
export const ARCMIN = 60;
/** A record has the distance as an int8: §3.14. */
export const DISTANCE_MAX_M = 127;
/** A sector is 16 bits wide on the wire, and no wider than a turn. */
export const WIDTH_MAX_ARCMIN = 360 * ARCMIN;
/** Minimum height of a drawn sector: a roof seen edge-on would be a line. */
export const HEIGHT_LEAST_ARCMIN = 60;

/** Into −180 (excluded) … 180. */
export function signedDegrees(degrees: number): number {
  const turned = ((degrees % 360) + 360) % 360;
  return turned > 180 ? turned - 360 : turned;
}

/** Into 0 … 360 (excluded). */
export function compass(degrees: number): number {
  return ((degrees % 360) + 360) % 360;
}

export function bearingOf(heading: number, horizontal_arcmin: number): number {
  return compass(heading - horizontal_arcmin / ARCMIN);
}

/** The position of Horizontal that points to a bearing; of several, the one inside the limits. */
export function horizontalOf(heading: number, bearing: number, limits?: Limits | null): number {
  const nearest = Math.round(signedDegrees(heading - bearing) * ARCMIN);
  if (!limits || inside(nearest, limits)) return nearest;
  const turns = [nearest - WIDTH_MAX_ARCMIN, nearest + WIDTH_MAX_ARCMIN];
  return turns.find((turn) => inside(turn, limits)) ?? nearest;
}

export interface Limits {
  min: number;
  max: number;
}

export function inside(value: number, limits: Limits): boolean {
  return value >= limits.min && value <= limits.max;
}

export function bearingTo(from: Place, to: Place): number {
  return compass(Math.atan2(to[0] - from[0], to[1] - from[1]) / RADIANS);
}

export function distanceTo(from: Place, to: Place): number {
  return Math.hypot(to[0] - from[0], to[1] - from[1]);
}

export function placeAt(from: Place, bearing: number, distance_m: number): Place {
  return [from[0] + Math.sin(bearing * RADIANS) * distance_m, from[1] + Math.cos(bearing * RADIANS) * distance_m];
}

/** Angle of the line of sight to something `rise_m` higher than the nozzle. */
export function sightOf(rise_m: number, distance_m: number): number {
  return Math.round((Math.atan2(rise_m, Math.max(distance_m, 0.1)) / RADIANS) * ARCMIN);
}

export interface Tank {
  name: string;
  at: Place;
  diameter: number;
  height: number;
}

export interface Wall {
  name: string;
  from: Place;
  to: Place;
  height: number;
}

/** Height of the surface at a place: the roof of a tank, else the ground. */
export function groundAt(place: Place, tanks: readonly Tank[]): number {
  const under = tanks.filter((tank) => distanceTo(tank.at, place) <= tank.diameter / 2);
  return under.reduce((height, tank) => Math.max(height, tank.height), 0);
}

/** A part of a ring around a monitor: what an operator draws on the plan. */
export interface Sector {
  bearing: number;
  /** Whole opening, degrees. */
  width: number;
  near_m: number;
  far_m: number;
}

/** The arguments of StartQuench Control (§3.14): the numbers of a sector. */
export interface QuenchSector {
  centre_arcmin: [horizontal: number, vertical: number];
  width_arcmin: number;
  height_arcmin: number;
  distance_m: number;
  /** A part is beyond the limits and will be skipped (OutsideLimits). */
  clipped: boolean;
  sector: Sector;
}

/** The sector between two places, as seen from a monitor; of the two ways round, the shorter. */
export function sectorBetween(from: Place, one: Place, other: Place): Sector {
  const first = bearingTo(from, one);
  const turn = signedDegrees(bearingTo(from, other) - first);
  const ranges = [distanceTo(from, one), distanceTo(from, other)].sort((a, b) => a - b);
  return {
    bearing: compass(first + turn / 2),
    width: Math.abs(turn),
    near_m: ranges[0]!,
    far_m: ranges[1]!,
  };
}

export function sectorMiddle(sector: Sector): number {
  return (sector.near_m + sector.far_m) / 2;
}

/** Whether the place is in the sector. */
export function inSector(from: Place, sector: Sector, place: Place): boolean {
  const range = distanceTo(from, place);
  const off = Math.abs(signedDegrees(bearingTo(from, place) - sector.bearing));
  return range >= sector.near_m && range <= sector.far_m && off <= sector.width / 2;
}

export interface Stand {
  at: Place;
  heading: number;
  height: number;
}

/**
 * From a drawing to the request: the centre is the line of sight to the middle, the height is the angle
 * between the lines of sight to the near and to the far edge.
 */
export function quenchSector(
  stand: Stand,
  sector: Sector,
  tanks: readonly Tank[],
  limits?: { Horizontal?: Limits; Vertical?: Limits } | null,
): QuenchSector {
  const distance = Math.min(Math.max(Math.round(sectorMiddle(sector)), 1), DISTANCE_MAX_M);
  const middle = placeAt(stand.at, sector.bearing, sectorMiddle(sector));
  const rise = groundAt(middle, tanks) - stand.height;
  const near = sightOf(rise, sector.near_m);
  const far = sightOf(rise, sector.far_m);
  const horizontal = horizontalOf(stand.heading, sector.bearing, limits?.Horizontal);
  const width = Math.min(Math.round(sector.width * ARCMIN), WIDTH_MAX_ARCMIN);
  const half = width / 2;
  const clipped = limits?.Horizontal
    ? horizontal - half < limits.Horizontal.min || horizontal + half > limits.Horizontal.max
    : false;
  return {
    centre_arcmin: [horizontal, sightOf(rise, sectorMiddle(sector))],
    width_arcmin: width,
    height_arcmin: Math.max(Math.abs(far - near), HEIGHT_LEAST_ARCMIN),
    distance_m: distance,
    clipped,
    sector,
  };
}

/** The sector of a program that runs, for the plan: from the numbers of the request. */
export function sectorOf(stand: Stand, request: Omit<QuenchSector, 'clipped' | 'sector'>): Sector {
  const [horizontal] = request.centre_arcmin;
  return {
    bearing: bearingOf(stand.heading, horizontal),
    width: request.width_arcmin / ARCMIN,
    near_m: Math.max(request.distance_m - 2, 0.5),
    far_m: request.distance_m + 2,
  };
}

export interface Box {
  west: number;
  south: number;
  east: number;
  north: number;
}

/** The view that shows everything, with a margin; never narrower than `least_m`. */
export function boundsOf(places: readonly (readonly [Place, number])[], least_m = 20): Box {
  if (!places.length) return { west: -least_m, south: -least_m, east: least_m, north: least_m };
  const box = { west: Infinity, south: Infinity, east: -Infinity, north: -Infinity };
  for (const [[east, north], radius] of places) {
    box.west = Math.min(box.west, east - radius);
    box.east = Math.max(box.east, east + radius);
    box.south = Math.min(box.south, north - radius);
    box.north = Math.max(box.north, north + radius);
  }
  const wider = Math.max(least_m - (box.east - box.west), 0) / 2;
  const higher = Math.max(least_m - (box.north - box.south), 0) / 2;
  return {
    west: box.west - wider,
    east: box.east + wider,
    south: box.south - higher,
    north: box.north + higher,
  };
}

/** The view of a plan: its centre, and pixels per metre. */
export interface View {
  east: number;
  north: number;
  scale: number;
}

export function viewOf(box: Box, width: number, height: number, margin: number): View {
  const across = Math.max(width - 2 * margin, 40) / (box.east - box.west);
  const up = Math.max(height - 2 * margin, 40) / (box.north - box.south);
  return {
    east: (box.west + box.east) / 2,
    north: (box.south + box.north) / 2,
    scale: Math.min(across, up),
  };
}

export function toScreen(view: View, width: number, height: number, place: Place): Place {
  return [width / 2 + (place[0] - view.east) * view.scale, height / 2 - (place[1] - view.north) * view.scale];
}

export function toSite(view: View, width: number, height: number, point: Place): Place {
  return [view.east + (point[0] - width / 2) / view.scale, view.north - (point[1] - height / 2) / view.scale];
}

/** Zooms so that what is under the point stays there. */
export function zoomed(view: View, width: number, height: number, point: Place, by: number): View {
  const scale = Math.min(Math.max(view.scale * by, 0.5), 60);
  const [east, north] = toSite(view, width, height, point);
  return {
    scale,
    east: east - (point[0] - width / 2) / scale,
    north: north + (point[1] - height / 2) / scale,
  };
}

/** The largest of 1, 2, 5 · 10ⁿ that is not more than `most`. */
export function roundStep(most: number): number {
  const power = 10 ** Math.floor(Math.log10(Math.max(most, 1e-6)));
  const digit = most / power;
  return (digit >= 5 ? 5 : digit >= 2 ? 2 : 1) * power;
}

/** SVG path of a sector around the origin; `y` grows downwards, the bearing from the top. */
export function ringPath(bearing: number, width: number, near: number, far: number): string {
  const opening = Math.min(width, 359.99);
  const [a, b] = [bearing - opening / 2, bearing + opening / 2];
  const large = opening > 180 ? 1 : 0;
  const point = (angle: number, radius: number): string =>
    `${(Math.sin(angle * RADIANS) * radius).toFixed(2)} ${(-Math.cos(angle * RADIANS) * radius).toFixed(2)}`;
  const outer = `M${point(a, far)}A${far.toFixed(2)} ${far.toFixed(2)} 0 ${large} 1 ${point(b, far)}`;
  if (near < 0.01) return `${outer}L0 0Z`;
  return `${outer}L${point(b, near)}A${near.toFixed(2)} ${near.toFixed(2)} 0 ${large} 0 ${point(a, near)}Z`;
}
