// Changes of a drawn sector by dragging. Pure.
import { areaOf, type Direction, type Sector } from './raster';

export type SectorGrip = 'move' | 'left' | 'right' | 'top' | 'bottom';
/** `sector` when the pointer is released, `sector-change` meanwhile. */
export type SectorDetail = Pick<Sector, 'centre' | 'width' | 'height'>;

/** An angle is 16 bits wide on the wire. */
export const ANGLE_MOST = 32767;

/** A sector after one of its grips has been pulled; the opposite edge stays. */
export function pulled(sector: Sector, grip: SectorGrip, by: Direction): SectorDetail {
  const area = areaOf(sector);
  if (grip === 'move') {
    const centre = whole({ h: sector.centre.h + by.h, v: sector.centre.v + by.v });
    return { centre, width: sector.width, height: sector.height };
  }
  const side = { left: area.left, right: area.right, top: area.top, bottom: area.bottom };
  side[grip] += grip === 'left' || grip === 'right' ? by.h : by.v;
  if (grip === 'left') side.left = Math.max(side.left, side.right);
  if (grip === 'right') side.right = Math.min(side.right, side.left);
  if (grip === 'top') side.top = Math.max(side.top, side.bottom);
  if (grip === 'bottom') side.bottom = Math.min(side.bottom, side.top);
  // Halves on both sides of a whole centre: sizes are even.
  const width = even(side.left - side.right);
  const height = even(side.top - side.bottom);
  const centre = {
    h: grip === 'left' ? side.right + width / 2 : grip === 'right' ? side.left - width / 2 : sector.centre.h,
    v: grip === 'bottom' ? side.top - height / 2 : grip === 'top' ? side.bottom + height / 2 : sector.centre.v,
  };
  return { centre: whole(centre), width, height };
}

function even(size: number): number {
  return Math.min(Math.max(2 * Math.round(size / 2), 0), ANGLE_MOST - 1);
}

export function whole({ h, v }: Direction): Direction {
  const one = (value: number) => Math.min(Math.max(Math.round(value), -ANGLE_MOST), ANGLE_MOST);
  return { h: one(h), v: one(v) };
}
