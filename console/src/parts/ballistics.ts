// Flight of the jet: the law that the monitor itself aims by (§3.14, ours; docs/physics.md), for
// drawing. A point mass under gravity and a drag that begins when the jet breaks up.

const GRAVITY = 9.80665;
const SPEED2_PER_DATM = 19.0673;
const NARROWEST_MM = 60;
const SLOPE_STEEP = -40;

export interface JetOf {
  /** 0.1 atm, as GetStatus General tells it. */
  pressure_datm: number;
  nozzle_mm: number;
  /** Outlet; parameter NozzleDiameter of Control, 28 mm by default. */
  diameter_mm?: number;
}

export interface Flight {
  /** Level way and height above the nozzle, m, from the nozzle to the landing. */
  points: [way: number, rise: number][];
  /** Path after which the jet has broken up, m. */
  core_m: number;
  speed: number;
}

/** How wide the spray is: 0 a jet, 1 the widest cone. */
export function sprayOf(nozzle_mm: number): number {
  return 1 - Math.min(Math.max(nozzle_mm, 0), NARROWEST_MM) / NARROWEST_MM;
}

/** Half the opening of the cone, degrees: 1° as a jet, 45° at the widest (for the eye). */
export function sprayHalfAngle(nozzle_mm: number): number {
  return 1 + 44 * sprayOf(nozzle_mm) ** 1.5;
}

/** Null where there is no jet to speak of. */
export function flightOf(
  jet: JetOf,
  elevation_arcmin: number,
  above_ground_m: number,
  step_m = 0.5,
): Flight | null {
  if (jet.pressure_datm < 3) return null;
  const diameter = jet.diameter_mm ?? 28;
  const wide = sprayOf(jet.nozzle_mm);
  const bore = diameter / 28;
  const pressure = jet.pressure_datm / 78.954;
  const together = diameter * (bore * pressure) ** 0.32 * (1 - wide) ** 2;
  const length = 21.21 * bore ** 1.192 * pressure ** -0.315;
  const drag = (1 + 9 * wide * wide) / length;
  const core = 0.113 * together;
  const breakup = 1 / Math.max(0.601 * together, 0.2);
  const speed2 = SPEED2_PER_DATM * jet.pressure_datm;
  let slope = Math.tan((Math.min(Math.max(elevation_arcmin, -4800), 4800) / 60) * (Math.PI / 180));
  let slowness = (1 + slope * slope) / speed2;
  let [way, rise, path] = [0, 0, 0];
  const points: [number, number][] = [[0, 0]];
  for (let piece = 0; piece < 400; piece++) {
    const half = 0.5 * step_m;
    const long = Math.sqrt(1 + slope * slope);
    const broken = Math.min(Math.max((path + half * long - core) * breakup, 0), 1) * drag;
    const mid = slowness * (1 + 2 * broken * half * long);
    const midSlope = slope - GRAVITY * slowness * half;
    const midLong = Math.sqrt(1 + midSlope * midSlope);
    const next = rise + midSlope * step_m;
    slope -= GRAVITY * mid * step_m;
    slowness += 2 * broken * mid * midLong * step_m;
    path += midLong * step_m;
    if (next <= -above_ground_m) {
      const part = (rise + above_ground_m) / (rise - next);
      points.push([way + step_m * part, -above_ground_m]);
      break;
    }
    way += step_m;
    rise = next;
    points.push([way, rise]);
    if (!(slope > SLOPE_STEEP)) {
      points.push([way, -above_ground_m]);
      break;
    }
  }
  return { points, core_m: core + 1 / breakup, speed: Math.sqrt(speed2) };
}

/** Level way to where the jet comes down. */
export function rangeOf(jet: JetOf, elevation_arcmin: number, above_ground_m: number): number | null {
  const flight = flightOf(jet, elevation_arcmin, above_ground_m);
  return flight ? flight.points[flight.points.length - 1]![0] : null;
}

/** Height of the jet over the nozzle at a level way; −∞ where it has come down before. */
function riseAt({ points }: Flight, way_m: number): number {
  const next = points.findIndex(([way]) => way >= way_m);
  if (next < 0) return -Infinity;
  if (next === 0) return points[0]![1];
  const [[near, low], [far, high]] = [points[next - 1]!, points[next]!];
  return low + ((high - low) * (way_m - near)) / Math.max(far - near, 1e-9);
}

const FALL_MOST_M = 200;
const FLATTEST_DEG = -60;
const STEEPEST_DEG = 60;

/** The lower of the elevations whose jet passes through a place; null: no jet of this pressure does. */
export function elevationFor(jet: JetOf, way_m: number, rise_m: number): number | null {
  const over = (arcmin: number): number => {
    const flight = flightOf(jet, arcmin, FALL_MOST_M);
    return flight ? riseAt(flight, way_m) - rise_m : -Infinity;
  };
  let low = FLATTEST_DEG * 60;
  for (let degrees = FLATTEST_DEG; degrees <= STEEPEST_DEG; degrees += 2) {
    if (over(degrees * 60) < 0) {
      low = degrees * 60;
      continue;
    }
    let high = degrees * 60;
    while (high - low > 1) {
      const middle = Math.round((low + high) / 2);
      if (over(middle) < 0) low = middle;
      else high = middle;
    }
    return high;
  }
  return null;
}

const REACHES_KEPT = 64;
const reaches = new Map<string, number | null>();

/** The farthest that a jet comes with any elevation. Asked for at every change: remembered. */
export function reachOf(jet: JetOf, above_ground_m: number): number | null {
  const key = `${jet.pressure_datm} ${jet.nozzle_mm} ${jet.diameter_mm} ${above_ground_m}`;
  const known = reaches.get(key);
  if (known !== undefined) return known;
  let best: number | null = null;
  for (let degrees = 10; degrees <= 50; degrees += 2) {
    const range = rangeOf(jet, degrees * 60, above_ground_m);
    if (range !== null && (best === null || range > best)) best = range;
  }
  if (reaches.size >= REACHES_KEPT) reaches.clear();
  reaches.set(key, best);
  return best;
}
