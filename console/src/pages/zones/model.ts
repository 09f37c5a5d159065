// Which entries of the audit log are about a zone.
import type { ZoneEntry, ZoneOrder, ZoneScope } from '../../hub/api';
import type { AuditEntry } from '../../hub/types';
import { actOf } from '../events/model';

export function concerns(entry: AuditEntry, zone: string, detectors: string[], monitors: string[]): boolean {
  const act = actOf(entry);
  if (act?.type === 'zone') return entryConcerns(act.entry, zone, detectors, monitors);
  return act?.type === 'zone_order' && orderConcerns(act.order, zone, monitors);
}

function entryConcerns(entry: ZoneEntry, zone: string, detectors: string[], monitors: string[]): boolean {
  if (typeof entry === 'string' || 'started' in entry || 'lockout' in entry) return true;
  if ('bypass' in entry) return detectors.includes(entry.bypass.detector);
  if ('no' in entry) return meant(entry.no.scope, zone, monitors);
  if ('lapsed' in entry) return meant(entry.lapsed.scope, zone, monitors);
  if ('reset' in entry) return meant(entry.reset, zone, monitors);
  if ('water_found' in entry) return monitors.includes(entry.water_found.monitor);
  // A refused order names its zone within.
  const named = 'refused' in entry ? entry.refused.order : entry;
  return Object.values(named).some((fields) => (fields as { zone?: unknown } | null)?.zone === zone);
}

function orderConcerns(order: ZoneOrder, zone: string, monitors: string[]): boolean {
  if ('prepare' in order) return order.prepare.zone === zone;
  if ('engage' in order) return order.engage.zone === zone;
  if ('close' in order) return monitors.includes(order.close.monitor);
  return 'stop' in order && monitors.includes(order.stop.monitor);
}

function meant(scope: ZoneScope, zone: string, monitors: string[]): boolean {
  if (typeof scope === 'string') return true;
  return 'zone' in scope ? scope.zone === zone : monitors.includes(scope.monitor);
}
