// The WebSocket: hello, resume, reconnecting, answers by id. Its values go to the store.

import { HubClock } from './clock';
import { HubError, NOT_LINKED, OUTCOME_UNKNOWN } from './errors';
import { guarded } from './faults';
import { http } from './http';
import { store } from './store';
import type { ApiError, Authority, Hello, Messages, Result } from './types';

/** The content of an answer besides its id: one of these. */
export interface Answered {
  result?: Result;
  results?: Record<string, Result | { error: ApiError }>;
  authority?: Authority;
}

interface Waiting {
  resolve: (answer: Answered) => void;
  reject: (error: HubError) => void;
}

const RETRY_FIRST_MS = 250;
const RETRY_MOST_MS = 4000;
/** The hub sends something each second; this long without a message means that the link is broken. */
const SILENT_MS = 2500;
const LISTEN_MS = 500;
const RESUME_KEY = 'lafet.resume';
const SESSION_ENDED = 4401;
/** The seat was resumed by another window: this one has its secret no longer. */
const SEAT_TAKEN = 4410;

/** What moves or opens: the hub refuses it when a stalled network delivers it late. */
const TIMED = new Set(['request', 'jog', 'tune']);
/** What moves as long as it is sent: never without a session, though the connection remains for STOP. */
const HELD = new Set(['jog', 'tune']);

/** A message to the hub. */
export interface Said {
  type: string;
  [field: string]: unknown;
}

class Socket {
  private ws: WebSocket | null = null;
  private wanted = false;
  private retry_ms = RETRY_FIRST_MS;
  private retryTimer = 0;
  private heard_ms = 0;
  private heardAt_ms = 0;
  private watched = false;
  /** The hub has taken this connection: it has said `hello`. */
  private greeted = false;
  private asking = false;
  private nextId = 1;
  private readonly waiting = new Map<number, Waiting>();
  private readonly listeners = new Map<string, Set<(message: never) => void>>();
  /** The monitors whose every change is subscribed to; null: all. */
  private looked: string[] | null = null;
  private readonly clock = new HubClock();
  onSessionEnded: () => void = () => {};
  onSeatTaken: () => void = () => {};

  /** Sets the monitors whose every change is sent: for the others the hub sends updates once a second. */
  look(monitors: string[] | null): void {
    if (this.looked?.join('\n') === monitors?.join('\n')) return;
    this.looked = monitors;
    this.subscribe();
  }

  /** Whether every change of a monitor is received. */
  hears(monitor: string): boolean {
    return this.looked === null || this.looked.includes(monitor);
  }

  private subscribe(): void {
    const live = store.liveMonitors();
    const monitors = this.looked?.filter((id) => live.includes(id));
    this.send({ type: 'subscribe', ...(monitors && { monitors }) });
  }

  start(): void {
    if (this.wanted) return;
    // Another session has another connection.
    if (this.ws) this.drop();
    this.wanted = true;
    this.open();
    if (this.watched) return;
    this.watched = true;
    window.setInterval(() => this.listen(), LISTEN_MS);
    window.addEventListener('online', () => this.reopen());
    // After a sleep nothing has been heard for its whole time, whatever the timers say.
    for (const type of ['pageshow', 'focus']) window.addEventListener(type, () => this.listen());
    for (const type of ['visibilitychange', 'resume']) document.addEventListener(type, () => this.listen());
  }

  stop(): void {
    sessionStorage.removeItem(RESUME_KEY);
    this.rest();
    this.ws?.close();
  }

  /**
   * Without a session there is nothing to connect with, until `start`. A connection that is heard remains, for STOP: only the
   * hub knows whether its session has ended, and closes it then. The cookie may be that of another hub on the same host.
   */
  rest(): void {
    this.wanted = false;
    clearTimeout(this.retryTimer);
    if (!this.alive) this.ws?.close();
  }

  /** Whether the hub is heard now: what is sent reaches it. */
  get alive(): boolean {
    return this.ws?.readyState === WebSocket.OPEN && store.linked && this.silence() < SILENT_MS;
  }

  /** Whether this tab was connected before, without a logout since. */
  get resumes(): boolean {
    return sessionStorage.getItem(RESUME_KEY) !== null;
  }

  /** Breaks the connection for this time, to demonstrate a lost link. */
  interrupt(for_ms: number): void {
    this.drop();
    clearTimeout(this.retryTimer);
    this.retryTimer = window.setTimeout(() => this.open(), for_ms);
  }

  /** Messages that are not topics: `socket.on('event', fn)`. Returns the function that ends it. */
  on<K extends keyof Messages>(type: K, fn: (message: Messages[K]) => void): () => void {
    const all = this.listeners.get(type) ?? new Set();
    this.listeners.set(type, all);
    all.add(fn as (message: never) => void);
    return () => all.delete(fn as (message: never) => void);
  }

