// Where a press on the plan aims: by the jet while water flows, else by the line of sight. The monitor itself
// corrects a program in this way (§3.14), and aims directly without a valid pressure (§3.3.6/5). It executes a
// Move uncorrected, so the hub computes the elevation, with the monitor's own code.
import type { NoJet } from '../../hub/api';
import { jets, solve } from '../../hub/jets';
import { store } from '../../hub/store';
import type { Site } from '../../hub/types';
import { t } from '../../i18n';
import { type AimDetail, built, jetAsked } from '../../parts/lf-plan';
import { bearingText, lengthText } from '../../parts/words';
import { show } from '../../units';
import { field, limits } from './state';

/** An answer that took longer, ms, causes no motion: the operator no longer expects it. */
export const SOLVED_MOST_MS = 1000;

export interface Aimed {
  Horizontal: number;
  Vertical: number;
  /** The computed aim, as text. */
  text: string;
  kind: 'ok' | 'info' | 'warning';
}

/** The pressure has no valid value: nothing is aimed until the operator gives one. */
export const UNKNOWN = 'pressure_unknown';

/** Whether there is a jet to aim. */
export function flows(monitor: string, site: Site): boolean {
  const asked = jetAsked(
    site.monitors[monitor],
    store.get(`monitors/${monitor}/status`),
    store.get('scene'),
    built(site),
  );
  if (!asked || asked.pressure_datm !== field(monitor, 'General', 'pressure')) return false;
  return (jets.of(monitor, asked)?.reach_m ?? null) !== null;
}

export async function aimAt(monitor: string, at: AimDetail, pressure_datm?: number): Promise<Aimed | typeof UNKNOWN> {
  const {
    elevation_arcmin,
    fault,
    pressure_datm: pressure,
  } = await solve(monitor, {
    way_m: at.distance_m,
    rise_m: at.rise_m,
    ...(pressure_datm === undefined ? {} : { pressure_datm }),
  });
  if (fault === UNKNOWN) return UNKNOWN;
  const place = { bearing: bearingText(at.bearing), distance: lengthText(at.distance_m) };
  const Horizontal = Math.round(at.horizontal_arcmin);
  if (elevation_arcmin === null) {
    const far = FAR.includes(fault);
    return {
      Horizontal,
      Vertical: within(monitor, Math.round(at.sight_arcmin)),
      kind: far ? 'warning' : 'info',
      text: t(far ? 'operate.aimed_far' : 'operate.aimed_sight', place),
    };
  }
  const Vertical = within(monitor, elevation_arcmin);
  const told = { ...place, elevation: show('angle', Vertical), pressure: show('pressure', pressure!) };
  return { Horizontal, Vertical, kind: 'ok', text: t('operate.aimed_jet', told) };
}

const FAR: readonly (NoJet | null)[] = ['range', 'angle'];

function within(monitor: string, elevation: number): number {
  const range = limits(monitor, 'Vertical');
  return range ? Math.min(Math.max(elevation, range.min), range.max) : elevation;
}
