// Trajectories of jets. The hub computes them with the monitor's own code; this file keeps the latest
// answers and has at most one query for all monitors in flight, about what is displayed now.
import type { JetWind, NoJet, NoThrow, Struck, Thrown } from './api';
import { http } from './http';
import { store } from './store';

export interface JetAsked {
  /** 0.1 atm. */
  pressure_datm: number;
  nozzle_mm: number;
  height_cm: number;
  elevation_arcmin: number;
  /** Only where something may stand in the way. */
  horizontal_arcmin?: number;
  /** As measured, l/s; null: not measured. */
  flow_lps: number | null;
  /** Null: not known. */
  wind: JetWind | null;
  /** For the water that flows now, not for what would flow. */
  live: boolean;
}

export interface Flight {
  /** Level distance from the nozzle and height above it, m; time from the nozzle, s. */
  points: [way_m: number, rise_m: number, at_s: number][];
  lands_m: number;
  /** Distance after which the jet has broken up, m. */
  core_m: number;
  speed_mps: number;
}

export interface Jet {
  pressure_datm: number | null;
  reach_m: number | null;
  flight: Flight | null;
  fault: NoJet | null;
  throw: Thrown | null;
  no_throw: NoThrow | null;
  /** What ends the flight before the ground, and what ends the throw. */
  strikes?: Struck | null;
  throw_strikes?: Struck | null;
}

export interface Aimed {
  pressure_datm: number | null;
  elevation_arcmin: number | null;
  fault: NoJet | null;
}

/** The hub's limit for one request. */
const JETS_MAX = 16;
/** Between two queries, ms. */
const PAUSE_MS = 40;
/** After a failed query, ms. */
const RETRY_MS = 1000;
/** Without an answer after this time it is asked for again, ms. */
const ASK_MOST_MS = 3000;
/** The previous answer is drawn for this time while the next one is awaited; it is never used to aim. */
const HELD_MS = 500;

/** Prefix of a monitor's id for its jet at the usual pressure. No id contains it. */
const USUAL = '/';

interface Slot {
  asked: JetAsked;
  key: string;
  answer: { key: string; jet: Jet; replaced_ms: number | null } | null;
}

type Ask = (jets: object[]) => Promise<Jet[]>;

export class Jets {
  private readonly slots = new Map<string, Slot>();
  private readonly open = new Set<string>();
  private timer: ReturnType<typeof setTimeout> | undefined;
  private under_way = false;

  constructor(
    private readonly ask: Ask,
    private readonly answered: (monitor: string) => void,
    private readonly now: () => number = () => performance.now(),
  ) {}

  /** The jet of a monitor; undefined until the hub has answered. */
  of(monitor: string, asked: JetAsked): Jet | undefined {
    const id = `${asked.live ? '' : USUAL}${monitor}`;
    const { pressure_datm, nozzle_mm, height_cm, elevation_arcmin, horizontal_arcmin, flow_lps, wind } = asked;
    const air = wind ? [wind.along_mps, wind.left_mps] : [];
    const key = [pressure_datm, nozzle_mm, height_cm, elevation_arcmin, horizontal_arcmin, flow_lps, ...air].join(' ');
    let slot = this.slots.get(id);
    if (!slot) this.slots.set(id, (slot = { asked, key: '', answer: null }));
    if (slot.key !== key) {
      slot.asked = asked;
      slot.key = key;
      const answer = slot.answer;
      if (answer && answer.key !== key) answer.replaced_ms ??= this.now();
    }
    if (slot.answer?.key === key) return slot.answer.jet;
    this.open.add(id);
    this.soon(0);
    const held = slot.answer && this.now() - (slot.answer.replaced_ms ?? this.now()) <= HELD_MS;
    return held ? slot.answer!.jet : undefined;
  }

  private soon(after_ms: number): void {
    if (this.under_way || this.timer !== undefined) return;
    this.timer = setTimeout(() => void this.send(), after_ms);
  }

  private async send(): Promise<void> {
    this.timer = undefined;
    const ids = [...this.open].slice(0, JETS_MAX);
    const asked = ids.map((id) => {
      const { key, asked } = this.slots.get(id)!;
      const { live: _, ...jet } = asked;
      return { id, monitor: id.replace(USUAL, ''), key, jet };
    });
    for (const id of ids) this.open.delete(id);
    if (!ids.length) return;
    this.under_way = true;
    let wait_ms = PAUSE_MS;
    try {
      const known = new Set(store.liveMonitors());
      // A recording may show monitors that this hub does not have.
      const jets = await within(
        ASK_MOST_MS,
        this.ask(asked.map(({ monitor, jet }) => (known.has(monitor) ? { monitor, ...jet } : jet))),
      );
      asked.forEach(({ id, monitor, key }, index) => {
        const slot = this.slots.get(id)!;
        const late = slot.key !== key;
        slot.answer = { key, jet: jets[index]!, replaced_ms: late ? this.now() : null };
        if (late) this.open.add(id);
        this.answered(monitor);
      });
    } catch {
      for (const id of ids) this.open.add(id);
      wait_ms = RETRY_MS;
    }
    this.under_way = false;
    if (this.open.size) this.soon(wait_ms);
  }
}

/** A network that is dead answers nothing for minutes. */
function within<T>(most_ms: number, answer: Promise<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    const timer = setTimeout(() => reject(new Error('no answer')), most_ms);
    answer.finally(() => clearTimeout(timer)).then(resolve, reject);
  });
}

/** Elements that show a monitor receive its jet as one of its topics. */
export const jets = new Jets(
  (list) => http.post<Jet[]>('/api/jets', { jets: list }),
  (monitor) => store.announce(`monitors/${monitor}/jet`),
);

/** The elevation that hits a place, by the monitor's present pressure or an assumed one. */
export function solve(
  monitor: string,
  place: { way_m: number; rise_m: number; pressure_datm?: number },
): Promise<Aimed> {
  return http.post<Aimed>(`/api/monitors/${encodeURIComponent(monitor)}/aim`, place);
}
