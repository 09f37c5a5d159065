// Where the water of a monitor is expected to land: the throw with its band, as the hub computes it (the law
// of `lafet throw`). Pure.
import type { JetWind, NoThrow, Struck } from '../../hub/api';
import type { Jet } from '../../hub/jets';
import { t } from '../../i18n';
import { bearingOf, type Place } from '../geometry';

/** A part of a ring around the monitor. */
export interface LandingArea {
  /** Middle of the area, degrees from north, and its opening. */
  bearing: number;
  width: number;
  near_m: number;
  far_m: number;
  /** The middle of the wetted ground, and where the outermost water lands. */
  middle_m: number;
  greatest_m: number;
  /** Computed with the wind; else for still air. */
  with_wind: boolean;
  /** The tank or wall that water strikes before the ground. */
  strikes?: Struck;
}

export type Unknown = 'pressure' | 'direction' | 'law';

/** What of a monitor decides whether and where its water lands. */
export interface Thrower {
  at: Place;
  heading: number;
  water: boolean;
  horizontal_arcmin: number | null;
  vertical_arcmin: number | null;
  /** Null: there is no valid pressure. */
  pressure_datm: number | null;
  /** Null: there is no valid flow. */
  flow_lps: number | null;
}

/** So that a narrow area can be seen, degrees. */
const WIDTH_LEAST = 3;
const WIDTH_MOST = 180;
const DEGREES = 180 / Math.PI;

/** Null: no water flows, or the hub has not answered yet. */
export function landingOf(of: Thrower, jet: Jet | null | undefined): LandingArea | Unknown | null {
  if (!of.water || of.flow_lps === 0) return null;
  if (of.pressure_datm === null) return 'pressure';
  if (of.horizontal_arcmin === null || of.vertical_arcmin === null) return 'direction';
  if (!jet) return null;
  const { throw: thrown, no_throw, throw_strikes } = jet;
  if (!thrown) return no_throw ? WHY[no_throw] : null;
  const { middle_m, greatest_m, left_m, across_m, wind } = thrown;
  const distance = Math.max(middle_m.value, 0.1);
  const turn = (left: number): number => Math.asin(Math.min(Math.max(left / distance, -1), 1)) * DEGREES;
  const half = (turn(left_m.high) - turn(left_m.low)) / 2 + Math.atan2(across_m, distance) * DEGREES;
  return {
    bearing: bearingOf(of.heading, of.horizontal_arcmin) - (turn(left_m.high) + turn(left_m.low)) / 2,
    width: Math.min(Math.max(2 * half, WIDTH_LEAST), WIDTH_MOST),
    near_m: middle_m.low,
    far_m: Math.max(greatest_m.high, middle_m.high),
    middle_m: middle_m.value,
    greatest_m: greatest_m.value,
    with_wind: wind !== null,
    ...(throw_strikes ? { strikes: throw_strikes } : {}),
  };
}

/** What the water strikes, in words. */
export function strikesText({ name, kind, on_top, whole }: Struck): string {
  const what = name || t(`parts.plan.strikes_${kind}`);
  const how = on_top ? 'top' : 'side';
  return t(whole ? `parts.plan.strikes_all_${how}` : `parts.plan.strikes_part_${how}`, { what });
}

const WHY: Record<NoThrow, Unknown> = {
  pressure_unknown: 'pressure',
  elevation_unknown: 'direction',
  pressure: 'law',
  flow: 'law',
  outlet: 'law',
  elevation: 'law',
  height: 'law',
  wind: 'law',
};

/** Steps of the wind in a query: gusts must not cause one with each picture. */
const WIND_STEP_MPS = 0.5;

/** A wind that blows to the east and north, m/s, as a jet with this bearing has it. */
export function windOf([east, north]: Place, bearing: number): JetWind {
  const [sin, cos] = [Math.sin(bearing / DEGREES), Math.cos(bearing / DEGREES)];
  // No -0, which JSON would keep apart from 0.
  const step = (mps: number): number => Math.round(mps / WIND_STEP_MPS) * WIND_STEP_MPS + 0;
  return { along_mps: step(east * sin + north * cos), left_mps: step(north * sin - east * cos) };
}
