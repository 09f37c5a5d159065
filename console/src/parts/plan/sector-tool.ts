// Drawing a sector: five handles, each of them a slider for the keyboard.
import {
  ARCMIN,
  bearingTo,
  compass,
  distanceTo,
  type Place,
  placeAt,
  type Sector,
  sectorBetween,
  sectorMiddle,
  signedDegrees,
} from '../geometry';

export type Grip = 'move' | 'left' | 'right' | 'near' | 'far';
export const GRIPS: readonly Grip[] = ['move', 'left', 'right', 'near', 'far'];

const WIDTH_MIN = 0.5;
const WIDTH_MAX = 350;
const DEPTH_MIN_M = 0.5;
const NEAR_MIN_M = 1;
const FAR_MAX_M = 150;
/** The sector of a click without a drag, and of Enter. */
export const USUAL: Pick<Sector, 'width'> & { depth_m: number } = { width: 6, depth_m: 4 };

export function usualSector(from: Place, at: Place): Sector {
  const range = Math.max(distanceTo(from, at), 3);
  return tidy({
    bearing: bearingTo(from, at),
    width: USUAL.width,
    near_m: range - USUAL.depth_m / 2,
    far_m: range + USUAL.depth_m / 2,
  });
}

/** The sector of a drag from one place to another: never only a line. */
export function drawnSector(from: Place, one: Place, other: Place): Sector {
  const sector = sectorBetween(from, one, other);
  const middle = sectorMiddle(sector);
  const half = Math.max((sector.far_m - sector.near_m) / 2, USUAL.depth_m / 2);
  return { ...sector, near_m: middle - half, far_m: middle + half };
}

/** Where a handle is. */
export function gripAt(from: Place, sector: Sector, grip: Grip): Place {
  const middle = sectorMiddle(sector);
  const half = sector.width / 2;
  switch (grip) {
    case 'move':
      return placeAt(from, sector.bearing, middle);
    case 'left':
      return placeAt(from, sector.bearing - half, middle);
    case 'right':
      return placeAt(from, sector.bearing + half, middle);
    case 'near':
      return placeAt(from, sector.bearing, sector.near_m);
    case 'far':
      return placeAt(from, sector.bearing, sector.far_m);
  }
}

/** The sector after a handle was dragged to a place. */
export function dragged(from: Place, sector: Sector, grip: Grip, to: Place): Sector {
  const bearing = bearingTo(from, to);
  const range = distanceTo(from, to);
  switch (grip) {
    case 'move':
      return moved(sector, signedDegrees(bearing - sector.bearing), range - sectorMiddle(sector));
    case 'left':
      return edge(sector, 'left', signedDegrees(bearing - (sector.bearing - sector.width / 2)));
    case 'right':
      return edge(sector, 'right', signedDegrees(bearing - (sector.bearing + sector.width / 2)));
    case 'near':
      return tidy({ ...sector, near_m: Math.min(range, sector.far_m - DEPTH_MIN_M) });
    case 'far':
      return tidy({ ...sector, far_m: Math.max(range, sector.near_m + DEPTH_MIN_M) });
  }
}

/** The sector after an arrow key on a handle; null when the key means nothing there. */
export function keyed(sector: Sector, grip: Grip, key: string, shift: boolean): Sector | null {
  const turn = shift ? 5 : 1;
  const way = shift ? 5 : 0.5;
  const sideways = key === 'ArrowLeft' ? -turn : key === 'ArrowRight' ? turn : 0;
  const outward = key === 'ArrowUp' ? way : key === 'ArrowDown' ? -way : 0;
  if (!sideways && !outward) return null;
  switch (grip) {
    case 'move':
      return moved(sector, sideways, outward);
    case 'left':
    case 'right':
      return sideways ? edge(sector, grip, sideways) : null;
    case 'near':
      return tidy({ ...sector, near_m: sector.near_m + (outward || sideways / 2) });
    case 'far':
      return tidy({ ...sector, far_m: sector.far_m + (outward || sideways / 2) });
  }
}

function moved(sector: Sector, turn: number, way: number): Sector {
  const depth = sector.far_m - sector.near_m;
  const near = Math.min(Math.max(sector.near_m + way, NEAR_MIN_M), FAR_MAX_M - depth);
  return { ...sector, bearing: compass(sector.bearing + turn), near_m: near, far_m: near + depth };
}

/** One edge moves, the other stays. */
function edge(sector: Sector, side: 'left' | 'right', turn: number): Sector {
  const sign = side === 'left' ? -1 : 1;
  const width = Math.min(Math.max(sector.width + sign * turn, WIDTH_MIN), WIDTH_MAX);
  const grown = width - sector.width;
  return { ...sector, width, bearing: compass(sector.bearing + (sign * grown) / 2) };
}

export function tidy(sector: Sector): Sector {
  const width = Math.min(Math.max(sector.width, WIDTH_MIN), WIDTH_MAX);
  let near = Math.max(sector.near_m, NEAR_MIN_M);
  let far = Math.min(Math.max(sector.far_m, near + DEPTH_MIN_M), FAR_MAX_M);
  near = Math.min(near, far - DEPTH_MIN_M);
  far = Math.max(far, near + DEPTH_MIN_M);
  // Whole arc-minutes, so that what is drawn is what is sent.
  return {
    bearing: Math.round(sector.bearing * ARCMIN) / ARCMIN,
    width: Math.round(width * ARCMIN) / ARCMIN,
    near_m: near,
    far_m: far,
  };
}
