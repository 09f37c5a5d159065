// Plays a recording, or a part of the history, into the store. It is fetched in pieces of two
// minutes, because a whole day would not fit into memory (each piece may be some megabytes).
import { HubError, ofStatus } from './errors';
import { store } from './store';
import type { Alarm, AuditEntry } from './types';

/** A line of …/changes (docs/hub-api.md). */
export interface Line {
  at_ms: number;
  set?: Record<string, unknown>;
  gone?: string[];
}

export interface Recording {
  name: string;
  cause: 'alarm' | 'asked' | 'uploaded';
  by: string | null;
  alarm: string | null;
  monitors: string[];
  from_ms: number;
  to_ms: number;
  size: number;
  recording: boolean;
}

export interface Source {
  title: string;
  /** Of `changes`, without from and to. */
  path: string;
  from_ms: number;
  to_ms: number;
  monitor?: string | null;
}

export interface ReplayMark {
  at_ms: number;
  kind: 'alarm' | 'command' | 'event';
  /** An alarm, or the text of a command. */
  alarm?: Alarm;
  text: string;
}

export const PIECE_MS = 2 * 60_000;
const PIECES_KEPT = 5;
/** Recordings up to this length are fetched as a whole, for their marks. */
const WHOLE_MS = 10 * 60_000;
const TICK_MS = 50;
/** Number of pieces that are searched for something to show. */
const BEGIN_PIECES_MAX = 30;
const MARKS_MAX = 400;

/** The complete state at a time, from a piece that starts with a complete state. */
export function stateAt(lines: readonly Line[], at_ms: number): Map<string, unknown> {
  const state = new Map<string, unknown>();
  for (const line of lines) {
    if (line.at_ms > at_ms && state.size) break;
    for (const [topic, value] of Object.entries(line.set ?? {})) state.set(topic, value);
    for (const topic of line.gone ?? []) state.delete(topic);
  }
  return state;
}

/** The messages that lead from one state to the other. */
export function difference(
  from: ReadonlyMap<string, unknown>,
  to: ReadonlyMap<string, unknown>,
): { set: Record<string, unknown>; gone: string[] } {
  const set: Record<string, unknown> = {};
  for (const [topic, value] of to) if (from.get(topic) !== value) set[topic] = value;
  return { set, gone: [...from.keys()].filter((topic) => !to.has(topic)) };
}

/** Alarms that appear, line by line; those of the first line were there before. */
export function marksOf(lines: readonly Line[]): ReplayMark[] {
  const marks: ReplayMark[] = [];
  const active = new Set<string>();
  lines.forEach((line, index) => {
    for (const [topic, value] of Object.entries(line.set ?? {})) {
      if (!topic.startsWith('alarms/')) continue;
      const alarm = value as Alarm;
      if (alarm.active && !active.has(topic) && index > 0) {
        marks.push({ at_ms: line.at_ms, kind: 'alarm', alarm, text: alarm.id });
      }
      if (alarm.active) active.add(topic);
      else active.delete(topic);
    }
    for (const topic of line.gone ?? []) active.delete(topic);
  });
  return marks;
}

/** Lines of JSON; a truncated last line is ignored. */
export function parseLines(text: string): Line[] {
  const lines: Line[] = [];
  for (const row of text.split('\n')) {
    if (!row.trim()) continue;
    try {
      lines.push(JSON.parse(row) as Line);
    } catch {
      break;
    }
  }
  return lines;
}

type Phase = 'off' | 'loading' | 'on';

/** Events: `change`, at most a few times a second while it plays. */
class Replay extends EventTarget {
  phase: Phase = 'off';
  source: Source | null = null;
  at_ms = 0;
  playing = false;
  speed = 1;
  marks: ReplayMark[] = [];
  error: HubError | null = null;
  /** Waits for a piece. */
  waiting = false;

  private pieces = new Map<number, Promise<Line[]>>();
  private lines: Line[] = [];
  private piece = -1;
  private next = 0;
  private fed = new Map<string, unknown>();
  private timer = 0;
  private last_ms = 0;
  private turn = 0;

  async open(source: Source): Promise<void> {
    this.close();
    this.source = source;
    this.phase = 'loading';
    this.error = null;
    this.at_ms = source.from_ms;
    this.changed();
    const turn = ++this.turn;
    try {
      await this.findBegin(source);
    } catch (cause) {
      if (turn !== this.turn) return;
      this.close();
      this.error = HubError.of(cause);
      this.changed();
      return;
    }
    if (turn !== this.turn) return;
    this.phase = 'on';
    store.beginReplay();
    this.speed = 1;
    await this.seek(source.from_ms);
    if (turn !== this.turn) return;
    this.play();
    void this.commandMarks(source, turn);
    void this.alarmMarks(source, turn);
    if (source.to_ms - source.from_ms <= WHOLE_MS) void this.loadAll(turn);
  }

