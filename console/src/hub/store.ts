// The values received from the hub, by topic. A replay feeds the same store.
import type { ReactiveController, ReactiveControllerHost } from 'lit';
import { guarded } from './faults';
import type { Alarm, Hello, Status, TopicOf } from './types';

export interface Change {
  now_ms: number;
  set: Record<string, unknown>;
  gone?: string[];
}

type Listener = (topic: string) => void;

/** Pseudo topics: every subscriber gets them. */
export const LINKED = '$linked';
export const SECOND = '$second';
/** What the hub sends for monitors that a page does not name. */
const SUMMARY = '/summary';

export class Store {
  private live = new Map<string, unknown>();
  private replayed: Map<string, unknown> | null = null;
  private readonly listeners = new Set<{ prefix: string; fn: Listener }>();
  private offset_ms = 0;
  private replay_now_ms = 0;
  private second = 0;

  hello: Hello | null = null;
  /** The hub has another version than when this page was loaded: its own files are of the old one. */
  updated = false;
  /** Whether the hub has sent its state: before that nothing is known, not even that there is no alarm. */
  known = false;
  /** Whether the hub's messages arrive; false also before the first one. */
  linked = false;
  /** When its last message arrived, by this page's clock. */
  lostAt_ms = 0;

  get source(): 'live' | 'replay' {
    return this.replayed ? 'replay' : 'live';
  }

  get<K extends string>(topic: K): TopicOf<K> | undefined {
    return this.topics.get(topic) as TopicOf<K> | undefined;
  }

  /** Live values, also while a recording is shown: for STOP and LOCKOUT. */
  getLive<K extends string>(topic: K): TopicOf<K> | undefined {
    return this.live.get(topic) as TopicOf<K> | undefined;
  }

  /** Queried at every change but rarely different: cached until a topic appears or disappears. */
  private readonly kept = new Map<string, unknown>();

  private keep<T>(name: string, make: () => T): T {
    if (!this.kept.has(name)) this.kept.set(name, make());
    return this.kept.get(name) as T;
  }

  /** Topics that begin with this, sorted. */
  keys(prefix: string): string[] {
    const make = () => [...this.topics.keys()].filter((key) => key.startsWith(prefix)).sort(byNumber);
    return [...this.keep(`keys ${prefix}`, make)];
  }

  /** Ids of the monitors. */
  monitors(): string[] {
    return [...this.keep('monitors', () => monitorsIn(this.topics))];
  }

  liveMonitors(): string[] {
    return [...this.keep('live', () => monitorsIn(this.live))];
  }

  /** Alarms, the most urgent first. */
  alarms(monitor?: string): Alarm[] {
    const all = this.keep('alarms', () => alarmsIn(this.topics));
    if (!monitor) return [...all];
    return this.keep(`alarms ${monitor}`, () => all.filter((alarm) => alarm.monitor === monitor)).slice();
  }

  /** Alarms now, also while a recording is shown. */
  alarmsLive(): Alarm[] {
    return this.replayed ? alarmsIn(this.live) : this.alarms();
  }

  /** `fn` is called for each change of a topic that starts with this. Returns the function that ends it. */
  subscribe(prefix: string, fn: Listener): () => void {
    const entry = { prefix, fn };
    this.listeners.add(entry);
    return () => this.listeners.delete(entry);
  }

  /** The hub's clock, or that of the recording. */
  now(): number {
    return this.replayed ? this.replay_now_ms : this.hubNow();
  }

  /** The hub's clock, also while a recording is shown. */
  hubNow(): number {
    return Date.now() + this.offset_ms;
  }

  /** Whether a monitor's values are out of date. */
  stale(monitor: string): boolean {
    const status = this.get(`monitors/${monitor}/status`);
    return !status || status.stale || status.at_ms === null || (!this.linked && !this.replayed);
  }

  setHello(hello: Hello): void {
    this.updated ||= this.hello !== null && this.hello.hub.version !== hello.hub.version;
    this.hello = hello;
    this.clock(hello.now_ms);
  }

  setLinked(linked: boolean): void {
    if (this.linked === linked) return;
    this.linked = linked;
    this.lostAt_ms = Date.now();
    this.tell(LINKED);
  }

  /** Replaces everything, live. */
  replace(state: Change): void {
    this.clock(state.now_ms);
    this.known = true;
    this.kept.clear();
    const before = this.live;
    this.live = new Map(Object.entries(state.set));
    if (!this.replayed) this.tellAll(new Set([...before.keys(), ...this.live.keys()]));
  }

  /** A change of live values. */
  apply(change: Change): void {
    this.clock(change.now_ms);
    this.merge(this.live, change, this.replayed === null);
    const second = Math.floor(change.now_ms / 1000);
    if (second === this.second) return;
    this.second = second;
    this.tell(SECOND);
  }

  /** Data of a topic has changed that the hub does not publish: the answer to a query. */
  announce(topic: string): void {
    this.tell(topic);
  }

  /** Ages grow also while the hub is silent. */
  tick(): void {
    if (!this.linked && !this.replayed) this.tell(SECOND);
  }

  /** From now on the store shows a recording; live values are kept separately. */
  beginReplay(): void {
    this.kept.clear();
    const before = [...this.topics.keys()];
    this.replayed = new Map();
    this.tellAll(before);
    this.tell(LINKED);
  }

