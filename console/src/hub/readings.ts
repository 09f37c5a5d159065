// A value of a monitor and what it is worth. A flag of the dictionary says that a value is bad (a broken sensor, a
// lost unit); what is bad is shown as such, and nothing computes with it.
import { lang } from '../i18n';
import { flag } from './dictionary';
import { store } from './store';
import type { SubsystemStatus } from './types';

export interface Reading {
  /** In the unit of the wire; null: unknown. */
  value: number | null;
  /** The flag that says that the value is bad; null: none does. */
  bad: string | null;
}

type Known = { bad?: Record<string, string> } & Record<string, unknown>;

export function readingOf(state: Known | SubsystemStatus | undefined, field: string): Reading {
  const value = state?.[field];
  return { value: typeof value === 'number' ? value : null, bad: state?.bad?.[field] ?? null };
}

/** The value, where it may be computed with. */
export function validOf(state: Known | SubsystemStatus | undefined, field: string): number | null {
  const { value, bad } = readingOf(state, field);
  return bad === null ? value : null;
}

export function reading(monitor: string, subsystem: string, field: string): Reading {
  return readingOf(store.get(`monitors/${monitor}/status`)?.subsystems[subsystem], field);
}

/** Why a value is bad, in words; empty where it is not. */
export function badText(subsystem: string, { bad }: Reading): string {
  if (bad === null) return '';
  return flag(subsystem, bad)?.meaning[lang()] ?? bad;
}