  /** The hub's time since its start, not ahead of it; null: nothing was heard of it. */
  hubUp(): number | null {
    return this.clock.now();
  }

  /** Sends a message without an answer; false if there is no connection, or no session for what is held. */
  send(message: Said): boolean {
    if (this.ws?.readyState !== WebSocket.OPEN) return false;
    if (!this.wanted && HELD.has(message.type)) return false;
    const up_ms = TIMED.has(message.type) ? this.clock.now() : null;
    this.ws.send(JSON.stringify(up_ms === null ? message : { ...message, up_ms }));
    return true;
  }

  ask(message: Said): Promise<Answered> {
    const id = this.nextId++;
    return new Promise((resolve, reject) => {
      if (!store.linked || !this.send({ ...message, id })) {
        reject(new HubError(NOT_LINKED));
        return;
      }
      this.waiting.set(id, { resolve, reject });
    });
  }

  private open(): void {
    const resume = sessionStorage.getItem(RESUME_KEY);
    const query = resume ? `?resume=${encodeURIComponent(resume)}` : '';
    const ws = new WebSocket(`${location.origin.replace(/^http/, 'ws')}/api/ws${query}`);
    this.ws = ws;
    this.greeted = false;
    this.heard();
    ws.onmessage = (event) => this.hear(String(event.data));
    ws.onclose = (event) => {
      if (this.ws === ws) this.closed(event.code);
    };
  }

  private reopen(): void {
    if (!this.wanted || this.ws) return;
    clearTimeout(this.retryTimer);
    this.open();
  }

  /** A silent connection is closed before the browser would close it. */
  private listen(): void {
    store.tick();
    if (this.ws && this.silence() >= SILENT_MS) this.drop();
  }

  /** Closes it here: that the browser has closed it may be reported much later. */
  private drop(): void {
    const dead = this.ws;
    this.ws = null;
    if (dead) {
      dead.onmessage = null;
      dead.close();
    }
    this.closed(0);
  }

  private heard(): void {
    this.heard_ms = performance.now();
    this.heardAt_ms = Date.now();
  }

  /** By both clocks: one does not run while the computer sleeps, the other may be set. */
  private silence(): number {
    return Math.max(performance.now() - this.heard_ms, Date.now() - this.heardAt_ms);
  }

  private closed(code: number): void {
    this.ws = null;
    store.setLinked(false);
    for (const { reject } of this.waiting.values()) reject(new HubError(OUTCOME_UNKNOWN));
    this.waiting.clear();
    if (code === SESSION_ENDED) {
      this.wanted = false;
      this.onSessionEnded();
    }
    if (code === SEAT_TAKEN) {
      sessionStorage.removeItem(RESUME_KEY);
      this.onSeatTaken();
    }
    if (!this.wanted) return;
    if (!this.greeted) void this.askSession();
    const wait = this.retry_ms * (0.75 + Math.random() / 2);
    this.retry_ms = Math.min(this.retry_ms * 2, RETRY_MOST_MS);
    this.retryTimer = window.setTimeout(() => this.open(), wait);
  }

  /** A browser does not say why it got no connection. If it is for want of a session, `http` calls for a login. */
  private async askSession(): Promise<void> {
    if (this.asking) return;
    this.asking = true;
    await http.get('/api/session').catch(() => {});
    this.asking = false;
  }

  private hear(text: string): void {
    this.heard();
    const message = JSON.parse(text) as { type: string; id?: number; up_ms?: number };
    if (message.type === 'hello') this.clock.forget();
    if (message.up_ms !== undefined) this.clock.heard(message.up_ms);
    switch (message.type) {
      case 'hello': {
        this.greeted = true;
        const hello = message as unknown as Hello;
        if (hello.resume === null) sessionStorage.removeItem(RESUME_KEY);
        else sessionStorage.setItem(RESUME_KEY, hello.resume);
        this.retry_ms = RETRY_FIRST_MS;
        store.setHello(hello);
        break;
      }
      case 'state':
        store.replace(message as never);
        store.setLinked(true);
        if (this.looked) this.subscribe();
        return;
      case 'change':
        store.apply(message as never);
        return;
      case 'answer':
        this.answered(message as never);
        return;
    }
    for (const fn of this.listeners.get(message.type) ?? []) guarded(() => fn(message as never));
  }

  private answered(message: Answered & { id: number; error?: ApiError }): void {
    const waiting = this.waiting.get(message.id);
    this.waiting.delete(message.id);
    if (message.error) waiting?.reject(new HubError(message.error));
    else waiting?.resolve(message);
  }
}

export const socket = new Socket();

/** A network that was dead delivers what was sent meanwhile: the hub refuses what people were shown as unanswered. */
export function inTime(path: string): string {
  const up_ms = socket.hubUp();
  return up_ms === null ? path : `${path}?up_ms=${up_ms}`;
}