  replay(change: Change): void {
    if (!this.replayed) return;
    this.replay_now_ms = change.now_ms;
    this.merge(this.replayed, change, true);
    this.tell(SECOND);
  }

  endReplay(): void {
    if (!this.replayed) return;
    this.kept.clear();
    const before = [...this.replayed.keys()];
    this.replayed = null;
    this.tellAll(new Set([...before, ...this.live.keys()]));
    this.tell(LINKED);
  }

  private get topics(): Map<string, unknown> {
    return this.replayed ?? this.live;
  }

  private clock(now_ms: number): void {
    const offset = now_ms - Date.now();
    // The quickest message has the most accurate time; a drifting or changed clock is followed slowly.
    this.offset_ms =
      this.offset_ms === 0 || Math.abs(offset - this.offset_ms) > 2000 ? offset : Math.max(offset, this.offset_ms - 1);
  }

  private merge(into: Map<string, unknown>, change: Change, shown: boolean): void {
    const set = Object.entries(change.set).map(([topic, value]) => whole(into, topic, value));
    for (const [topic, value] of set) {
      if (!into.has(topic) || topic.startsWith('alarms/')) this.kept.clear();
      into.set(topic, value);
    }
    for (const topic of change.gone ?? []) {
      into.delete(topic);
      this.kept.clear();
    }
    if (shown) this.tellAll([...set.map(([topic]) => topic), ...(change.gone ?? [])]);
  }

  private tellAll(topics: Iterable<string>): void {
    for (const topic of topics) this.tell(topic);
  }

  private tell(topic: string): void {
    for (const { prefix, fn } of this.listeners) if (topic.startsWith(prefix)) guarded(() => fn(topic));
  }
}

/** A summary is the part of a state that other pages than the monitor's own show. */
function whole(known: Map<string, unknown>, topic: string, value: unknown): [string, unknown] {
  if (!topic.endsWith(SUMMARY)) return [topic, value];
  const status = `${topic.slice(0, -SUMMARY.length)}/status`;
  const [old, summary] = [known.get(status) as Status | undefined, value as Status];
  const subsystems = { ...old?.subsystems };
  for (const [name, state] of Object.entries(summary.subsystems)) {
    subsystems[name] = { ...subsystems[name], bad: undefined, ...state };
  }
  return [status, { ...summary, subsystems }];
}

export const store = new Store();

/**
 * Renders its host again when a topic changes that starts with one of the prefixes, at most once per
 * frame; also when the link to the hub is lost or restored. `SECOND` among the prefixes: each second.
 * `seen` is the displayed part as one text: while it is equal, nothing is rendered.
 */
export class TopicController implements ReactiveController {
  private ends: (() => void)[] = [];
  private known = '';
  private frame = 0;
  private shown: string | null = null;

  constructor(
    private readonly host: ReactiveControllerHost,
    private readonly prefixes: () => string | string[],
    private readonly seen: (() => string) | null = null,
  ) {
    host.addController(this);
  }

  hostConnected(): void {
    this.known = '';
    this.follow();
  }

  hostUpdate(): void {
    this.follow();
    this.shown = this.seen?.() ?? null;
  }

  hostDisconnected(): void {
    this.end();
    cancelAnimationFrame(this.frame);
    this.frame = 0;
  }

  private follow(): void {
    const prefixes = [this.prefixes()].flat();
    const known = prefixes.join('\n');
    if (known === this.known) return;
    this.end();
    this.known = known;
    this.ends = [...prefixes, LINKED].map((prefix) => store.subscribe(prefix, this.changed));
  }

  private end(): void {
    for (const end of this.ends) end();
    this.ends = [];
  }

  private readonly changed = (): void => {
    if (this.frame) return;
    this.frame = requestAnimationFrame(() => {
      this.frame = 0;
      if (this.seen && this.seen() === this.shown) return;
      this.host.requestUpdate();
    });
  };
}

/** Alarms, the most urgent first. */
function alarmsIn(topics: ReadonlyMap<string, unknown>): Alarm[] {
  return [...topics].flatMap(([key, value]) => (key.startsWith('alarms/') ? [value as Alarm] : [])).sort(byUrgency);
}

function monitorsIn(topics: ReadonlyMap<string, unknown>): string[] {
  const ids = new Set<string>();
  for (const key of topics.keys()) {
    if (key.startsWith('monitors/')) ids.add(key.split('/')[1]!);
  }
  return [...ids].sort(byNumber);
}

const PRIORITIES = { fire: 0, high: 1, medium: 2, low: 3 } as const;
const STATES = { unack: 0, rtn_unack: 1, ack: 2, shelved: 3 } as const;

function byUrgency(a: Alarm, b: Alarm): number {
  return (
    Number(a.state === 'shelved') - Number(b.state === 'shelved') ||
    Number(b.active) - Number(a.active) ||
    PRIORITIES[a.priority] - PRIORITIES[b.priority] ||
    STATES[a.state] - STATES[b.state] ||
    b.since_ms - a.since_ms
  );
}

const collator = new Intl.Collator('en', { numeric: true });
function byNumber(a: string, b: string): number {
  return collator.compare(a, b);
}
