// The user of this page, and what that user may do now: the one place that says why a control is disabled.
import { type Key, t } from '../i18n';
import { session } from './me';
import { store } from './store';
import type { FlagOf, LinkFigures, Role, SubsystemName } from './types';
import { underUpdate } from './updates';

const RANK: Record<Role, number> = { observer: 0, operator: 1, engineer: 2, administrator: 3 };

export function role(): Role {
  return store.hello?.role ?? session()?.role ?? 'observer';
}

export function may(least: Role): boolean {
  return RANK[role()] >= RANK[least];
}

/** Whether this page holds the authority over a monitor. */
export function inControl(monitor: string): boolean {
  const authority = store.get(`monitors/${monitor}/authority`);
  return authority?.holder != null && authority.holder.seat === store.hello?.seat;
}

/** Whether it is the user of this page, who has logged in: not one of all that come without a login. */
export function isSelf(user: string): boolean {
  return session()?.kind === 'session' && user === store.hello?.user;
}

/** Whether a subsystem has a flag. */
export function has<S extends SubsystemName>(monitor: string, subsystem: S, flag: FlagOf<S>): boolean {
  const status = store.get(`monitors/${monitor}/status`);
  return status?.subsystems[subsystem]?.flags.includes(flag) ?? false;
}

export interface Wants {
  /** The lowest sufficient role; default: operator. */
  role?: Role;
  /** False: it needs no authority (reading, Stop). */
  authority?: boolean;
  /** True: it works during a lockout too. */
  lockedOut?: boolean;
  /** A subsystem that it needs. */
  subsystem?: string;
}

/** Data of the link to a monitor besides its state; not in a recording. */
export function linkFigures(monitor: string): LinkFigures | null {
  const link = store.get(`monitors/${monitor}/link`);
  return link && 'last' in link ? link : null;
}

/** Why a command to this monitor would be refused; empty: it is possible. */
export function whyNot(monitor: string, wants: Wants = {}): string {
  const least = wants.role ?? 'operator';
  if (store.source === 'replay') return t('why.replay');
  if (!store.linked) return t('why.hub');
  if (!may(least)) return t('why.role', { role: t(`role.${least}` as Key) });
  const link = store.get(`monitors/${monitor}/link`);
  if (!link) return t('why.unknown', { monitor });
  if (link.state === 'down') return t('why.link', { monitor });
  if (wants.subsystem) {
    const status = store.get(`monitors/${monitor}/status`);
    if (status?.at_ms && !(wants.subsystem in status.subsystems)) {
      return t('why.subsystem', { subsystem: wants.subsystem });
    }
  }
  if (wants.authority !== false && underUpdate() === monitor) return t('why.updating', { monitor });
  if (wants.authority !== false && store.stale(monitor)) return t('why.stale', { monitor });
  if (wants.authority !== false && !inControl(monitor)) {
    const holder = store.get(`monitors/${monitor}/authority`)?.holder;
    if (!holder) return t('why.authority', { monitor });
    return t(isSelf(holder.user) ? 'why.held_self' : 'why.held', { monitor, user: holder.user });
  }
  if (!wants.lockedOut && has(monitor, 'General', 'LockedOut')) return t('why.locked', { monitor });
  return '';
}
