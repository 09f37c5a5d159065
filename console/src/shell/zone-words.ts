// States of zones, detectors and monitors in words: what the hub reports, no more.
import type {
  DetectorState,
  DetectorUnable,
  ZoneEnd,
  ZoneMonitorState,
  ZoneNotReleased,
  ZoneState,
  ZonesState,
} from '../hub/api';
import { store } from '../hub/store';
import { type Phase, phaseOf, type Time } from '../hub/zones';
import { age, type Key, num, t } from '../i18n';
import type { IconName } from '../parts/icons';
import type { ChipKind } from '../parts/lf-chip';

const LOOKS: Record<Phase, { kind: ChipKind; icon: IconName }> = {
  quiet: { kind: 'normal', icon: 'check' },
  alarm: { kind: 'medium', icon: 'fire' },
  coincidence: { kind: 'fire', icon: 'clock' },
  countdown: { kind: 'fire', icon: 'clock' },
  held: { kind: 'medium', icon: 'pause' },
  released: { kind: 'fire', icon: 'water' },
  test: { kind: 'accent', icon: 'simulation' },
  ended: { kind: 'medium', icon: 'lock' },
};

export function looksOf(zone: ZoneState): { kind: ChipKind; icon: IconName } {
  if (phaseOf(zone) === 'quiet' && !zone.ready) return { kind: 'medium', icon: 'warning' };
  return LOOKS[phaseOf(zone)];
}

/** Phase, or that it is not ready. */
export function phaseWords(zone: ZoneState): string {
  const phase = phaseOf(zone);
  if (phase === 'quiet') return t(zone.ready ? 'zones.phase_quiet' : 'zones.not_ready');
  if (phase === 'alarm') return votesWords(zone);
  if (phase === 'ended') return t('zones.phase_ended', { why: whyEnded(zone) });
  return t(`zones.phase_${phase}`);
}

/** Alarm: one of two votes. */
function votesWords({ votes, need }: ZoneState): string {
  if (need == null) return t('zones.alarm_only');
  return t('zones.phase_alarm', { have: votes.length, need });
}

function whyEnded({ phase }: ZoneState): string {
  return typeof phase !== 'string' && 'ended' in phase ? endWords(phase.ended) : '';
}

export function endWords(why: ZoneEnd): string {
  return t(`events.zone_why_${why}`);
}

/** Why a zone with an alarm is not released: what it waits for, each as the hub names it. */
export function waitsFor(zone: ZoneState): string[] {
  return zone.not_released.map(notReleased);
}

function notReleased(why: ZoneNotReleased): string {
  if (typeof why === 'string') return t(`zones.waits_${why}`);
  if ('ended' in why) return t('zones.waits_ended', { why: endWords(why.ended) });
  if ('mode' in why) return t('zones.waits_mode', { mode: t(`events.zone_mode_${why.mode}`) });
  return t('zones.waits_votes', { have: why.votes.have, need: why.votes.need });
}

/** What the hub reports that keeps a quiet zone from releasing by itself. */
export function notReady(zone: ZoneState, state: ZonesState, monitors: string[]): string[] {
  if (zone.ready) return [];
  const phase = phaseOf(zone);
  const withheld = (id: string) => state.monitors.find(({ monitor }) => monitor === id)?.withheld != null;
  return [
    state.lockout ? t('zones.waits_lockout') : '',
    phase === 'ended' ? t('zones.waits_ended', { why: whyEnded(zone) }) : '',
    zone.switch_manual ? t('zones.switch_manual') : '',
    zone.mode === 'manual' || zone.mode === 'off'
      ? t('zones.waits_mode', { mode: t(`events.zone_mode_${zone.mode}`) })
      : '',
    zone.need == null ? t('zones.waits_failed') : '',
    monitors.length > 0 && monitors.every(withheld) ? t('zones.waits_no_monitor') : '',
  ].filter(Boolean);
}

