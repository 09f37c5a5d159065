// Orders to the zone controller, and the hold that lasts as long as this page renews it.
import type { DetectorBypass, ZoneMode } from '../hub/api';
import { HubError } from '../hub/errors';
import { http } from '../hub/http';
import { goesOn, phaseOf, zones } from '../hub/zones';
import { lang, t } from '../i18n';
import { toast } from './toasts';

/** A hold ends 10 s after it was renewed last. */
const RENEW_MS = 2000;
/** Without an answer after this time people are shown so. */
const ANSWER_MS = 2000;

function path(zone: string, what: string): string {
  return `/api/zones/${encodeURIComponent(zone)}/${what}`;
}

/** Sends an order and shows what became of it; whether the hub has accepted it. */
async function order(to: string, body: unknown, what: string): Promise<boolean> {
  const timer = setTimeout(() => toast({ kind: 'warning', text: t('zones.no_answer', { what }) }), ANSWER_MS);
  try {
    await http.post(to, body);
    toast({ kind: 'ok', text: what });
    return true;
  } catch (cause) {
    toast({ kind: 'error', text: `${what}: ${HubError.of(cause).text(lang())}` });
    return false;
  } finally {
    clearTimeout(timer);
  }
}

/** Ends countdown and water. Every role, in every state of this page: the hub answers. */
export function abortZone(zone: string): Promise<boolean> {
  holding.end(zone);
  return order(path(zone, 'abort'), undefined, t('zones.did_abort', { zone }));
}

export function releaseZone(zone: string): Promise<boolean> {
  return order(path(zone, 'release'), { confirm: zone }, t('zones.did_release', { zone }));
}

/** Without a time: as configured. */
export function setMode(zone: string, mode: ZoneMode, for_s?: number): Promise<boolean> {
  const what = t('events.zone_mode', { zone, mode: t(`events.zone_mode_${mode}`) });
  return order(path(zone, 'mode'), { mode, for_s }, what);
}

export function resetZone(zone: string): Promise<boolean> {
  return order(path(zone, 'reset'), undefined, t('zones.did_reset', { zone }));
}

export function resetAll(): Promise<boolean> {
  return order('/api/zones/reset', undefined, t('zones.did_reset_all'));
}

/** The sounders, until something new. A countdown goes on sounding. */
export function silenceZones(): Promise<boolean> {
  return order('/api/zones/silence', undefined, t('events.zone_silenced'));
}

export function lockZones(on: boolean): Promise<boolean> {
  return order(
    `/api/zones/${on ? 'lock' : 'unlock'}`,
    undefined,
    t(on ? 'events.zone_lockout_on' : 'events.zone_lockout_off'),
  );
}

export function bypassDetector(detector: string, bypass: DetectorBypass): Promise<boolean> {
  const what = t('events.zone_detector', { detector, state: t(`events.zone_bypass_${bypass}`) });
  return order(`/api/detectors/${encodeURIComponent(detector)}/bypass`, { bypass }, what);
}

export function runPump(pump: string, on: boolean): Promise<boolean> {
  const what = t(on ? 'zones.did_start_pump' : 'zones.did_stop_pump', { pump });
  return order(`/api/pumps/${encodeURIComponent(pump)}`, { on }, what);
}

/** The holds of this page. One that is not renewed ends by itself, so a page that is closed holds nothing. */
class Holding extends EventTarget {
  private readonly held = new Map<string, { timer: number; seen: boolean }>();

  has(zone: string): boolean {
    return this.held.has(zone);
  }

  async begin(zone: string): Promise<void> {
    if (this.has(zone)) return;
    const timer = window.setInterval(() => void this.renew(zone), RENEW_MS);
    this.held.set(zone, { timer, seen: false });
    this.changed();
    if (!(await order(path(zone, 'hold'), { on: true }, t('zones.did_hold', { zone })))) this.drop(zone);
  }

  /** Ends the hold of this page without asking the hub: an order that ends more follows. */
  end(zone: string): void {
    this.drop(zone);
  }

  /** Ends a hold, of this page or of another: the delay goes on. */
  letGo(zone: string): Promise<boolean> {
    this.drop(zone);
    return order(path(zone, 'hold'), { on: false }, t('zones.did_let_go', { zone }));
  }

  /** The session has ended. */
  forget(): void {
    for (const zone of [...this.held.keys()]) this.drop(zone);
  }

  /** Looks at what the hub reports of the holds. */
  look(): void {
    for (const [zone, hold] of this.held) {
      const now = zones.zone(zone);
      const phase = now && phaseOf(now);
      hold.seen ||= phase === 'held';
      if (!goesOn(phase, hold.seen)) this.drop(zone);
    }
  }

  private async renew(zone: string): Promise<void> {
    this.look();
    if (!this.has(zone)) return;
    await http.post(path(zone, 'hold'), { on: true }).catch((cause) => {
      const error = HubError.of(cause);
      // Without a link it is tried again until the hub lets the delay go on.
      if (error.code === 'not_linked') return;
      toast({ kind: 'error', text: `${t('zones.did_hold', { zone })}: ${error.text(lang())}` });
      this.drop(zone);
    });
  }

  private drop(zone: string): void {
    const hold = this.held.get(zone);
    if (!hold) return;
    clearInterval(hold.timer);
    this.held.delete(zone);
    this.changed();
  }

  private changed(): void {
    this.dispatchEvent(new Event('change'));
  }
}

export const holding = new Holding();
