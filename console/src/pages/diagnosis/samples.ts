// Link statistics of the last minutes, of every monitor, from when these pages were first opened.
import { store } from '../../hub/store';
import type { Link } from '../../hub/types';
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

export function sampleOf(t: number, link: Link, heard: boolean): Sample {
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

function take(): void {
  if (store.source === 'replay') return;
  const now = store.now();
  for (const id of store.monitors()) {
    const link = store.get(`monitors/${id}/link`);
    if (!link) continue;
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

export function points(monitor: string, measure: Measure): Point[] {
  return samplesOf(monitor).map((sample) => ({ t: sample.t, v: sample[measure] }));
}

/** How far back curves go that are so old: 1, 2, 5, 10 or 15 minutes. */
export function spanOf(age_ms: number): number {
  return ([1, 2, 5, 10].find((minutes) => age_ms <= minutes * 60_000) ?? 15) * 60_000;
}
