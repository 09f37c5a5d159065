// What a plan shows, made from the hub's topics (docs/hub-api.md). Pure.
import { flightOf, reachOf } from '../ballistics';
import { reckon, type HotbedBox } from '../found';
import {
  bearingOf,
  placeAt,
  type Limits,
  type Place,
  type Tank,
  type Wall,
} from '../geometry';

export interface PlanSite {
  monitors: Record<string, { at: Place; heading: number; height: number }>;
  tanks: readonly Tank[];
  walls: readonly Wall[];
}

export interface PlanScene {
  t_s: number;
  wind: Place;
  fires: readonly {
    name: string;
    at: Place;
    size: number;
    base: number;
    burns: boolean;
    heat_kw: number;
    density?: number;
  }[];
  jets: Record<string, { lps: number; lands: Place; litres: number }>;
  splashes: readonly { monitor: string; at: Place; litres: number; foam: number }[];
}

export type Concern = 'normal' | 'notice' | 'warning' | 'alarm';

export interface PlanMonitor {
  id: string;
  at: Place;
  heading: number;
  height: number;
  /** Null: unknown. */
  horizontal_arcmin: number | null;
  vertical_arcmin: number | null;
  nozzle_mm: number | null;
  /** Where it was told to point. */
  target_arcmin?: number | null;
  limits?: { Horizontal?: Limits; Vertical?: Limits } | null;
  /** What the jet reaches at this pressure, else at the usual one. */
  reach_m?: number | null;
  lands?: Place | null;
  pressure_datm?: number;
  water: boolean;
  foam: boolean;
  wrapped: boolean;
  moving: boolean;
  stale: boolean;
  concern: Concern;
  hotbeds: Hotbed[];
}

export interface Hotbed {
  bearing: number;
  width: number;
  distance_m: number;
  brightness: number;
}

interface StatusLike {
  stale: boolean;
  at_ms: number | null;
  subsystems: Record<string, { flags?: string[]; severity?: string } & Record<string, unknown>>;
}

/** At this pressure the reach is told while no water flows: 0.8 MPa. */
export const USUAL_PRESSURE_DATM = 79;
const HOTBED_UNKNOWN_M = 25;
/** Less than this is what drips. */
const SPLASH_LEAST_L = 0.3;

export function planMonitor(
  id: string,
  site: PlanSite,
  topics: {
    status?: StatusLike | null;
    limits?: Record<string, Limits> | null;
    hotbeds?: { list: readonly HotbedBox[] } | null;
    scene?: PlanScene | null;
    down?: boolean;
    /** Diameter of the nozzle's outlet, where it is known. */
    outlet_mm?: number;
  },
): PlanMonitor | null {
  const stand = site.monitors[id];
  if (!stand) return null;
  const { status, limits, hotbeds, scene } = topics;
  const of = (subsystem: string): Record<string, unknown> => status?.subsystems[subsystem] ?? {};
  const number = (subsystem: string, field: string): number | null => {
    const value = of(subsystem)[field];
    return typeof value === 'number' ? value : null;
  };
  const flag = (subsystem: string, name: string): boolean =>
    status?.subsystems[subsystem]?.flags?.includes(name) ?? false;
  const water = flag('Valve1', 'Open') || flag('Valve1', 'Opening');
  const foam = flag('Valve2', 'Open') || flag('Valve2', 'Opening');
  const pressure = number('General', 'pressure') ?? 0;
  const monitor: PlanMonitor = {
    id,
    ...stand,
    horizontal_arcmin: number('Horizontal', 'position'),
    vertical_arcmin: number('Vertical', 'position'),
    nozzle_mm: number('Nozzle', 'position'),
    limits: limits ?? null,
    pressure_datm: pressure,
    water: water || foam,
    foam,
    wrapped: flag('Deployer', 'Wrapped'),
    moving: ['Horizontal', 'Vertical', 'Nozzle', 'Deployer'].some((drive) => flag(drive, 'Move')),
    stale: topics.down === true || !status || status.stale || status.at_ms === null,
    concern: worst(status),
    hotbeds: (hotbeds?.list ?? []).map((box) => hotbedOf(stand, box, site.tanks)),
  };
  const told = pressure > 20 ? pressure : USUAL_PRESSURE_DATM;
  const diameter_mm = topics.outlet_mm;
  monitor.reach_m = reachOf({ pressure_datm: told, nozzle_mm: monitor.nozzle_mm ?? 60, diameter_mm }, stand.height);
  monitor.lands = scene ? simulatedLanding(id, scene) : landing(monitor, diameter_mm);
  return monitor;
}

function worst(status: StatusLike | null | undefined): Concern {
  const order: Concern[] = ['normal', 'notice', 'warning', 'alarm'];
  let found: Concern = 'normal';
  for (const { severity } of Object.values(status?.subsystems ?? {})) {
    const concern = severity === 'info' || severity === 'notice' ? 'normal' : (severity as Concern);
    if (order.indexOf(concern) > order.indexOf(found)) found = concern;
  }
  return found;
}

/** Where water has just come down, which may be a roof on the way; else where it would. */
function simulatedLanding(id: string, scene: PlanScene): Place | null {
  const fallen = scene.splashes.filter(({ monitor }) => monitor === id);
  const litres = fallen.reduce((sum, splash) => sum + splash.litres, 0);
  if (litres < SPLASH_LEAST_L) return scene.jets[id]?.lands ?? null;
  const mean = (axis: 0 | 1): number =>
    fallen.reduce((sum, splash) => sum + splash.at[axis] * splash.litres, 0) / litres;
  return [mean(0), mean(1)];
}

/** Where the jet comes down by calculation, as a real site does not tell. */
function landing(monitor: PlanMonitor, diameter_mm?: number): Place | null {
  const { horizontal_arcmin, vertical_arcmin, nozzle_mm, water, pressure_datm } = monitor;
  if (!water || horizontal_arcmin === null || vertical_arcmin === null) return null;
  const jet = { pressure_datm: pressure_datm ?? 0, nozzle_mm: nozzle_mm ?? 60, diameter_mm };
  const flight = flightOf(jet, vertical_arcmin, monitor.height);
  if (!flight) return null;
  const way = flight.points[flight.points.length - 1]![0];
  return placeAt(monitor.at, bearingOf(monitor.heading, horizontal_arcmin), way);
}

/** Where a hotbed is drawn: as far as it can be reckoned (found.ts). */
export function hotbedOf(
  stand: { at: Place; heading: number; height: number },
  box: HotbedBox,
  tanks: readonly Tank[],
): Hotbed {
  const reckoned = reckon({ at: stand.at, heading: stand.heading, height_m: stand.height }, box, tanks);
  return {
    bearing: bearingOf(stand.heading, (box.x1 + box.x2) / 2),
    width: Math.abs(box.x2 - box.x1) / 60,
    distance_m: 'distance_m' in reckoned ? reckoned.distance_m : HOTBED_UNKNOWN_M,
    brightness: box.brightness,
  };
}

/** Everything that has to be in the picture, with its radius. */
export function placesOf(
  site: PlanSite | null,
  scene: PlanScene | null,
): (readonly [Place, number])[] {
  if (!site) return [];
  return [
    ...Object.values(site.monitors).map(({ at }) => [at, 4] as const),
    ...site.tanks.map(({ at, diameter }) => [at, diameter / 2] as const),
    ...site.walls.flatMap(({ from, to }) => [[from, 1] as const, [to, 1] as const]),
    ...(scene?.fires ?? []).map(({ at, size }) => [at, size / 2] as const),
  ];
}
