// Commands to monitors. The outcome goes to the caller and to the shell, which shows it; nothing here
// changes the displayed state of the monitor.
import { HubError, REPLAYED } from './errors';
import { type HaltKind, halt, onHalt } from './halt';
import { type Said, socket } from './socket';
import { LINKED, store } from './store';
import type { Authority, FrameSeen, Result, Valve } from './types';
import { type Results, sendUrgent } from './urgent';

export interface Outcome {
  /** Null: all monitors. */
  monitor: string | null;
  what: string;
  result?: Result;
  error?: HubError;
  /** Monitors that it was sent to and that have not answered yet. */
  waiting?: string[];
  /** For a command to all monitors: those that have not executed it. */
  failed?: { monitor: string; error: HubError }[];
  /** A Stop, Close or Lockout: what becomes of it is shown until a user has dismissed it. */
  urgent?: boolean;
  /** There is no answer yet after a second; it goes on. Of the hub, or of the monitors of `waiting`. */
  unconfirmed?: boolean;
  /** The hub no longer knows the monitor: STOP went to all. */
  gone?: boolean;
  /** Replaces what was said with the same key. */
  key?: string;
}

export interface Options {
  /** The monitor's id again, for requests that need a confirmation. */
  confirm?: string;
  /** The caller shows the outcome itself. */
  quiet?: boolean;
  /** Waits until the parameter is stored: `saved` of the result. */
  save?: boolean;
}

export type AuthorityAction = 'take' | 'release' | 'request' | 'grant' | 'deny' | 'force';

const STOPS: readonly HaltKind[] = ['stop', 'lockout'];
/** The hub reports a monitor as silent 200 ms after it has sent the request; a second after it, it is not confirmed. */
const CONFIRMED_MS = 700;

/** An urgent request that a monitor has not answered. */
interface Silent {
  /** The reports of silent monitors, counted. */
  report: number;
  what: string;
  late: boolean;
  timer: ReturnType<typeof setTimeout>;
}

class Commands {
  private readonly outcomes = new Set<(outcome: Outcome) => void>();
  /** Monitors that an urgent request was sent to, and that have not answered. */
  private readonly silent = new Map<string, Silent>();
  /** Each shows again that an urgent request is not confirmed: of those without an answer after a second. */
  private readonly late = new Set<() => void>();
  /** The last urgent request to each; '': to all. */
  private readonly asked = new Map<string, string>();
  /** Reports of monitors that have not answered, counted. */
  private reports = 0;
  private urgents = 0;
  private readonly watched = new Map<string, Set<(frame: FrameSeen) => void>>();

  constructor() {
    socket.on('hello', () => this.watch());
    socket.on('progress', ({ monitor, answered }) => {
      if (answered) return this.answered([monitor]);
      this.isSilent(monitor);
    });
    store.subscribe(LINKED, () => !store.linked && this.cut());
    socket.on('frame', (frame) => this.watched.get(frame.monitor)?.forEach((fn) => fn(frame)));
  }

  /** A monitor has not answered an urgent request. */
  get pending(): boolean {
    return this.silent.size > 0;
  }

  /** A request in the text form of `lafet send`. */
  request(monitor: string, text: string, options: Options = {}): Promise<Result> {
    const send = () =>
      socket
        .ask({
          type: 'request',
          monitor,
          request: text,
          t: performance.now(),
          confirm: options.confirm,
          save: options.save,
        })
        .then((answer) => answer.result!);
    return this.told(monitor, text, options, this.live(send));
  }

  /** Stops a monitor (or one subsystem of it), or all. Never refused, also during a replay. */
  stop(monitor?: string, of?: string): Promise<Results> {
    halt('stop', monitor ?? null);
    const path = monitor ? `/api/monitors/${id(monitor)}/stop` : '/api/stop';
    const what = of ? `Stop ${of}` : 'Stop All';
    const sent = this.urgent(what, { type: 'stop', monitor, of }, path, of ? { of } : undefined, monitor);
    if (!monitor || of) return sent;
    return sent.catch((error: HubError) => {
      if (error.code !== 'no_monitor') throw error;
      this.tell({ monitor, what, gone: true });
      return this.urgent(what, { type: 'stop' }, '/api/stop');
    });
  }

  /** Closes a valve, or all valves of a monitor. */
  close(monitor: string, valve?: Valve): Promise<Results> {
    halt('close', monitor);
    const path = `/api/monitors/${id(monitor)}/close`;
    const body = valve ? { valve } : undefined;
    return this.urgent(valve ? `Close ${valve}` : 'Close', { type: 'close', monitor, valve }, path, body, monitor);
  }

  /** Locks a monitor out, or all. */
  lockout(monitor?: string): Promise<Results> {
    halt('lockout', monitor ?? null);
    const path = monitor ? `/api/monitors/${id(monitor)}/lockout` : '/api/lockout';
    return this.urgent('Lockout All on', { type: 'lockout', monitor }, path, undefined, monitor);
  }

  authority(monitor: string, action: AuthorityAction, reason?: string): Promise<Authority> {
    const send = () => socket.ask({ type: 'authority', monitor, action, reason }).then((answer) => answer.authority!);
    // An answer to a client that waits is about now, whatever is shown.
    const sent = action === 'grant' || action === 'deny' ? send() : this.live(send);
    return this.told(monitor, `authority ${action}`, {}, sent);
  }

