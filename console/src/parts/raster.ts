// The path of the jet over a sector (docs/protocol.md §3.14): horizontal lines, back and forth, a step
// apart, as many as fit, in the middle of the sector; from the corner nearest to the barrel. Pure.
import type { Limits } from './geometry';

/** A direction, arc-minutes: left and up positive. */
export interface Direction {
  h: number;
  v: number;
}

export interface Sector {
  centre: Direction;
  width: number;
  height: number;
  /** Degrees between the lines; 0: it aims at the centre and stays. */
  step: number;
}

export interface Area {
  right: number;
  left: number;
  bottom: number;
  top: number;
}

export interface DriveLimits {
  Horizontal?: Limits;
  Vertical?: Limits;
}

export function areaOf({ centre, width, height }: Sector): Area {
  const [across, up] = [Math.trunc(width / 2), Math.trunc(height / 2)];
  return {
    right: centre.h - across,
    left: centre.h + across,
    bottom: centre.v - up,
    top: centre.v + up,
  };
}

/** The part inside the limits; null: there is none (§3.14/8). */
export function clip(area: Area, limits: DriveLimits | null | undefined): Area | null {
  const { Horizontal: h, Vertical: v } = limits ?? {};
  if (h && (area.right > h.max || area.left < h.min)) return null;
  if (v && (area.bottom > v.max || area.top < v.min)) return null;
  return {
    right: Math.max(area.right, h?.min ?? -Infinity),
    left: Math.min(area.left, h?.max ?? Infinity),
    bottom: Math.max(area.bottom, v?.min ?? -Infinity),
    top: Math.min(area.top, v?.max ?? Infinity),
  };
}

/** Whether a sector is within the limits. */
export function reach(sector: Sector, limits: DriveLimits | null | undefined): 'inside' | 'partly' | 'outside' {
  const area = areaOf(sector);
  const inside = clip(area, limits);
  if (!inside) return 'outside';
  const same = (['right', 'left', 'bottom', 'top'] as const).every((side) => inside[side] === area[side]);
  return same ? 'inside' : 'partly';
}

export function lineCount(height: number, step: number): number {
  return step > 0 ? Math.trunc(Math.max(height, 0) / (step * 60)) + 1 : 1;
}

/** Ends of the lines of one pass, in the order in which the jet reaches them. */
export function passOver(sector: Sector, limits: DriveLimits | null | undefined, from: Direction): Direction[] {
  const area = clip(areaOf(sector), limits);
  if (!area) return [];
  if (sector.step === 0) return [inLimits(sector.centre, limits)];
  const spacing = sector.step * 60;
  const last = lineCount(area.top - area.bottom, sector.step) - 1;
  const middle = area.bottom + Math.trunc((area.top - area.bottom) / 2);
  const lowest = middle - Math.trunc((last * spacing) / 2);
  let toLeft = from.h < Math.trunc((area.right + area.left) / 2);
  const upwards = from.v < middle;
  const points: Direction[] = [];
  for (let n = 0; n <= last; n += 1) {
    const v = lowest + (upwards ? n : last - n) * spacing;
    const [begin, end] = toLeft ? [area.right, area.left] : [area.left, area.right];
    points.push({ h: begin, v }, { h: end, v });
    toLeft = !toLeft;
  }
  return points;
}

/** Length of a path, arc-minutes. */
export function lengthOf(points: readonly Direction[]): number {
  let sum = 0;
  for (let n = 1; n < points.length; n += 1) {
    sum += Math.hypot(points[n]!.h - points[n - 1]!.h, points[n]!.v - points[n - 1]!.v);
  }
  return sum;
}

export function inLimits(at: Direction, limits: DriveLimits | null | undefined): Direction {
  return { h: clamp(at.h, limits?.Horizontal), v: clamp(at.v, limits?.Vertical) };
}

export function isInside(at: Direction, limits: DriveLimits | null | undefined): boolean {
  const inside = inLimits(at, limits);
  return inside.h === at.h && inside.v === at.v;
}

function clamp(value: number, limits: Limits | undefined): number {
  return limits ? Math.min(Math.max(value, limits.min), limits.max) : value;
}
