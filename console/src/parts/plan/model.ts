// What a plan shows, made from the hub's topics (docs/hub-api.md). Pure.
import type { FirePlace, KeepOut, Struck } from '../../hub/api';
import type { Jet, JetAsked } from '../../hub/jets';
import { validOf } from '../../hub/readings';
import { t } from '../../i18n';
import { type HotbedBox, isDoubtful, reckon, type Spot, spotsOf } from '../found';
import { bearingOf, type Limits, type Place, placeAt, type Tank, type Wall } from '../geometry';
import { type LandingArea, landingOf, type Unknown, windOf } from './landing';

export interface PlanSite {
  monitors: Record<string, { at: Place; heading: number; height: number }>;
  tanks: readonly Tank[];
  walls: readonly Wall[];
  keep_outs: readonly KeepOut[];
  /** Nothing has a place of its own: neither distances between monitors nor directions from north are known. */
  schematic?: boolean;
  /** Monitors whose place is not known. */
  unplaced?: readonly string[];
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
  jets: Record<string, { lps: number; lands: Place | null; litres: number }>;
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
  /** Commanded direction. */
  target_arcmin?: number | null;
  limits?: { Horizontal?: Limits; Vertical?: Limits } | null;
  /** Reach of the jet at this pressure, else at the usual one. */
  reach_m?: number | null;
  lands?: Place | null;
  /** The present flight of the jet, while water flows and its values are known. */
  flight?: Jet['flight'];
  /** The tank or wall that ends the flight before the ground. */
  strikes?: Struck | null;
  /** Where its water is expected to land, or why that is not known; null while none flows. */
  landing?: LandingArea | Unknown | null;
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
  /** The distance is only an estimate. */
  guessed?: boolean;
  brightness: number;
}

interface StatusLike {
  stale: boolean;
  at_ms: number | null;
  subsystems: Record<string, { flags?: string[]; severity?: string } & Record<string, unknown>>;
}

/** Pressure for which the reach is shown while no water flows: 0.8 MPa. */
export const USUAL_PRESSURE_DATM = 79;
/** A pressure above this is before the closed valve: the reach shown is the one that it will give. */
const PRESSED_DATM = 20;
const HOTBED_UNKNOWN_M = 25;
/** Less flow than this only drips. */
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
    /** The hub's answer to `jetAsked`. */
    jet?: Jet | null;
  },
): PlanMonitor | null {
  const stand = site.monitors[id];
  if (!stand) return null;
  const { status, limits, hotbeds, scene } = topics;
  const of = (subsystem: string): Record<string, unknown> => status?.subsystems[subsystem] ?? {};
  const number = (subsystem: string, field: string) => validOf(of(subsystem), field);
  const flag = (subsystem: string, name: string): boolean =>
    status?.subsystems[subsystem]?.flags?.includes(name) ?? false;
  const water = flag('Valve1', 'Open') || flag('Valve1', 'Opening');
  const foam = flag('Valve2', 'Open') || flag('Valve2', 'Opening');
  const pressure_datm = number('General', 'pressure');
  const monitor: PlanMonitor = {
    id,
    ...stand,
    horizontal_arcmin: number('Horizontal', 'position'),
    vertical_arcmin: number('Vertical', 'position'),
    nozzle_mm: number('Nozzle', 'position'),
    limits: limits ?? null,
    pressure_datm: pressure_datm ?? 0,
    water: water || foam,
    foam,
    wrapped: flag('Deployer', 'Wrapped'),
    moving: ['Horizontal', 'Vertical', 'Nozzle', 'Deployer'].some((drive) => flag(drive, 'Move')),
    stale: topics.down === true || !status || status.stale || status.at_ms === null,
    concern: worst(status),
    hotbeds: (hotbeds?.list ?? []).map((box) => hotbedOf(stand, box, site.tanks)),
  };
  const { jet } = topics;
  const flows = monitor.water && monitor.horizontal_arcmin !== null && monitor.vertical_arcmin !== null;
  monitor.reach_m = jet?.reach_m ?? null;
  monitor.flight = flows ? jet?.flight : null;
  monitor.strikes = monitor.flight ? (jet?.strikes ?? null) : null;
  const flow_lps = number('General', 'flowrate');
  monitor.landing = landingOf({ ...monitor, pressure_datm, flow_lps }, jet);
  monitor.lands = scene ? simulatedLanding(monitor, scene) : landing(monitor);
  return monitor;
}

/** Less flow than this is no jet, l/s. */
const JET_LEAST_LPS = 0.3;

/** Whether water comes out of its nozzle; only a simulation says whether an open valve gives any. */
export function flows(monitor: Pick<PlanMonitor, 'id' | 'water'>, scene: PlanScene | null): boolean {
  return scene ? (scene.jets[monitor.id]?.lps ?? 0) > JET_LEAST_LPS : monitor.water;
}

/** How much there is on a site that may end a jet. */
export const built = ({ tanks, walls }: Pick<PlanSite, 'tanks' | 'walls'>): number => tanks.length + walls.length;

/** Steps of the direction in a query, arc-minutes: 0.2 m of 60 m. */
const TURN_STEP_ARCMIN = 10;