  /** Back to live values. */
  close(): void {
    this.turn++;
    this.pause();
    if (store.source === 'replay') store.endReplay();
    this.phase = 'off';
    this.source = null;
    this.pieces.clear();
    this.lines = [];
    this.marks = [];
    this.fed.clear();
    this.piece = -1;
    this.waiting = false;
    this.changed();
  }

  play(): void {
    if (this.phase !== 'on' || this.playing) return;
    if (this.at_ms >= this.source!.to_ms) void this.seek(this.source!.from_ms);
    this.playing = true;
    this.last_ms = performance.now();
    this.timer = window.setInterval(this.tick, TICK_MS);
    this.changed();
  }

  pause(): void {
    this.playing = false;
    clearInterval(this.timer);
    this.changed();
  }

  setSpeed(speed: number): void {
    this.speed = speed;
    this.changed();
  }

  async seek(at_ms: number): Promise<void> {
    const { source } = this;
    if (!source || this.phase !== 'on') return;
    const at = Math.min(Math.max(at_ms, source.from_ms), source.to_ms);
    this.at_ms = at;
    const index = this.pieceOf(at);
    if (!(await this.enter(index, at))) return;
    const state = stateAt(this.lines, at);
    this.feed(at, difference(this.fed, state), state);
    this.next = this.lines.findIndex((line) => line.at_ms > at);
    if (this.next < 0) this.next = this.lines.length;
    this.changed();
  }

  /** Before the hub ran there is nothing to show: starts at the first data. */
  private async findBegin(source: Source): Promise<void> {
    for (let index = 0; index < BEGIN_PIECES_MAX; index++) {
      const lines = await this.load(index);
      const first = lines.find(({ set }) => set && Object.keys(set).length);
      if (!first && source.from_ms + (index + 1) * PIECE_MS < source.to_ms) continue;
      if (first && index > 0) {
        source.from_ms = first.at_ms;
        // Pieces are counted from the start.
        this.pieces.clear();
      }
      return;
    }
  }

  private pieceOf(at_ms: number): number {
    return Math.floor((at_ms - this.source!.from_ms) / PIECE_MS);
  }

  /** Makes a piece the current one; false if another one was requested meanwhile. */
  private async enter(index: number, at: number): Promise<boolean> {
    if (index === this.piece) return true;
    this.waiting = true;
    const turn = this.turn;
    try {
      const lines = await this.load(index);
      if (turn !== this.turn || this.pieceOf(this.at_ms) !== index || this.at_ms !== at) return false;
      this.lines = lines;
      this.piece = index;
      return true;
    } catch (cause) {
      if (turn === this.turn) {
        this.error = HubError.of(cause);
        this.pause();
      }
      return false;
    } finally {
      if (turn === this.turn) this.waiting = false;
    }
  }

  private readonly tick = (): void => {
    const now = performance.now();
    const passed = Math.min(now - this.last_ms, 1000) * this.speed;
    this.last_ms = now;
    const { source } = this;
    if (!source || this.waiting) return;
    const at = Math.min(this.at_ms + passed, source.to_ms);
    if (this.pieceOf(at) !== this.piece) {
      void this.seek(at);
      return;
    }
    this.at_ms = at;
    const set: Record<string, unknown> = {};
    const gone = new Set<string>();
    while (this.next < this.lines.length && this.lines[this.next]!.at_ms <= at) {
      const line = this.lines[this.next++]!;
      for (const [topic, value] of Object.entries(line.set ?? {})) {
        set[topic] = value;
        gone.delete(topic);
      }
      for (const topic of line.gone ?? []) {
        delete set[topic];
        gone.add(topic);
      }
    }
    for (const [topic, value] of Object.entries(set)) this.fed.set(topic, value);
    for (const topic of gone) this.fed.delete(topic);
    store.replay({ now_ms: at, set, gone: [...gone] });
    if (at - source.from_ms > PIECE_MS * (this.piece + 0.7) && at < source.to_ms) {
      void this.load(this.piece + 1).catch(() => {});
    }
    if (at >= source.to_ms) this.pause();
    this.changed();
  };