/** Why a detector has no vote; empty: it has one. */
export function unableWords(unable: DetectorUnable | null | undefined): string {
  if (unable == null) return '';
  if (typeof unable === 'string') return t(`zones.unable_${unable}`);
  if ('condition' in unable) return t(`zones.unable_${unable.condition}`);
  return t(`zones.unable_bypass_${unable.bypass}`);
}

/** What a detector sees, as last heard. */
export function signalWords({ signal, stale }: DetectorState): string {
  if (!signal) return t('zones.unheard');
  return t(stale ? 'zones.signal_stale' : `events.zone_signal_${signal}`);
}

/** What the controller has ordered of a monitor for a zone. */
export function orderedWords(monitor: ZoneMonitorState, zone: ZoneState): string {
  if (monitor.closing) return t('zones.ordered_close');
  if (monitor.engaged_for == null) return t('zones.ordered_nothing');
  if (monitor.engaged_for !== zone.zone) return t('zones.ordered_elsewhere', { zone: monitor.engaged_for });
  return t(phaseOf(zone) === 'released' ? 'zones.ordered_water' : 'zones.ordered_turn');
}

export function withheldWords(monitor: ZoneMonitorState): string {
  return monitor.withheld ? t(`zones.withheld_${monitor.withheld}`) : '';
}

export interface Doing {
  kind: ChipKind;
  icon: IconName;
  text: string;
}

/** What a monitor does, as it reports now. */
export function doingOf(id: string): Doing[] {
  const status = store.getLive(`monitors/${id}/status`);
  const link = store.getLive(`monitors/${id}/link`);
  if (!status?.at_ms || link?.state === 'down')
    return [{ kind: 'medium', icon: 'unlinked', text: t('zones.does_silent') }];
  const is = (subsystem: string, flag: string) => status.subsystems[subsystem]?.flags.includes(flag) ?? false;
  const valve = (flag: string) => is('Valve1', flag) || is('Valve2', flag);
  const found: Doing[] = [];
  const add = (kind: ChipKind, icon: IconName, key: Key) => found.push({ kind, icon, text: t(key) });
  if (status.stale) add('medium', 'clock', 'zones.does_old');
  if (is('General', 'LockedOut')) add('medium', 'lock', 'overview.locked');
  if (valve('Open')) add('accent', 'water', 'zones.does_water');
  else if (valve('Opening')) add('accent', 'water', 'zones.does_opening');
  else if (valve('Closing')) add('normal', 'water', 'zones.does_closing');
  if (is('Deployer', 'Deploying')) add('accent', 'deploy', 'operate.posture_deploying');
  else if (is('Deployer', 'Wrapping')) add('normal', 'wrap', 'operate.posture_wrapping');
  else if (is('Deployer', 'Wrapped')) add('normal', 'wrap', 'operate.posture_wrapped');
  else if (is('Deployer', 'Deployed')) add('normal', 'deploy', 'operate.posture_deployed');
  else if ('Deployer' in status.subsystems) add('normal', 'deploy', 'operate.posture_between');
  return found;
}

/** Of these the ones with an open valve. */
export function withWater(ids: string[]): string[] {
  const flags = (id: string, valve: string) => store.getLive(`monitors/${id}/status`)?.subsystems[valve]?.flags ?? [];
  return ids.filter((id) => ['Valve1', 'Valve2'].some((valve) => flags(id, valve).includes('Open')));
}

/** Seconds are rounded up: 0 is the end itself. */
export function leftWords(left_ms: number | null, time: Time): string {
  if (left_ms === null) return '—';
  return time === 'release' || time === 'hold' ? `${num(Math.ceil(left_ms / 1000))} ${t('banner.s')}` : age(left_ms);
}

/** The last report of a zone: its phase, and the time as it was then. */
export function lastHeard(zone: ZoneState): string {
  const counts = phaseOf(zone) === 'countdown' || phaseOf(zone) === 'coincidence';
  return counts ? `${phaseWords(zone)} ${leftWords(zone.left_ms ?? null, 'release')}` : phaseWords(zone);
}
