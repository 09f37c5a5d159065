// The zones as the hub's zone controller reports them. They are always those of now, also while a recording is shown:
// a countdown does not wait. Times run on a clock that is not set, from the moment at which a report arrived.
import { type Key, t } from '../i18n';
import type { Role, ZoneConfigured, ZoneState, ZonesView } from './api';
import { may } from './session';
import { LINKED, store } from './store';

/** Water comes or runs, or a test does as if. */
export type Running = 'coincidence' | 'countdown' | 'held' | 'released' | 'test';
export type Phase = 'quiet' | 'alarm' | 'ended' | Running;

/** While a time runs the hub reports each second; after this time without a report nothing is known, ms. */
export const OLD_MS = 3500;

const PLAIN: readonly Phase[] = ['quiet', 'alarm', 'coincidence', 'countdown', 'held'];
/** The most urgent first. */
const RUNNING: readonly Running[] = ['countdown', 'coincidence', 'held', 'released', 'test'];

export function phaseOf({ phase }: ZoneState): Phase {
  if (typeof phase !== 'string') return 'ended' in phase ? 'ended' : phase.released.wet ? 'released' : 'test';
  // A phase of a later hub is shown as the one that requires a look.
  return PLAIN.includes(phase) ? phase : 'alarm';
}

/** Whether water comes or runs, or a test does as if. */
export function isRunning(zone: ZoneState): boolean {
  return RUNNING.some((phase) => phase === phaseOf(zone));
}

export type Time = 'release' | 'hold' | 'water' | 'mode';

/** What is left of a time of a zone, `age_ms` after its report; null: it does not run. */
export function leftOf(zone: ZoneState, time: Time, age_ms: number): number | null {
  const left = { release: zone.left_ms, hold: zone.hold_left_ms, water: zone.water_left_ms, mode: zone.returns_in_ms }[
    time
  ];
  if (left == null) return null;
  const held = phaseOf(zone) === 'held';
  const stands = (time === 'release' && held) || (time === 'hold' && !held);
  return stands ? left : Math.max(0, left - age_ms);
}

/** The zones in which water comes or runs, the most urgent first. */
export function runningOf(view: ZonesView | null): ZoneState[] {
  const rank = (zone: ZoneState) => (RUNNING as readonly string[]).indexOf(phaseOf(zone));
  const left = (zone: ZoneState) => zone.left_ms ?? Infinity;
  const counts = (zone: ZoneState) => rank(zone) < RUNNING.indexOf('held');
  const byUrgency = (a: ZoneState, b: ZoneState) => {
    if (counts(a) && counts(b)) return left(a) - left(b);
    return rank(a) - rank(b);
  };
  return (view?.state.zones ?? []).filter(isRunning).sort(byUrgency);
}

/** Rows in the order in which they appeared, new ones last: what is on its way to one must not hit another. */
export class Appeared {
  private seen: string[] = [];

  inOrder(ids: readonly string[]): string[] {
    const stay = this.seen.filter((id) => ids.includes(id));
    this.seen = [...stay, ...ids.filter((id) => !stay.includes(id))];
    return [...this.seen];
  }
}

/** Whether a hold is renewed; `seen`: the hub has reported it as held. Then a countdown means that it was ended. */
export function goesOn(phase: Phase | null, seen: boolean): boolean {
  return phase === 'held' || phase === 'coincidence' || (phase === 'countdown' && !seen);
}

class Zones {
  private known: ZonesView | null = null;
  private heardAt = 0;
  private lostAt = 0;

  constructor() {
    store.subscribe('zones', () => this.view());
    store.subscribe(LINKED, () => {
      if (!store.linked) this.lostAt = performance.now();
    });
  }

  /** The last report; null: the hub has no zones, or has not reported yet. */
  view(): ZonesView | null {
    const now = store.getLive('zones') ?? null;
    if (now !== this.known) {
      this.known = now;
      this.heardAt = performance.now();
    }
    return now;
  }

  exist(): boolean {
    return this.view() !== null;
  }

  zone(id: string): ZoneState | null {
    return this.view()?.state.zones.find(({ zone }) => zone === id) ?? null;
  }

  /** What belongs to a zone; null: not known yet. */
  configured(id: string): ZoneConfigured | null {
    return store.getLive('zones/configured')?.zones.find(({ zone }) => zone === id) ?? null;
  }

  /** Time since the last report arrived, ms. */
  age(): number {
    this.view();
    return performance.now() - this.heardAt;
  }

  /** For how long the state has not been known, ms; null: it is known. */
  unknownFor(): number | null {
    const view = this.view();
    if (!store.linked) return performance.now() - this.lostAt;
    const age = this.age();
    const runs = view?.state.zones.some((zone) => phaseOf(zone) !== 'quiet') ?? false;
    return runs && age > OLD_MS ? age : null;
  }

  /** What is left of a time now, ms; null: it does not run, or nothing is known. */
  left(id: string, time: Time): number | null {
    const zone = this.zone(id);
    return zone && this.unknownFor() === null ? leftOf(zone, time, this.age()) : null;
  }

  /** Zones with a detector in alarm or more. */
  eventful(): number {
    const is = (zone: ZoneState) => isRunning(zone) || phaseOf(zone) === 'alarm';
    return this.view()?.state.zones.filter(is).length ?? 0;
  }
}

export const zones = new Zones();

/** Why an order would be refused; empty: it is possible. Abort and lockout do not ask. */
export function whyNotOrder(least: Role = 'operator'): string {
  if (store.source === 'replay') return t('why.replay');
  if (!store.linked) return t('why.hub');
  if (!may(least)) return t('why.role', { role: t(`role.${least}` as Key) });
  return '';
}
