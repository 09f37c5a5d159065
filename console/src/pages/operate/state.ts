// What the operate page reads from a monitor, and why its controls are disabled.
import { validOf } from '../../hub/readings';
import { has, whyNot } from '../../hub/session';
import { store } from '../../hub/store';
import type { Range, Site } from '../../hub/types';
import { age, t } from '../../i18n';
import type { QuenchSector } from '../../parts/geometry';
import type { Holding } from '../../parts/hold';
import { type ShownSite, standAlone } from '../../parts/stand-alone';

/** Where a program without a distance is drawn, m. */
const UNKNOWN_M = 25;

export const AIMED = ['Horizontal', 'Vertical', 'Nozzle'] as const;

/** A value to compute with: null also if a flag marks it as bad. */
export function field(monitor: string, subsystem: string, name: string): number | null {
  return validOf(store.get(`monitors/${monitor}/status`)?.subsystems[subsystem], name);
}

export function position(monitor: string, drive: string): number | null {
  return field(monitor, drive, 'position');
}

export function limits(monitor: string, drive: 'Horizontal' | 'Vertical' | 'Nozzle'): Range | null {
  return store.get(`monitors/${monitor}/limits`)?.[drive] ?? null;
}

/** Whether it has a subsystem; a monitor that has never answered is assumed to have all. */
export function exists(monitor: string, subsystem: string): boolean {
  const status = store.get(`monitors/${monitor}/status`);
  return status?.at_ms ? subsystem in status.subsystems : true;
}

export type Posture = 'deployed' | 'wrapped' | 'deploying' | 'wrapping' | 'between' | 'none' | 'unknown';

export function posture(monitor: string): Posture {
  if (!store.get(`monitors/${monitor}/status`)?.at_ms) return 'unknown';
  if (!exists(monitor, 'Deployer')) return 'none';
  for (const [flag, name] of [
    ['Deployed', 'deployed'],
    ['Wrapped', 'wrapped'],
    ['Deploying', 'deploying'],
    ['Wrapping', 'wrapping'],
  ] as const) {
    if (has(monitor, 'Deployer', flag)) return name;
  }
  return 'between';
}

/** A state that is no longer known: what it was, and how long ago. */
export function wasSo(monitor: string, state: string): string {
  const at_ms = store.get(`monitors/${monitor}/status`)?.at_ms;
  return at_ms ? t('operate.was', { state, age: age(store.now() - at_ms) }) : t('operate.was_unknown', { state });
}

/** Why a drive would not move or a valve not open. */
export function whyNotWork(monitor: string, subsystem: string): string {
  const why = whyNot(monitor, { subsystem });
  if (why) return why;
  if (has(monitor, 'Detector', 'Searching')) return t('operate.why_searching');
  if (has(monitor, 'Detector', 'Justifying')) return t('operate.why_justifying');
  const now = posture(monitor);
  if (now === 'deployed' || now === 'none' || now === 'unknown') return '';
  return t(now === 'wrapped' ? 'operate.why_wrapped' : 'operate.why_between');
}

/** The plan of the site, as far as the hub has one. */
export function configured(): Site | null {
  return (store.get('hub') ?? store.hello?.hub)?.site ?? null;
}

/** The site as configured; a monitor without a known place is alone. */
export function siteOf(monitor: string): ShownSite {
  return standAlone(configured(), store.monitors(), monitor);
}

/** Among things with a place, a monitor without one would point elsewhere than the plan shows. */
export function whyNotAim(monitor: string): string {
  const site = configured();
  if (site && !(monitor in site.monitors)) return t('operate.no_place', { monitor });
  return whyNotWork(monitor, 'Horizontal');
}

/** The numbers of `StartQuench Control centre=… sector=… distance=…`; null: another request, or a stored program. */
export function quenchOf(request: string | null | undefined): Omit<QuenchSector, 'clipped' | 'sector'> | null {
  if (!request?.startsWith('StartQuench')) return null;
  const numbers = (name: string) => new RegExp(`\\b${name}=(-?\\d+)(?:,(-?\\d+))?`).exec(request)?.slice(1).map(Number);
  const [centre, sector, distance] = [numbers('centre'), numbers('sector'), numbers('distance')];
  if (!centre || !sector) return null;
  return {
    centre_arcmin: [centre[0]!, centre[1]!],
    width_arcmin: sector[0]!,
    height_arcmin: sector[1]!,
    distance_m: distance?.[0] || UNKNOWN_M,
  };
}

/** Drives that move, and their targets if known. */
export function limitsReached(monitor: string): Holding {
  const at: Holding = {};
  for (const drive of AIMED) {
    if (has(monitor, drive, 'MaxLimitReached')) at[drive] = 'max';
    else if (has(monitor, drive, 'MinLimitReached')) at[drive] = 'min';
  }
  return at;
}
