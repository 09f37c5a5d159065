// A Stop, Close or Lockout on its way: by WebSocket, and by HTTP as well when that is down or slow. Where neither brings an
// answer it is not given up: it is sent again and again, and at once when the hub is back, and the operator sees that it is
// not confirmed.
import { HubError, NOT_LINKED, OUTCOME_UNKNOWN } from './errors';
import { http } from './http';
import { type Answered, type Said, socket } from './socket';
import { LINKED, store } from './store';
import type { ApiError, Result } from './types';

export type Results = Record<string, Result | { error: ApiError } | { pending: true }>;

export interface Urgent {
  message: Said;
  path: string;
  body: unknown;
  monitor?: string;
  /** It has no answer yet after a second. */
  unconfirmed: () => void;
}

/** A Stop without an answer after this time, ms, is also sent by the other path. */
const AGAIN_MS = 400;
const CONFIRMED_MS = 1000;
/**
 * One without an answer is sent again after this time, ms: a page that asks to log in has no link that could come back, and
 * a connection that has died unseen refuses nothing.
 */
const RETRY_MS = 2000;
/** After this time, ms, it is no longer what the operator meant: it fails, and says so. */
const GIVEN_UP_MS = 60_000;

let insisting = 0;

/** Some order is given until it is answered, and has no answer. */
export function isInsisting(): boolean {
  return insisting > 0;
}

export function sendUrgent(urgent: Urgent): Promise<Results> {
  let asked = 0;
  const ask = () => {
    asked += 1;
    return socket.ask(urgent.message).finally(() => {
      asked -= 1;
    });
  };
  return insist(
    () => once(urgent, ask),
    urgent.unconfirmed,
    () => asked > 0,
  );
}

/**
 * Gives an order, and again every 2 s and whenever the hub is back, until it is answered. The tries before go on meanwhile:
 * the answer to any of them counts. `hasIt`: the hub has it, waits for a monitor, and will answer; it is not given again.
 */
export function insist<T>(give: () => Promise<T>, unconfirmed: () => void, hasIt = () => false): Promise<T> {
  return new Promise((resolve, reject) => {
    const late = setTimeout(unconfirmed, CONFIRMED_MS);
    // A try that has left this page may have been carried out.
    let [given, unsent] = [0, 0];
    const give_up = () => over(() => reject(new HubError(unsent === given ? NOT_LINKED : OUTCOME_UNKNOWN)));
    const end = setTimeout(give_up, GIVEN_UP_MS);
    // One of them goes on while the machine sleeps, when timers do not.
    const began = [Date.now(), performance.now()] as const;
    const isOld = () => Math.max(Date.now() - began[0], performance.now() - began[1]) > GIVEN_UP_MS;
    let settled = false;
    insisting += 1;
    let retry: ReturnType<typeof setTimeout> | undefined;
    let unfollow = () => {};
    const over = (act: () => void) => {
      if (settled) return;
      settled = true;
      insisting -= 1;
      clearTimeout(late);
      clearTimeout(end);
      clearTimeout(retry);
      unfollow();
      act();
    };
    const again = () => {
      clearTimeout(retry);
      if (isOld()) give_up();
      else void attempt();
    };
    const wait = () => {
      retry = setTimeout(() => (hasIt() ? wait() : again()), RETRY_MS);
    };
    const attempt = () => {
      given += 1;
      wait();
      return give().then(
        (value) => over(() => resolve(value)),
        (cause) => {
          const error = HubError.of(cause);
          if (!isLost(error)) return over(() => reject(error));
          if (error.code === NOT_LINKED.code) unsent += 1;
        },
      );
    };
    unfollow = store.subscribe(LINKED, () => {
      if (store.linked && !settled) again();
    });
    void attempt();
  });
}

/** There was no answer of the hub: what a proxy says in its place is none. */
function isLost({ code, details }: HubError): boolean {
  return code === NOT_LINKED.code || details.cut === true || code.startsWith('HTTP 5');
}

function once({ path, body, monitor }: Urgent, ask: () => Promise<Answered>): Promise<Results> {
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
    // That one path has not sent it says nothing of the other.
    let unsure: HubError | null = null;
    const fail = (cause: unknown) => {
      const error = HubError.of(cause);
      failed += 1;
      if (error.details.cut) unsure = error;
      if (sent && isLost(error)) return resolve(sent);
      if (sent) return reject(error);
      if (failed === tries && sentAgain) reject(unsure && isLost(error) ? unsure : error);
      else again();
    };
    const again = () => {
      if (sentAgain) return;
      sentAgain = true;
      tries += 1;
      overHttp().then((results) => {
        if (failed === 0 && Object.values(results).some((one) => 'pending' in one)) sent = results;
        else resolve(results);
      }, fail);
    };
    const timer = setTimeout(again, AGAIN_MS);
    ask()
      .then((answer) => resolve(resultsOf(answer, monitor)))
      .catch((error: unknown) => {
        const told = HubError.of(error);
        // The monitor or the hub has answered: the other path would give the same result.
        if (!isLost(told) && told.code !== 'outcome_unknown') reject(told);
        else fail(error);
      })
      .finally(() => clearTimeout(timer));
  });
}

function resultsOf(answer: Answered, monitor?: string): Results {
  if (answer.results) return answer.results;
  return answer.result && monitor ? { [monitor]: answer.result } : {};
}