  private feed(
    at_ms: number,
    change: { set: Record<string, unknown>; gone: string[] },
    state: Map<string, unknown>,
  ): void {
    this.fed = state;
    // The site is not recorded: it stays as it is.
    const hub = store.hello?.hub;
    if (hub && !store.get('hub')) change.set.hub = hub;
    store.replay({ now_ms: at_ms, ...change });
  }

  private load(index: number): Promise<Line[]> {
    const source = this.source!;
    const from = source.from_ms + index * PIECE_MS;
    const to = Math.min(from + PIECE_MS, source.to_ms);
    if (from > source.to_ms || index < 0) return Promise.resolve([]);
    const known = this.pieces.get(index);
    if (known) return known;
    const loading = fetchLines(source, from, to).then((lines) => {
      if (source === this.source) this.mark(marksOf(lines));
      return lines;
    });
    this.pieces.set(index, loading);
    loading.catch(() => this.pieces.delete(index));
    for (const old of this.pieces.keys()) {
      if (this.pieces.size <= PIECES_KEPT) break;
      if (old !== index && old !== this.piece) this.pieces.delete(old);
    }
    return loading;
  }

  private async loadAll(turn: number): Promise<void> {
    const last = this.pieceOf(this.source!.to_ms);
    for (let index = 1; index <= last && turn === this.turn; index++) {
      await this.load(index).catch(() => {});
    }
  }

  /** Commands come from the audit log, for users who may read it. */
  private async commandMarks(source: Source, turn: number): Promise<void> {
    const log = await told<{ entries?: AuditEntry[] }>('/api/audit', source);
    if (turn !== this.turn) return;
    this.mark(
      (log?.entries ?? [])
        .filter(({ outcome, at_ms }) => outcome === 'asked' && within(source, at_ms))
        .map(({ at_ms, what, monitor, user }) => ({
          at_ms,
          kind: 'command',
          text: `${monitor ?? ''} ${what} (${user})`.trim(),
        })),
    );
  }

  /** Changes of the hub's own alarms; a recording from another hub has its own. */
  private async alarmMarks(source: Source, turn: number): Promise<void> {
    if (!source.path.startsWith('/api/history')) return;
    type Entry = { at_ms: number; id: string; to: string };
    const log = await told<Entry[]>('/api/alarms/history', source);
    if (turn !== this.turn || !Array.isArray(log)) return;
    this.mark(
      log
        .filter(({ to, at_ms }) => to === 'unack' && within(source, at_ms))
        .map(({ at_ms, id }) => ({ at_ms, kind: 'alarm', alarm: store.getLive(`alarms/${id}`), text: id })),
    );
  }

  private mark(more: ReplayMark[]): void {
    // The times of the two sources of alarms may differ slightly.
    const key = ({ at_ms, kind, text }: ReplayMark): string =>
      `${kind === 'alarm' ? Math.round(at_ms / 5000) : at_ms} ${kind} ${text}`;
    const known = new Map([...this.marks, ...more].map((mark) => [key(mark), mark]));
    this.marks = [...known.values()].sort((a, b) => a.at_ms - b.at_ms).slice(-MARKS_MAX);
    this.changed();
  }

  private changed(): void {
    this.dispatchEvent(new Event('change'));
  }
}

function within({ from_ms, to_ms }: Source, at_ms: number): boolean {
  return at_ms >= from_ms && at_ms <= to_ms;
}

/** Entries of a log for this time; null on failure: missing marks are not worth an error. */
async function told<T>(path: string, { from_ms, to_ms, monitor }: Source): Promise<T | null> {
  const query = new URLSearchParams({
    limit: String(MARKS_MAX),
    from_ms: String(Math.floor(from_ms)),
    to_ms: String(Math.ceil(to_ms)),
  });
  if (monitor) query.set('monitor', monitor);
  try {
    const answer = await fetch(`${path}?${query}`);
    return answer.ok ? ((await answer.json()) as T) : null;
  } catch {
    return null;
  }
}

async function fetchLines(source: Source, from: number, to: number): Promise<Line[]> {
  const url = new URL(source.path, location.href);
  url.searchParams.set('from_ms', String(Math.floor(from)));
  url.searchParams.set('to_ms', String(Math.ceil(to)));
  if (source.monitor) url.searchParams.set('monitor', source.monitor);
  let answer: Response;
  try {
    answer = await fetch(url);
  } catch (cause) {
    throw HubError.of(cause);
  }
  const text = await answer.text();
  if (answer.ok) return parseLines(text);
  let error = ofStatus(answer.status);
  try {
    error = JSON.parse(text).error ?? error;
  } catch {
    // Not from the hub: only the status is known.
  }
  throw new HubError(error);
}

export const replay = new Replay();
