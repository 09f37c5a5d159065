// A value of a monitor and its quality. A flag of the dictionary marks a value as bad (a broken sensor, a
// lost unit); a bad value is shown as such, and nothing is computed from it.
import { lang } from '../i18n';
import { flag } from './dictionary';
import { store } from './store';
import type { SubsystemStatus } from './types';

export interface Reading {
  /** In the unit of the wire; null: unknown. */
  value: number | null;
  /** The flag that marks the value as bad; null: it is good. */
  bad: string | null;
}

type Known = { bad?: Record<string, string> } & Record<string, unknown>;

export function readingOf(state: Known | SubsystemStatus | undefined, field: string): Reading {
  const value = state?.[field];
  return { value: typeof value === 'number' ? value : null, bad: state?.bad?.[field] ?? null };
}

/** The value, if it may be used for computing. */
export function validOf(state: Known | SubsystemStatus | undefined, field: string): number | null {
  const { value, bad } = readingOf(state, field);
  return bad === null ? value : null;
}

export function reading(monitor: string, subsystem: string, field: string): Reading {
  return readingOf(store.get(`monitors/${monitor}/status`)?.subsystems[subsystem], field);
}

/** Why a value is bad, as text; empty if it is good. */
export function badText(subsystem: string, { bad }: Reading): string {
  if (bad === null) return '';
  return flag(subsystem, bad)?.meaning[lang()] ?? bad;
}
