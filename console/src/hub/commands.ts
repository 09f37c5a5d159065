// Commands to monitors. The outcome goes to the caller and to the shell, which shows it; nothing here
// changes the displayed state of the monitor.
import { HubError, NOT_LINKED, REPLAYED } from './errors';
import { http } from './http';
import { type Answered, socket } from './socket';
import { store } from './store';
import type { ApiError, Authority, FrameSeen, Result, Valve } from './types';

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
export type Results = Record<string, Result | { error: ApiError } | { pending: true }>;

/** A Stop without an answer after this time, ms, is also sent by the other path. */
const STOP_AGAIN_MS = 400;

class Commands {
  private readonly outcomes = new Set<(outcome: Outcome) => void>();
  private readonly stops = new Set<(monitor: string | null) => void>();
  private readonly watched = new Map<string, Set<(frame: FrameSeen) => void>>();

  constructor() {
    socket.on('hello', () => this.watch());
    socket.on('progress', ({ monitor, answered }) => {
      if (!answered) this.tell({ monitor, what: 'Stop All', waiting: [monitor] });
    });
    socket.on('frame', (frame) => this.watched.get(frame.monitor)?.forEach((fn) => fn(frame)));
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
    for (const fn of this.stops) fn(monitor ?? null);
    const path = monitor ? `/api/monitors/${id(monitor)}/stop` : '/api/stop';
    const send = this.urgent({ type: 'stop', monitor, of }, path, of ? { of } : undefined, monitor);
    return this.told(monitor ?? null, of ? `Stop ${of}` : 'Stop All', {}, send);
  }

  /** Closes a valve, or all valves of a monitor. */
  close(monitor: string, valve?: Valve): Promise<Results> {
    const path = `/api/monitors/${id(monitor)}/close`;
    const body = valve ? { valve } : undefined;
    const send = this.urgent({ type: 'close', monitor, valve }, path, body, monitor);
    return this.told(monitor, valve ? `Close ${valve}` : 'Close', {}, send);
  }

  /** Locks a monitor out, or all. */
  lockout(monitor?: string): Promise<Results> {
    for (const fn of this.stops) fn(monitor ?? null);
    const path = monitor ? `/api/monitors/${id(monitor)}/lockout` : '/api/lockout';
    const send = this.urgent({ type: 'lockout', monitor }, path, undefined, monitor);
    return this.told(monitor ?? null, 'Lockout All on', {}, send);
  }

  authority(monitor: string, action: AuthorityAction, reason?: string): Promise<Authority> {
    const send = () => socket.ask({ type: 'authority', monitor, action, reason }).then((answer) => answer.authority!);
    return this.told(monitor, `authority ${action}`, {}, this.live(send));
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

  /** Called before a Stop or Lockout is sent: held motions end. */
  onStop(fn: (monitor: string | null) => void): () => void {
    this.stops.add(fn);
    return () => this.stops.delete(fn);
  }

  private watch(): void {
    socket.send({ type: 'watch', frames: [...this.watched.keys()] });
  }

  private live<T>(send: () => Promise<T>): Promise<T> {
    return store.source === 'replay' ? Promise.reject(new HubError(REPLAYED)) : send();
  }

  /** By WebSocket, and by HTTP as well when that is down or slow. */
  private urgent(message: object, path: string, body: unknown, monitor?: string): Promise<Results> {
    const overHttp = () =>
      http
        .post<Result | Results>(path, body)
        .then((answer) => (monitor ? { [monitor]: answer as Result } : (answer as Results)));
    return new Promise((resolve, reject) => {
      let failed = 0;
      let tries = 1;
      let sentAgain = false;
      // By HTTP it is only known that it was sent; what comes of it is reported by WebSocket, if that is there.
      let sent: Results | null = null;
      const fail = (error: unknown) => {
        failed += 1;
        if (sent && HubError.of(error).code === NOT_LINKED.code) return resolve(sent);
        if (sent) return reject(HubError.of(error));
        if (failed === tries && sentAgain) reject(HubError.of(error));
        else again();
      };
      const again = () => {
        if (sentAgain) return;
        sentAgain = true;
        tries += 1;
        overHttp().then((results) => {
          if (failed === 0 && outcomeOf(results).waiting) sent = results;
          else resolve(results);
        }, fail);
      };
      const timer = setTimeout(again, STOP_AGAIN_MS);
      socket
        .ask(message)
        .then((answer) => resolve(resultsOf(answer, monitor)))
        .catch((error: unknown) => {
          const told = HubError.of(error);
          // The monitor or the hub has answered: the other path would give the same result.
          if (told.code !== NOT_LINKED.code && told.code !== 'outcome_unknown') reject(told);
          else fail(error);
        })
        .finally(() => clearTimeout(timer));
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

function resultsOf(answer: Answered, monitor?: string): Results {
  if (answer.results) return answer.results;
  return answer.result && monitor ? { [monitor]: answer.result } : {};
}

/** The outcome of a result, or of those of several monitors: a failed one is never omitted. */
export function outcomeOf(value: unknown): Pick<Outcome, 'result' | 'failed' | 'waiting'> {
  if (!value || typeof value !== 'object') return {};
  if ('answers' in value) return { result: value as Result };
  if ('state' in value) return {};
  const all = Object.entries(value as Results);
  const failed = all.flatMap(([monitor, one]) => ('error' in one ? [{ monitor, error: new HubError(one.error) }] : []));
  if (failed.length > 0) return { failed };
  const waiting = all.flatMap(([monitor, one]) => ('pending' in one ? [monitor] : []));
  if (waiting.length > 0) return { waiting };
  return all.length === 1 ? { result: all[0]![1] as Result } : {};
}

function id(monitor: string): string {
  return encodeURIComponent(monitor);
}

export const commands = new Commands();
