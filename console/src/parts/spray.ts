// How wide a spray is drawn, by the position of the nozzle: for display only.
const NARROWEST_MM = 60;

/** 0 a jet, 1 the widest cone. */
export function sprayOf(nozzle_mm: number): number {
  return 1 - Math.min(Math.max(nozzle_mm, 0), NARROWEST_MM) / NARROWEST_MM;
}

/** Half the opening of the cone, degrees: 1° as a jet, 45° at the widest. */
export function sprayHalfAngle(nozzle_mm: number): number {
  return 1 + 44 * sprayOf(nozzle_mm) ** 1.5;
}