  /** Frames of a monitor's link as they pass. Returns the function that ends it. */
  watchFrames(monitor: string, fn: (frame: FrameSeen) => void): () => void {
    const all = this.watched.get(monitor) ?? new Set();
    this.watched.set(monitor, all.add(fn));
    this.watch();
    return () => {
      all.delete(fn);
      if (all.size === 0) this.watched.delete(monitor);
      this.watch();
    };
  }

  onOutcome(fn: (outcome: Outcome) => void): () => void {
    this.outcomes.add(fn);
    return () => this.outcomes.delete(fn);
  }

  /** Called before a Stop or Lockout is sent; `onHalt` hears of Close and Abort too. */
  onStop(fn: (monitor: string | null) => void): () => void {
    return onHalt(({ kind, monitor }) => STOPS.includes(kind) && fn(monitor));
  }

  private watch(): void {
    socket.send({ type: 'watch', frames: [...this.watched.keys()] });
  }

  private live<T>(send: () => Promise<T>): Promise<T> {
    return store.source === 'replay' ? Promise.reject(new HubError(REPLAYED)) : send();
  }

  /** One that does not get through at once is seen as not confirmed until it is settled. */
  private async urgent(what: string, message: Said, path: string, body?: unknown, monitor?: string): Promise<Results> {
    const key = `urgent ${this.urgents++}`;
    if (monitor === undefined) this.asked.clear();
    this.asked.set(monitor ?? '', what);
    const about = { monitor: monitor ?? null, what, key, urgent: true };
    // Where the hub has said since that a monitor is silent, it has the request.
    const before = this.reports;
    const heard = () =>
      [...this.silent].some(([id, { report }]) => report > before && (monitor === undefined || id === monitor));
    const show = () => this.tell({ ...about, unconfirmed: true });
    const unconfirmed = () => {
      this.late.add(show);
      if (!heard()) show();
    };
    try {
      const results = await sendUrgent({ message, path, body, monitor, unconfirmed });
      const told = outcomeOf(results);
      this.answered(Object.keys(results).filter((id) => !told.waiting?.includes(id)));
      const silent = this.late.has(show) && told.waiting !== undefined && !told.failed;
      this.tell({ ...about, ...told, ...(silent && { unconfirmed: true }) });
      return results;
    } catch (cause) {
      const error = HubError.of(cause);
      if (monitor) this.answered([monitor]);
      this.tell({ ...about, error });
      throw error;
    } finally {
      this.late.delete(show);
    }
  }

  /**
   * The link is gone, and with it the reports about silent monitors: they go to the connection that asked. What was not
   * confirmed is not confirmed now, either.
   */
  private cut(): void {
    for (const show of this.late) show();
    this.answered([...this.silent.keys()]);
  }

  private isSilent(monitor: string): void {
    const before = this.silent.get(monitor);
    clearTimeout(before?.timer);
    const one: Silent = {
      report: ++this.reports,
      what: this.asked.get(monitor) ?? this.asked.get('') ?? '',
      late: before?.late ?? false,
      timer: setTimeout(() => {
        one.late = true;
        this.tellSilent();
      }, CONFIRMED_MS),
    };
    this.silent.set(monitor, one);
    this.tellSilent();
  }

  /** They are no longer waited for. */
  private answered(monitors: string[]): void {
    const waited = monitors.filter((id) => this.silent.has(id));
    for (const id of waited) {
      clearTimeout(this.silent.get(id)!.timer);
      this.silent.delete(id);
    }
    if (waited.length > 0) this.tellSilent();
  }

  /** Those that are silent for longer come first: they are why it is not confirmed. */
  private tellSilent(): void {
    const all = [...this.silent];
    const late = all.filter(([, one]) => one.late);
    const told = late.length > 0 ? late : all;
    const what = new Set(told.map(([, one]) => one.what));
    this.tell({
      monitor: null,
      what: what.size === 1 ? [...what][0]! : '',
      waiting: told.map(([id]) => id),
      ...(late.length > 0 && { unconfirmed: true, urgent: true }),
      key: 'silent',
    });
  }

  private async told<T>(monitor: string | null, what: string, options: Options, pending: Promise<T>): Promise<T> {
    try {
      const result = await pending;
      if (!options.quiet) this.tell({ monitor, what, ...outcomeOf(result) });
      return result;
    } catch (cause) {
      const error = HubError.of(cause);
      if (!options.quiet) this.tell({ monitor, what, error });
      throw error;
    }
  }

  private tell(outcome: Outcome): void {
    for (const fn of this.outcomes) fn(outcome);
  }
}

/** The outcome of a result, or of those of several monitors: none that failed or is silent is omitted. */
export function outcomeOf(value: unknown): Pick<Outcome, 'result' | 'failed' | 'waiting'> {
  if (!value || typeof value !== 'object') return {};
  if ('answers' in value) return { result: value as Result };
  if ('state' in value) return {};
  const all = Object.entries(value as Results);
  const failed = all.flatMap(([monitor, one]) => ('error' in one ? [{ monitor, error: new HubError(one.error) }] : []));
  const waiting = all.flatMap(([monitor, one]) => ('pending' in one ? [monitor] : []));
  if (failed.length + waiting.length > 0)
    return { ...(failed.length && { failed }), ...(waiting.length && { waiting }) };
  return all.length === 1 ? { result: all[0]![1] as Result } : {};
}

function id(monitor: string): string {
  return encodeURIComponent(monitor);
}

export const commands = new Commands();
