// Orders to the zone controller, and the hold that lasts as long as this page renews it.
import type { DetectorBypass, ZoneMode } from '../hub/api';
import { HubError } from '../hub/errors';
import { halt } from '../hub/halt';
import { http } from '../hub/http';
import { inTime } from '../hub/socket';
import { insist } from '../hub/urgent';
import { goesOn, phaseOf, zones } from '../hub/zones';
import { lang, t } from '../i18n';
import { toast } from './toasts';

/** A hold ends 10 s after it was renewed last. */
const RENEW_MS = 2000;
/** The button that ends a hold is where the one was that began it: a second click of a double click is none, ms. */
const DOUBLE_MS = 1000;
/** The next order about a hold waits for the one before, ms at most: a dead network keeps none back. */
const BEFORE_MOST_MS = 3000;
/** Without an answer after this time people are shown so. */
const ANSWER_MS = 2000;

function path(zone: string, what: string): string {
  return `/api/zones/${encodeURIComponent(zone)}/${what}`;
}

/** Sends an order and shows what became of it; whether the hub has accepted it. */
async function order(to: string, body: unknown, what: string): Promise<boolean> {
  const timer = setTimeout(() => toast({ kind: 'warning', text: t('zones.no_answer', { what }) }), ANSWER_MS);
  try {
    await http.post(inTime(to), body);
    toast({ kind: 'ok', text: what });
    return true;
  } catch (cause) {
    toast({ kind: 'error', text: `${what}: ${HubError.of(cause).text(lang())}` });
    return false;
  } finally {
    clearTimeout(timer);
  }
}

let urgents = 0;

/** An order that ends something: it is given again until the hub answers, and what became of it stays until it was seen. */
async function urge(to: string, what: string): Promise<boolean> {
  halt('abort');
  const key = `zone ${urgents++}`;
  const unconfirmed = `${what}: ${t('stop.unconfirmed')}`;
  const more = t('stop.unconfirmed_more');
  const note = () => toast({ kind: 'error', text: unconfirmed, more, key, stays: true });
  try {
    await insist(() => http.post(to), note);
    toast({ kind: 'ok', text: what, key });
    return true;
  } catch (cause) {
    toast({ kind: 'error', text: `${what}: ${HubError.of(cause).text(lang())}`, key, stays: true });
    return false;
  }
}

/** Ends countdown and water. Every role, in every state of this page: the hub answers. */
export function abortZone(zone: string): Promise<boolean> {
  holding.end(zone);
  return urge(path(zone, 'abort'), t('zones.did_abort', { zone }));
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
  if (on) return urge('/api/zones/lock', t('events.zone_lockout_on'));
  return order('/api/zones/unlock', undefined, t('events.zone_lockout_off'));
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
  /** When a hold was started or ended here. */
  private readonly turnedAt = new Map<string, number>();
  private readonly last = new Map<string, Promise<unknown>>();

  /** This page holds a countdown. */
  get busy(): boolean {
    return this.held.size > 0;
  }

  has(zone: string): boolean {
    return this.held.has(zone);
  }

  async begin(zone: string): Promise<void> {
    if (this.has(zone) || this.isSecond(zone)) return;
    const timer = window.setInterval(() => void this.renew(zone), RENEW_MS);
    this.held.set(zone, { timer, seen: false });
    this.changed();
    const hold = () => order(path(zone, 'hold'), { on: true }, t('zones.did_hold', { zone }));
    if (!(await this.after(zone, hold))) this.drop(zone);
  }

  /** Ends the hold of this page without asking the hub: an order that ends more follows. */
  end(zone: string): void {
    this.drop(zone);
  }

  /** Ends a hold, of this page or of another: the delay goes on. */
  async letGo(zone: string): Promise<boolean> {
    if (this.isSecond(zone)) return false;
    this.drop(zone);
    return this.after(zone, () => order(path(zone, 'hold'), { on: false }, t('zones.did_let_go', { zone })));
  }

  /** Whether this is the second click of a double click; else it is noted as the first. */
  private isSecond(zone: string): boolean {
    const now = performance.now();
    if (now - (this.turnedAt.get(zone) ?? -Infinity) < DOUBLE_MS) return true;
    this.turnedAt.set(zone, now);
    return false;
  }

  /** One order after the other: the hub hears them as they were given. */
  private after<T>(zone: string, give: () => Promise<T>): Promise<T> {
    const before = this.last.get(zone);
    const late = new Promise((done) => setTimeout(done, BEFORE_MOST_MS));
    const given = before ? Promise.race([before, late]).then(give) : give();
    this.last.set(
      zone,
      given.catch(() => {}),
    );
    return given;
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
    const renewal = async () => this.has(zone) && http.post(inTime(path(zone, 'hold')), { on: true });
    await this.after(zone, renewal).catch((cause) => {
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
