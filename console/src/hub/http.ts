// HTTP to the hub: JSON, CSRF, errors as HubError.
import { HubError, NOT_LINKED, OUTCOME_UNKNOWN, ofStatus } from './errors';
import type { ApiError, Session } from './types';

/** A query without an answer after this time, ms, gets none: the network is dead. Its content may take longer. */
const READ_MOST_MS = 10_000;
const CONTENT_MOST_MS = 60_000;
/**
 * Orders that end something may be given any number of times: one without an answer after this time, ms, is ended, and its
 * connection with it. That may have died unseen; of the six that a browser has, orders every 2 s then hold three.
 */
const ENDS = /\/(stop|close|lockout|abort|lock)$/;
const ENDS_MOST_MS = 6000;

type Method = 'GET' | 'POST' | 'PUT' | 'PATCH' | 'DELETE';

class Http {
  private csrf = '';
  private user = '';
  /** Called when another user has logged in beside this page: it is no longer theirs. */
  onOtherUser: (user: string) => void = () => {};
  /** Called when the hub wants a login. */
  onLoginNeeded: (setupNeeded: boolean) => void = () => {};

  get = <T>(path: string): Promise<T> => this.send<T>('GET', path);
  post = <T>(path: string, body?: unknown): Promise<T> => this.send<T>('POST', path, body);
  put = <T>(path: string, body?: unknown): Promise<T> => this.send<T>('PUT', path, body);
  patch = <T>(path: string, body?: unknown): Promise<T> => this.send<T>('PATCH', path, body);
  delete = <T>(path: string): Promise<T> => this.send<T>('DELETE', path);

  /** A file as the body. */
  postFile = <T>(path: string, file: Blob): Promise<T> => this.send<T>('POST', path, file);

  private asked: Promise<Session> | null = null;

  /** Requests the session before a page needs it. */
  early(): void {
    this.asked = this.get<Session>('/api/session');
    this.asked.catch(() => {});
  }

  /** The session, whose CSRF token is sent with every request from now on. */
  async session(): Promise<Session> {
    const asked = this.asked ?? this.get<Session>('/api/session');
    this.asked = null;
    return this.keep(await asked);
  }

  async login(user: string, password: string): Promise<Session> {
    return this.keep(await this.post<Session>('/api/login', { user, password }));
  }

  async setup(token: string, user: string, password: string): Promise<Session> {
    return this.keep(await this.post<Session>('/api/setup', { token, user, password }));
  }

  private keep(session: Session): Session {
    this.csrf = session.csrf;
    this.user = session.user;
    return session;
  }

  /** With the token of a login in another tab, where this page's own is old. */
  private async send<T>(method: Method, path: string, body?: unknown): Promise<T> {
    try {
      return await this.once<T>(method, path, body);
    } catch (cause) {
      if (!(cause instanceof HubError) || cause.code !== 'csrf' || !this.user) throw cause;
      if (!(await this.renewed())) throw cause;
      return this.once<T>(method, path, body);
    }
  }

  /** Whether the session of this browser is still that of this page's user. */
  private async renewed(): Promise<boolean> {
    const now = await this.once<Session>('GET', '/api/session').catch(() => null);
    if (!now) return false;
    if (now.user === this.user) return this.keep(now) === now;
    this.onOtherUser(now.user);
    return false;
  }

  private async once<T>(method: Method, path: string, body?: unknown): Promise<T> {
    const headers: Record<string, string> = {};
    if (body !== undefined) {
      headers['content-type'] = body instanceof Blob ? 'application/octet-stream' : 'application/json';
    }
    if (method !== 'GET' && this.csrf) headers['x-csrf-token'] = this.csrf;
    const ends = method === 'POST' && ENDS.test(path);
    const dead = method === 'GET' || ends ? new AbortController() : null;
    let timer = dead && setTimeout(() => dead.abort(), ends ? ENDS_MOST_MS : READ_MOST_MS);
    // Sent, it may have been carried out.
    const unanswered = ends ? OUTCOME_UNKNOWN : NOT_LINKED;
    let answer: Response;
    try {
      answer = await fetch(path, {
        method,
        headers,
        body: body === undefined || body instanceof Blob ? body : JSON.stringify(body),
        // A Stop in flight survives the end of the page.
        keepalive: ends,
        signal: dead?.signal,
      });
    } catch {
      throw new HubError(dead?.signal.aborted ? unanswered : NOT_LINKED);
    } finally {
      clearTimeout(timer ?? 0);
    }
    timer = dead && setTimeout(() => dead.abort(), CONTENT_MOST_MS);
    // Its content may fail to come, too.
    const content = await parsed(answer)
      .catch((cause) => {
        if (cause instanceof SyntaxError) throw cause;
        throw new HubError(unanswered);
      })
      .finally(() => clearTimeout(timer ?? 0));
    if (answer.ok) return (answer.status === 204 ? undefined : content) as T;
    const error = errorOf(answer.status, content);
    if (answer.status === 401 && error.code === 'login_needed') {
      this.onLoginNeeded(error.setup_needed === true);
    }
    throw new HubError(error);
  }
}

async function parsed(answer: Response): Promise<unknown> {
  const text = await answer.text();
  if (!answer.headers.get('content-type')?.includes('json')) return text;
  return JSON.parse(text);
}

function errorOf(status: number, body: unknown): ApiError {
  const error = (body as { error?: ApiError } | null)?.error;
  return error ?? ofStatus(status);
}

export const http = new Http();
