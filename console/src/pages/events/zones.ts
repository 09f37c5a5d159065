// What the zone controller did and ordered, in words.
import type { ZoneEntry, ZoneOrder, ZoneScope } from '../../hub/api';
import { num, t } from '../../i18n';

export function zoneWords(entry: ZoneEntry): string {
  if (typeof entry === 'string') return t('events.zone_silenced');
  if ('released' in entry) return released(entry.released);
  if ('held' in entry) return t(entry.held.on ? 'events.zone_held' : 'events.zone_not_held', { zone: entry.held.zone });
  if ('lockout' in entry) return t(entry.lockout.on ? 'events.zone_lockout_on' : 'events.zone_lockout_off');
  if ('trouble' in entry) {
    const { subject, trouble, active } = entry.trouble;
    const what = t(`events.zone_trouble_${trouble}`);
    return t(active ? 'events.zone_trouble' : 'events.zone_trouble_over', { subject, what });
  }
  if ('detector' in entry) {
    const { detector, signal } = entry.detector;
    return t('events.zone_detector', { detector, state: t(`events.zone_signal_${signal}`) });
  }
  if ('bypass' in entry) {
    const { detector, bypass } = entry.bypass;
    return t('events.zone_detector', { detector, state: t(`events.zone_bypass_${bypass}`) });
  }
  if ('cancelled' in entry)
    return t('events.zone_cancelled', { zone: entry.cancelled.zone, why: why(entry.cancelled.why) });
  if ('ended' in entry) return t('events.zone_ended', { zone: entry.ended.zone, why: why(entry.ended.why) });
  if ('no' in entry) return t('events.zone_no', { scope: scope(entry.no.scope), why: why(entry.no.why) });
  if ('lapsed' in entry) return t('events.zone_reset', { scope: scope(entry.lapsed.scope) });
  if ('reset' in entry) return t('events.zone_reset', { scope: scope(entry.reset) });
  if ('started' in entry) return t('events.zone_started');
  if ('enough' in entry) return t('events.zone_enough', { zone: entry.enough.zone });
  if ('countdown' in entry) {
    return t('events.zone_countdown', { zone: entry.countdown.zone, s: seconds(entry.countdown.delay_ms) });
  }
  if ('refused' in entry) return t('events.zone_refused');
  if ('station_refused' in entry) {
    return t('events.zone_station_refused', { zone: entry.station_refused.zone, input: entry.station_refused.input });
  }
  if ('mode' in entry) {
    return t('events.zone_mode', { zone: entry.mode.zone, mode: t(`events.zone_mode_${entry.mode.mode}`) });
  }
  if ('water_found' in entry) {
    return t('events.zone_water_found', { monitor: entry.water_found.monitor, s: seconds(entry.water_found.left_ms) });
  }
  if ('replaced' in entry) {
    return t('events.zone_replaced', { zone: entry.replaced.zone, monitor: entry.replaced.monitor });
  }
  return t('events.zone_unknown', { name: entry.unknown.name });
}

export function orderWords(order: ZoneOrder): string {
  if ('prepare' in order) return t('events.zone_prepare', { zone: order.prepare.zone, monitor: order.prepare.monitor });
  if ('engage' in order) return t('events.zone_engage', { zone: order.engage.zone, monitor: order.engage.monitor });
  if ('close' in order) return t('events.zone_close', { id: order.close.monitor });
  if ('stop' in order) return t('events.zone_stop', { id: order.stop.monitor });
  if ('pump' in order) return t(order.pump.on ? 'events.zone_start' : 'events.zone_stop', { id: order.pump.pump });
  if ('valve' in order)
    return t(order.valve.open ? 'events.zone_open' : 'events.zone_close', { id: order.valve.output });
  if ('sound' in order) return t('events.zone_sound', { id: order.sound.output });
  return t(order.lamp.lit ? 'events.zone_lit' : 'events.zone_dark', { id: order.lamp.output });
}

function released({ zone, automatic, wet }: { zone: string; automatic: boolean; wet: boolean }): string {
  if (!wet) return t('events.zone_released_dry', { zone });
  return t(automatic ? 'events.zone_released_votes' : 'events.zone_released_hand', { zone });
}

type Why = Extract<ZoneEntry, { ended: unknown }>['ended']['why'];

function why(reason: Why): string {
  return t(`events.zone_why_${reason}`);
}

function scope(of: ZoneScope): string {
  if (typeof of === 'string') return t('events.zone_all');
  return 'zone' in of ? t('events.zone_one', { zone: of.zone }) : of.monitor;
}

function seconds(ms: number): string {
  return num(ms / 1000, 0);
}
