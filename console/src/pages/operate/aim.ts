// Where a press on the plan aims: by the ballistics of the jet when water flows, else by the line of
// sight. The monitor itself corrects a program so (§3.14), and aims direct on the narrowest jet while
// it has no pressure to reckon with (§3.3.6/5); a Move it takes as it is, so the page reckons.
import { store } from '../../hub/store';
import { t } from '../../i18n';
import { elevationFor } from '../../parts/ballistics';
import type { AimDetail } from '../../parts/lf-plan';
import { bearingText, lengthText } from '../../parts/words';
import { show } from '../../units';
import { field, limits, position } from './state';

/** Less than 1 atm is no jet (as the monitor has it: docs/questions.md). */
const PRESSURE_LEAST_DATM = 10;
const NARROWEST_MM = 60;
const DECIMILLIMETRES = 10;

export interface Aimed {
  Horizontal: number;
  Vertical: number;
  /** What has been reckoned, in words. */
  text: string;
  kind: 'ok' | 'info' | 'warning';
}

/** The outlet of the nozzle as the parameters tell it; undefined: not read. */
export function outlet_mm(monitor: string): number | undefined {
  const told = store.get(`monitors/${monitor}/params`)?.values.Control?.NozzleDiameter?.values?.[0];
  return told === undefined ? undefined : told / DECIMILLIMETRES;
}

/** Whether there is a jet to reckon with. */
export function flows(monitor: string): boolean {
  return (field(monitor, 'General', 'pressure') ?? 0) >= PRESSURE_LEAST_DATM;
}

export function aimAt(monitor: string, at: AimDetail): Aimed {
  const place = { bearing: bearingText(at.bearing), distance: lengthText(at.distance_m) };
  const Horizontal = Math.round(at.horizontal_arcmin);
  const pressure = field(monitor, 'General', 'pressure') ?? 0;
  const sight = Math.round(at.sight_arcmin);
  if (!flows(monitor)) {
    return { Horizontal, Vertical: within(monitor, sight), kind: 'info', text: t('operate.aimed_sight', place) };
  }
  const jet = {
    pressure_datm: pressure,
    nozzle_mm: position(monitor, 'Nozzle') ?? NARROWEST_MM,
    diameter_mm: outlet_mm(monitor),
  };
  const elevation = elevationFor(jet, at.distance_m, at.rise_m);
  if (elevation === null) {
    return { Horizontal, Vertical: within(monitor, sight), kind: 'warning', text: t('operate.aimed_far', place) };
  }
  const Vertical = within(monitor, elevation);
  const told = { ...place, elevation: show('angle', Vertical), pressure: show('pressure', pressure) };
  return { Horizontal, Vertical, kind: 'ok', text: t('operate.aimed_jet', told) };
}

function within(monitor: string, elevation: number): number {
  const range = limits(monitor, 'Vertical');
  return range ? Math.min(Math.max(elevation, range.min), range.max) : elevation;
}
