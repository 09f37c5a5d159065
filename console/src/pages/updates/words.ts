// Images, states of a run and what it would miss, in words.
import type { MonitorUpdate, StoredImage, UpdateRun } from '../../hub/types';
import { age, num, t } from '../../i18n';
import type { IconName } from '../../parts/icons';
import type { ChipKind } from '../../parts/lf-chip';
import { subsystemName } from '../../shell/request';
import { type Choice, type Missing, percentOf, resultsOf, slotsOf } from './model';

const LOOKS: Record<MonitorUpdate['state'], { kind: ChipKind; icon: IconName }> = {
  waiting: { kind: 'normal', icon: 'clock' },
  checking: { kind: 'accent', icon: 'refresh' },
  locking: { kind: 'accent', icon: 'lock' },
  updating: { kind: 'accent', icon: 'download' },
  unlocking: { kind: 'accent', icon: 'unlock' },
  done: { kind: 'normal', icon: 'check' },
  same: { kind: 'normal', icon: 'check' },
  failed: { kind: 'high', icon: 'warning' },
  skipped: { kind: 'low', icon: 'minus' },
};

export function looksOf({ state }: MonitorUpdate): { kind: ChipKind; icon: IconName } {
  // A state of a later hub is shown as one that goes on.
  return LOOKS[state] ?? LOOKS.checking;
}

export function stateWords({ state }: MonitorUpdate): string {
  return t(`updates.state_${state}`);
}

/** Stage, percent, time left; empty: none of them is known. */
export function stageWords(one: MonitorUpdate): string {
  if (one.state !== 'updating' || one.stage === null) return '';
  const percent = one.stage === 'sending' ? percentOf(one) : null;
  return [
    t(`updates.stage_${one.stage}`),
    percent === null ? '' : t('updates.percent', { n: num(percent) }),
    one.stage !== 'sending' || one.left_s === null ? '' : t('updates.left', { age: age(one.left_s * 1000) }),
  ]
    .filter(Boolean)
    .join(' · ');
}

/** 1.0.0.0 → 1.2.0.0, or the one that is known. */
export function versionsWords({ from, to }: MonitorUpdate): string {
  return [from, to].filter((one, n, both) => one !== null && (n === 0 || one !== both[0])).join(' → ');
}

/** “3 updated · 1 failed · 2 not done”. */
export function resultWords(run: UpdateRun): string {
  return resultsOf(run)
    .map(([result, n]) => t(`updates.result_${result}`, { n: num(n) }))
    .join(' · ');
}

export function slotWords({ slot }: Pick<StoredImage, 'slot'>): string {
  return t(`updates.slot_${slot ?? 'any'}`);
}

export function choiceSlots(choice: Choice): string {
  return t(`updates.slots_${slotsOf(choice)}`);
}

/** The beginning of a digest: enough to tell images apart. */
export function shortDigest(digest: string): string {
  return digest.slice(0, 8);
}

export function missingWords(missing: Missing): string {
  switch (missing.what) {
    case 'valve':
      return t('updates.missing_valve', { valve: subsystemName(missing.valve) });
    case 'held':
      return t('updates.missing_held', { user: missing.user });
    case 'zone':
      return t('updates.missing_zone', { zone: missing.zone });
    case 'other':
      return t('updates.missing_other', { monitor: missing.monitor, zone: missing.zone });
    default:
      return t(`updates.missing_${missing.what}`);
  }
}
