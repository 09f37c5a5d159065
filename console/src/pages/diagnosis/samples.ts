// Link statistics of the last minutes, of every monitor: the hub's history, then new values as they arrive.
import { http } from '../../hub/http';
import { linkFigures } from '../../hub/session';
import { socket } from '../../hub/socket';
import { store } from '../../hub/store';
import type { LinkFigures } from '../../hub/types';
import type { Point } from '../../parts/lf-trend';

const KEEP_MS = 900_000;
const EVERY_MS = 1000;

export interface Sample {
  t: number;
  rtt_ms: number | null;
  sent: number;
  received: number;
  retries: number;
  timeouts: number;
  errors: number;
  loss_percent: number | null;
}

export type Measure = Exclude<keyof Sample, 't'>;

export function sampleOf(t: number, link: LinkFigures, heard: boolean): Sample {
  const { last } = link;
  const up = heard && link.state === 'up';
  return {
    t,
    rtt_ms: up ? link.srtt_ms : null,
    sent: heard ? last.sent : 0,
    received: heard ? last.received : 0,
    retries: heard ? last.retries : 0,
    timeouts: heard ? last.timeouts : 0,
    errors: heard ? last.errors : 0,
    loss_percent: up ? last.loss_permille / 10 : null,
  };
}

const all = new Map<string, Sample[]>();
const filled = new Set<string>();

function take(): void {
  if (store.source === 'replay') return;
  const now = store.now();
  for (const id of store.monitors()) {
    const link = linkFigures(id);
    if (!link) continue;
    if (!socket.hears(id)) {
      // Fetched again when they are shown.
      all.delete(id);
      filled.delete(id);
      continue;
    }
    const samples = all.get(id) ?? [];
    samples.push(sampleOf(now, link, store.linked));
    while (samples[0] && samples[0].t < now - KEEP_MS) samples.shift();
    all.set(id, samples);
  }
}

setInterval(take, EVERY_MS);
take();

export function samplesOf(monitor: string): Sample[] {
  if (!all.has(monitor)) take();
  return all.get(monitor) ?? [];
}

const SERIES = ['sent', 'received', 'retries', 'timeouts', 'errors', 'rtt_ms'] as const;

/** Reads the hub's history from before this page was opened, once. */
export async function fillSamples(monitor: string): Promise<void> {
  if (filled.has(monitor) || store.source === 'replay') return;
  filled.add(monitor);
  const now = store.now();
  const query = new URLSearchParams({
    monitor,
    series: SERIES.map((name) => `Link.${name}`).join(','),
    from_ms: String(Math.round(now - KEEP_MS)),
    to_ms: String(Math.round(now)),
    points: String(KEEP_MS / EVERY_MS),
  });
  const got = await http
    .get<{ series: Record<string, [number, ...number[]][]> }>(`/api/history?${query}`)
    .catch(() => null);
  if (!got) return;
  const known = all.get(monitor) ?? [];
  const before = known[0]?.t ?? now;
  const kept = fromHistory(got.series, now - KEEP_MS, before);
  all.set(monitor, [...kept, ...known]);
}

/** A value holds until the next one: a sample each second from the first that is known. */
export function fromHistory(series: Record<string, [number, ...number[]][]>, from_ms: number, to_ms: number): Sample[] {
  const at = Object.fromEntries(
    SERIES.map((name) => [name, { rows: series[`Link.${name}`] ?? [], next: 0, value: null as number | null }]),
  );
  const first = Math.min(...SERIES.map((name) => at[name]!.rows[0]?.[0] ?? Infinity));
  const samples: Sample[] = [];
  for (let t = Math.max(from_ms, first); t < to_ms; t += EVERY_MS) {
    for (const one of Object.values(at)) {
      while (one.rows[one.next] && one.rows[one.next]![0] <= t) one.value = one.rows[one.next++]![1] ?? null;
    }
    const value = (name: (typeof SERIES)[number]) => at[name]!.value ?? 0;
    const sent = value('sent');
    samples.push({
      t,
      rtt_ms: at.rtt_ms!.value,
      sent,
      received: value('received'),
      retries: value('retries'),
      timeouts: value('timeouts'),
      errors: value('errors'),
      loss_percent: sent > 0 ? Math.min((value('timeouts') / sent) * 100, 100) : null,
    });
  }
  return samples;
}

export function points(monitor: string, measure: Measure): Point[] {
  return samplesOf(monitor).map((sample) => ({ t: sample.t, v: sample[measure] }));
}

/** Time span of a curve of this age: 1, 2, 5, 10 or 15 minutes. */
export function spanOf(age_ms: number): number {
  return ([1, 2, 5, 10].find((minutes) => age_ms <= minutes * 60_000) ?? 15) * 60_000;
}