/** The query for a monitor's jet; null: nothing is known of it. `built`: tanks and walls of the site. */
export function jetAsked(
  stand: { height: number; heading: number } | undefined,
  status: StatusLike | null | undefined,
  scene: { wind: Place } | null | undefined,
  built = 0,
): JetAsked | null {
  if (!stand || !status) return null;
  const of = (subsystem: string, field: string) => validOf(status.subsystems[subsystem], field);
  const open = (valve: string): boolean => {
    const flags = status.subsystems[valve]?.flags ?? [];
    return flags.includes('Open') || flags.includes('Opening');
  };
  const water = open('Valve1') || open('Valve2');
  const [pressure, elevation] = [of('General', 'pressure'), of('Vertical', 'position')];
  // A jet is not computed from values that are not known.
  if (water && (pressure === null || elevation === null)) return null;
  const horizontal = of('Horizontal', 'position');
  const turned = water && built > 0 && horizontal !== null;
  return {
    pressure_datm: pressure !== null && (water || pressure > PRESSED_DATM) ? pressure : USUAL_PRESSURE_DATM,
    nozzle_mm: of('Nozzle', 'position') ?? 60,
    height_cm: Math.round(stand.height * 100),
    // The reach does not depend on it: no new query while a dry barrel moves.
    elevation_arcmin: water && elevation !== null ? elevation : 0,
    ...(turned ? { horizontal_arcmin: Math.round(horizontal / TURN_STEP_ARCMIN) * TURN_STEP_ARCMIN + 0 } : {}),
    flow_lps: water ? of('General', 'flowrate') : null,
    wind: water && scene ? windOf(scene.wind, bearingOf(stand.heading, of('Horizontal', 'position') ?? 0)) : null,
    live: water,
  };
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

/** Where water has just landed, which may be a roof in between; else where it would land. */
function simulatedLanding(monitor: PlanMonitor, scene: PlanScene): Place | null {
  const { id, strikes } = monitor;
  const fallen = scene.splashes.filter(({ monitor }) => monitor === id);
  const litres = fallen.reduce((sum, splash) => sum + splash.litres, 0);
  // The simulation says where it would land if nothing stood there.
  if (litres < SPLASH_LEAST_L) return strikes ? landing(monitor) : (scene.jets[id]?.lands ?? null);
  const mean = (axis: 0 | 1): number =>
    fallen.reduce((sum, splash) => sum + splash.at[axis] * splash.litres, 0) / litres;
  return [mean(0), mean(1)];
}

/** Computed landing of the jet: a real site does not report it. */
function landing({ flight, strikes, horizontal_arcmin, at, heading }: PlanMonitor): Place | null {
  if (!flight || horizontal_arcmin === null) return null;
  return placeAt(at, bearingOf(heading, horizontal_arcmin), strikes?.way_m ?? flight.lands_m);
}

/** Where a fire spot is drawn, if its distance can be computed (found.ts). */
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
    guessed: !('distance_m' in reckoned) || reckoned.how === 'far' || isDoubtful(reckoned),
    brightness: box.brightness,
  };
}

/** The fires that detectors have found, for a site without a simulation. */
export function foundFires(monitors: readonly PlanMonitor[]): Spot[] {
  const seen = monitors.flatMap(({ id, at, hotbeds }) =>
    hotbeds.map(({ bearing, distance_m, guessed }) => ({ id, at, bearing, distance_m: guessed ? null : distance_m })),
  );
  return spotsOf(seen);
}

/** Everything that must be in the picture, with its radius. */
export function placesOf(site: PlanSite | null, scene: PlanScene | null): (readonly [Place, number])[] {
  if (!site) return [];
  return [
    ...Object.values(site.monitors).map(({ at }) => [at, 4] as const),
    ...site.tanks.map(({ at, diameter }) => [at, diameter / 2] as const),
    ...site.walls.flatMap(({ from, to }) => [[from, 1] as const, [to, 1] as const]),
    ...(scene?.fires ?? []).map(({ at, size }) => [at, size / 2] as const),
  ];
}

/** Radius of a found fire, whose size is not known, m. */
const FOUND_M = 3;

/** Everything that the plan must show: without a simulation with the fires that detectors have found. */
export function shownPlaces(
  site: PlanSite | null,
  scene: PlanScene | null,
  monitors: readonly PlanMonitor[],
  located: readonly FirePlace[],
): (readonly [Place, number])[] {
  const found = scene ? [] : foundFires(monitors).map(({ at }) => [at, FOUND_M] as const);
  const sure = located.filter(({ standing }) => standing === 'sure');
  return [...placesOf(site, scene), ...found, ...sure.map(({ at, major_m }) => [at, major_m] as const)];
}

/** Name of a fire: the tank that it is on, else its number. */
export function fireTitle(name: string, fires: readonly { name: string; at: Place }[], tanks: readonly Tank[]): string {
  const n = fires.findIndex((fire) => fire.name === name);
  const at = fires[n]?.at;
  const tank = tanks.find((one) => at && Math.hypot(one.at[0] - at[0], one.at[1] - at[1]) <= one.diameter / 2);
  return tank?.name || t('parts.plan.fire_n', { n: n + 1 });
}
