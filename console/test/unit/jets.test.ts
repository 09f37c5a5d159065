import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { type Jet, type JetAsked, Jets } from '../../src/hub/jets';

const asked = (elevation_arcmin: number): JetAsked => ({
  pressure_datm: 79,
  nozzle_mm: 60,
  height_cm: 150,
  elevation_arcmin,
  flow_lps: 20,
  wind: null,
  live: true,
});

/** The hub's answer: the elevation, to distinguish the answers. */
const answer = (one: { elevation_arcmin: number }): Jet => ({
  pressure_datm: 79,
  reach_m: one.elevation_arcmin,
  flight: null,
  fault: null,
  throw: null,
  no_throw: null,
});

describe('jets', () => {
  let sent: { list: { elevation_arcmin: number }[]; reply: (jets: Jet[] | Error) => void }[];
  let heard: string[];
  let jets: Jets;

  beforeEach(() => {
    vi.useFakeTimers();
    [sent, heard] = [[], []];
    const ask = (list: object[]) =>
      new Promise<Jet[]>((resolve, reject) =>
        sent.push({
          list: list as never,
          reply: (jets) => (jets instanceof Error ? reject(jets) : resolve(jets)),
        }),
      );
    jets = new Jets(
      ask,
      (monitor) => heard.push(monitor),
      () => Date.now(),
    );
  });
  afterEach(() => vi.useRealTimers());

  const answered = async (index: number) => {
    sent[index]!.reply(sent[index]!.list.map(answer));
    await vi.advanceTimersByTimeAsync(0);
  };

  it('asks once for all monitors, and reports when the answer is there', async () => {
    expect(jets.of('M1', asked(1))).toBeUndefined();
    expect(jets.of('M2', asked(2))).toBeUndefined();
    await vi.advanceTimersByTimeAsync(0);
    expect(sent.map(({ list }) => list.map((one) => one.elevation_arcmin))).toEqual([[1, 2]]);
    await answered(0);
    expect(heard).toEqual(['M1', 'M2']);
    expect(jets.of('M1', asked(1))!.reach_m).toBe(1);
    await vi.advanceTimersByTimeAsync(5000);
    expect(sent).toHaveLength(1);
  });

  it('asks only about the latest, one query at a time', async () => {
    jets.of('M1', asked(1));
    await vi.advanceTimersByTimeAsync(0);
    for (const elevation of [2, 3, 4, 5]) jets.of('M1', asked(elevation));
    await vi.advanceTimersByTimeAsync(1000);
    expect(sent).toHaveLength(1);
    await answered(0);
    await vi.advanceTimersByTimeAsync(100);
    expect(sent.map(({ list }) => list[0]!.elevation_arcmin)).toEqual([1, 5]);
  });

  it('draws the previous answer for a moment, but never one for another pressure', async () => {
    jets.of('M1', asked(1));
    await vi.advanceTimersByTimeAsync(0);
    await answered(0);
    expect(jets.of('M1', asked(2))!.reach_m).toBe(1);
    await vi.advanceTimersByTimeAsync(600);
    expect(jets.of('M1', asked(3))).toBeUndefined();
    expect(jets.of('M1', { ...asked(3), live: false })).toBeUndefined();
  });

  it('asks again after an error, slowly', async () => {
    jets.of('M1', asked(1));
    await vi.advanceTimersByTimeAsync(0);
    sent[0]!.reply(new Error());
    await vi.advanceTimersByTimeAsync(900);
    expect(sent).toHaveLength(1);
    await vi.advanceTimersByTimeAsync(200);
    expect(sent).toHaveLength(2);
  });
});
