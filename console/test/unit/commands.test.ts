import { afterEach, beforeEach, describe, expect, test, vi } from 'vitest';
import { commands, type Outcome, outcomeOf } from '../../src/hub/commands';
import { HubError, NOT_LINKED, OUTCOME_UNKNOWN, ofStatus } from '../../src/hub/errors';
import { type Halt, onHalt } from '../../src/hub/halt';
import { http } from '../../src/hub/http';
import { type Answered, socket } from '../../src/hub/socket';
import { store } from '../../src/hub/store';
import type { Result } from '../../src/hub/types';
import { noteOf } from '../../src/shell/toasts';
import { abortZone, lockZones } from '../../src/shell/zones';

const done: Result = { ok: true, request: 'Stop All', took_ms: 4, audit: 1, answers: [] };
const away = { error: { code: 'not_connected', en: 'M2 is not connected.', ru: 'M2 не подключён.' } };

test('a STOP to all reports the monitors that have not executed it', () => {
  const { failed, result } = outcomeOf({ M1: done, M2: away, M3: done });
  expect(failed?.map(({ monitor, error }) => `${monitor} ${error.code}`)).toEqual(['M2 not_connected']);
  expect(result).toBeUndefined();
});

test('a STOP to one monitor reports its answers', () => {
  expect(outcomeOf({ M1: done })).toEqual({ result: done });
  expect(outcomeOf(done)).toEqual({ result: done });
  expect(outcomeOf({ M1: done, M2: done })).toEqual({});
  expect(outcomeOf({ state: 'free', holder: null, request: null })).toEqual({});
});

test('a monitor that has not answered yet is named at once', () => {
  const outcome = outcomeOf({ M1: done, M2: { pending: true } });
  expect(outcome).toEqual({ waiting: ['M2'] });
  const note = noteOf({ monitor: null, what: 'Stop All', ...outcome });
  expect(note).toMatchObject({ kind: 'warning', text: 'stop.no_answer_yet' });
});

beforeEach(() => void vi.useFakeTimers());
afterEach(() => {
  vi.useRealTimers();
  vi.restoreAllMocks();
});

/** A STOP whose answer by HTTP is that it was sent, and what came of it by WebSocket after 3 s. */
async function stopOf(told: () => Promise<Answered>): Promise<unknown> {
  vi.spyOn(http, 'post').mockResolvedValue({ pending: true });
  vi.spyOn(socket, 'ask').mockImplementation(async () => {
    await new Promise((resolve) => setTimeout(resolve, 3000));
    return told();
  });
  const result = commands.stop('M1').catch((error: HubError) => error.code);
  await vi.advanceTimersByTimeAsync(3001);
  return result;
}

test('that a STOP is sent is not all that is reported of it, while there is a WebSocket', async () => {
  expect(await stopOf(async () => ({ result: done }) as Answered)).toEqual({ M1: done });
  const silent = new HubError({ code: 'outcome_unknown', en: '', ru: '' });
  expect(await stopOf(() => Promise.reject(silent))).toBe('outcome_unknown');
  const cut = () => Promise.reject(new HubError(NOT_LINKED));
  expect(await stopOf(cut)).toEqual({ M1: { pending: true } });
});

test('what failed does not conceal who has not answered', () => {
  const outcome = outcomeOf({ M1: done, M2: away, M3: { pending: true } });
  expect(outcome.waiting).toEqual(['M3']);
  expect(outcome.failed?.map(({ monitor }) => monitor)).toEqual(['M2']);
  const note = noteOf({ monitor: null, what: 'Stop All', urgent: true, ...outcome });
  expect(note).toMatchObject({ kind: 'error', text: expect.stringContaining('stop.not_done'), stays: true });
  expect(note?.more).toContain('stop.no_answer_yet');
});

test('only what became of a STOP stays until it was seen', () => {
  const error = new HubError(NOT_LINKED);
  expect(noteOf({ monitor: 'M1', what: 'Stop All', urgent: true, error })?.stays).toBe(true);
  expect(noteOf({ monitor: 'M1', what: 'Open Valve1', error })?.stays).toBeUndefined();
  expect(noteOf({ monitor: 'M1', what: 'Stop All', urgent: true, result: done })?.stays).toBeUndefined();
});

describe('a STOP into a dead network', () => {
  let told: Outcome[];
  let end: () => void;

  beforeEach(() => {
    told = [];
    end = commands.onOutcome((outcome) => told.push(outcome));
    store.setLinked(false);
  });
  afterEach(() => {
    end();
    store.setLinked(false);
  });

  const notes = () => told.map((outcome) => (outcome.unconfirmed ? 'unconfirmed' : outcome.error ? 'failed' : 'done'));

  test('is said not to be confirmed after a second, and sent again when the hub is back', async () => {
    vi.spyOn(http, 'post').mockImplementation(() => new Promise(() => {}));
    const ask = vi.spyOn(socket, 'ask').mockRejectedValue(new HubError(NOT_LINKED));
    const result = commands.stop('M1');
    await vi.advanceTimersByTimeAsync(900);
    expect(notes()).toEqual([]);
    await vi.advanceTimersByTimeAsync(200);
    expect(notes()).toEqual(['unconfirmed']);
    const { key } = told[0]!;
    await vi.advanceTimersByTimeAsync(20_000);
    const before = ask.mock.calls.length;
    ask.mockResolvedValue({ result: done } as Answered);
    store.setLinked(true);
    expect(await result).toEqual({ M1: done });
    expect(ask).toHaveBeenCalledTimes(before + 1);
    expect(notes()).toEqual(['unconfirmed', 'done']);
    expect(told[1]!.key, 'in the place of what was said before').toBe(key);
    await vi.advanceTimersByTimeAsync(100_000);
    expect(notes()).toHaveLength(2);
  });

  test('is not given up because both paths fail, but after a minute', async () => {
    vi.spyOn(http, 'post').mockRejectedValue(new HubError(NOT_LINKED));
    vi.spyOn(socket, 'ask').mockRejectedValue(new HubError(NOT_LINKED));
    const result = commands.stop('M1').catch((error: HubError) => error.code);
    await vi.advanceTimersByTimeAsync(59_000);
    expect(notes()).toEqual(['unconfirmed']);
    await vi.advanceTimersByTimeAsync(2000);
    expect(await result).toBe('not_linked');
    expect(notes()).toEqual(['unconfirmed', 'failed']);
    const asked = vi.mocked(socket.ask).mock.calls.length;
    store.setLinked(true);
    await vi.advanceTimersByTimeAsync(1000);
    expect(vi.mocked(socket.ask).mock.calls.length).toBe(asked);
  });

  test('is not sent again hours later, after the machine has slept', async () => {
    vi.spyOn(http, 'post').mockRejectedValue(new HubError(NOT_LINKED));
    const ask = vi.spyOn(socket, 'ask').mockRejectedValue(new HubError(NOT_LINKED));
    const result = commands.lockout('M1').catch((error: HubError) => error.code);
    await vi.advanceTimersByTimeAsync(5000);
    const asked = ask.mock.calls.length;
    // Timers do not run meanwhile.
    vi.setSystemTime(Date.now() + 7_200_000);
    store.setLinked(true);
    await vi.advanceTimersByTimeAsync(100);
    expect(await result).toBe('not_linked');
    expect(ask).toHaveBeenCalledTimes(asked);
  });

  test('is said not to be confirmed although a monitor was silent before', async () => {
    const progress = vi.spyOn(http, 'post').mockResolvedValue({ M7: { pending: true } } as never);
    vi.spyOn(socket, 'ask').mockRejectedValue(new HubError(NOT_LINKED));
    const listeners = Reflect.get(socket, 'listeners') as Map<string, Set<(message: object) => void>>;
    for (const hear of listeners.get('progress')!) hear({ monitor: 'M7', answered: false });
    await commands.stop();
    progress.mockImplementation(() => new Promise(() => {}));
    told.length = 0;
    void commands.stop().catch(() => {});
    await vi.advanceTimersByTimeAsync(1100);
    expect(notes()).toContain('unconfirmed');
  });

  test('is sent again where no link can come back: on the page that asks to log in', async () => {
    const post = vi.spyOn(http, 'post').mockRejectedValueOnce(new HubError(NOT_LINKED)).mockResolvedValue(done);
    vi.spyOn(socket, 'ask').mockRejectedValue(new HubError(NOT_LINKED));
    const result = commands.stop('M1');
    await vi.advanceTimersByTimeAsync(5000);
    expect(post).toHaveBeenCalledTimes(2);
    expect(await result).toEqual({ M1: done });
    await vi.advanceTimersByTimeAsync(100_000);
    expect(post, 'what is answered is not sent again').toHaveBeenCalledTimes(2);
  });

  test('is sent by one timer, however often the link comes and goes', async () => {
    const post = vi.spyOn(http, 'post').mockRejectedValue(new HubError(NOT_LINKED));
    vi.spyOn(socket, 'ask').mockRejectedValue(new HubError(NOT_LINKED));
    void commands.stop('M1').catch(() => {});
    for (let n = 0; n < 3; n += 1) {
      await vi.advanceTimersByTimeAsync(100);
      store.setLinked(true);
      await vi.advanceTimersByTimeAsync(100);
      store.setLinked(false);
    }
    const sent = () => post.mock.calls.filter(([to]) => to === '/api/monitors/M1/stop').length;
    const before = sent();
    await vi.advanceTimersByTimeAsync(6100);
    expect(sent() - before).toBe(3);
    await vi.advanceTimersByTimeAsync(60_000);
  });

  test.each([
    ['an abort of a zone', () => abortZone('hall')],
    ['a lockout of the zones', () => lockZones(true)],
  ])('so is %s', async (_, order) => {
    const post = vi.spyOn(http, 'post').mockRejectedValueOnce(new HubError(NOT_LINKED)).mockResolvedValue(undefined);
    const result = order();
    await vi.advanceTimersByTimeAsync(5000);
    expect(await result).toBe(true);
    expect(post).toHaveBeenCalledTimes(2);
  });

  test.each([
    ['STOP', () => commands.stop('M1')],
    ['an abort of a zone', () => abortZone('hall')],
    ['a lockout of the zones', () => lockZones(true)],
  ])('is sent again though connections that died unseen take it and refuse nothing: %s', async (_, order) => {
    const post = vi.spyOn(http, 'post').mockImplementation(() => new Promise(() => {}));
    vi.spyOn(socket, 'ask').mockRejectedValue(new HubError(NOT_LINKED));
    const result = order();
    await vi.advanceTimersByTimeAsync(1900);
    expect(post).toHaveBeenCalledTimes(1);
    await vi.advanceTimersByTimeAsync(2000);
    expect(post).toHaveBeenCalledTimes(2);
    post.mockResolvedValue(done);
    await vi.advanceTimersByTimeAsync(200);
    expect(await result).toBeTruthy();
    await vi.advanceTimersByTimeAsync(10_000);
    expect(post, 'what is answered is not sent again').toHaveBeenCalledTimes(3);
  });

  test('is answered, though late, by a try after which it was sent again', async () => {
    let late = () => {};
    vi.spyOn(http, 'post')
      .mockImplementationOnce(
        () =>
          new Promise((resolve) => {
            late = () => resolve(done as never);
          }),
      )
      .mockRejectedValue(new HubError(NOT_LINKED));
    vi.spyOn(socket, 'ask').mockRejectedValue(new HubError(NOT_LINKED));
    const result = commands.stop('M1');
    await vi.advanceTimersByTimeAsync(5000);
    late();
    expect(await result).toEqual({ M1: done });
  });

  test.each<[string, Error | null, Error]>([
    ['has no answer to a try', null, new HubError(NOT_LINKED)],
    ['has ended a try without an answer', new HubError(OUTCOME_UNKNOWN), new HubError(NOT_LINKED)],
    ['was cut off while it was asked', new HubError(NOT_LINKED), new HubError(OUTCOME_UNKNOWN)],
  ])('may have been carried out, where the page %s', async (_, posted, asked) => {
    const hangs = () => new Promise<never>(() => {});
    vi.spyOn(http, 'post').mockImplementation(() => (posted ? Promise.reject(posted) : hangs()));
    vi.spyOn(socket, 'ask').mockRejectedValue(asked);
    const result = commands.stop('M1').catch((error: HubError) => error.code);
    await vi.advanceTimersByTimeAsync(61_000);
    expect(await result).toBe('outcome_unknown');
    expect(notes()).toEqual(['unconfirmed', 'failed']);
  });

  test('is not sent again while the hub has it and waits for the monitor', async () => {
    const post = vi.spyOn(http, 'post').mockImplementation(() => new Promise(() => {}));
    let answer = () => {};
    const ask = vi.spyOn(socket, 'ask').mockImplementation(
      () =>
        new Promise((resolve) => {
          answer = () => resolve({ result: done } as Answered);
        }),
    );
    const result = commands.stop('M1');
    await vi.advanceTimersByTimeAsync(15_000);
    answer();
    expect(await result).toEqual({ M1: done });
    expect([ask.mock.calls.length, post.mock.calls.length]).toEqual([1, 1]);
  });

  test('is not given up because a proxy says that it cannot reach the hub', async () => {
    const proxy = new HubError(ofStatus(502));
    vi.spyOn(http, 'post').mockRejectedValue(proxy);
    const ask = vi.spyOn(socket, 'ask').mockRejectedValue(new HubError(NOT_LINKED));
    const result = commands.stop('M1');
    await vi.advanceTimersByTimeAsync(5000);
    expect(notes()).toEqual(['unconfirmed']);
    ask.mockResolvedValue({ result: done } as Answered);
    store.setLinked(true);
    expect(await result).toEqual({ M1: done });
  });

  test('whose connection breaks before the answer is sent again, and a second break does not end that', async () => {
    vi.spyOn(http, 'post').mockRejectedValue(new HubError(NOT_LINKED));
    const ask = vi.spyOn(socket, 'ask').mockRejectedValue(new HubError(OUTCOME_UNKNOWN));
    const result = commands.lockout();
    for (let n = 0; n < 2; n += 1) {
      store.setLinked(true);
      await vi.advanceTimersByTimeAsync(500);
      store.setLinked(false);
    }
    ask.mockResolvedValue({ results: { M1: done } });
    store.setLinked(true);
    expect(await result).toEqual({ M1: done });
    expect(ask).toHaveBeenCalledTimes(4);
  });
});

describe('a STOP that a monitor does not answer', () => {
  const listeners = Reflect.get(socket, 'listeners') as Map<string, Set<(message: object) => void>>;
  const progress = (monitor: string, answered: boolean) => {
    for (const hear of listeners.get('progress')!) hear({ monitor, answered });
  };
  const protocol =
    'Stop All: sent to tcp://127.0.0.1:10485?addr=2, no answer; GetStatus All shows when motion has ended.';
  const unknown = new HubError({ code: 'outcome_unknown', en: protocol, ru: protocol });
  let told: Outcome[];
  let end: () => void;

  beforeEach(() => {
    told = [];
    end = commands.onOutcome((outcome) => told.push(outcome));
  });
  afterEach(() => end());

  test('is said to be on its way, and not confirmed a second after it was sent', async () => {
    vi.spyOn(http, 'post').mockImplementation(() => new Promise(() => {}));
    vi.spyOn(socket, 'ask').mockImplementation(() => new Promise(() => {}));
    void commands.stop('M2');
    await vi.advanceTimersByTimeAsync(200);
    progress('M2', false);
    expect(noteOf(told.at(-1)!)).toMatchObject({ kind: 'warning', text: 'stop.no_answer_yet' });
    await vi.advanceTimersByTimeAsync(800);
    expect(noteOf(told.at(-1)!)).toMatchObject({
      kind: 'error',
      text: 'M2 · stop.stop: stop.unconfirmed',
      more: 'stop.silent_yet',
      stays: true,
    });
    expect(told.filter(({ unconfirmed }) => unconfirmed)).toHaveLength(1);
    progress('M2', true);
    expect(told.at(-1)).toMatchObject({ waiting: [], key: 'silent' });
    expect(noteOf(told.at(-1)!)).toBeNull();
  });

  describe('whose link breaks', () => {
    beforeEach(async () => {
      // What the tests before have left open is answered.
      vi.spyOn(http, 'post').mockResolvedValue(done);
      vi.spyOn(socket, 'ask').mockResolvedValue({ result: done } as Answered);
      store.setLinked(true);
      await vi.advanceTimersByTimeAsync(0);
      vi.restoreAllMocks();
      told.length = 0;
    });
    afterEach(() => store.setLinked(false));
    /** What an operator sees of it at the end. */
    const seen = () => {
      const shown = new Map<string | undefined, ReturnType<typeof noteOf>>();
      for (const outcome of told) shown.set(outcome.key, noteOf(outcome));
      return [...shown.values()].filter((note) => note !== null);
    };

    /** Sent by WebSocket, and without an answer until the link is cut. */
    function hanging() {
      let cut = () => {};
      const ask = vi.spyOn(socket, 'ask').mockImplementationOnce(
        () =>
          new Promise((_, reject) => {
            cut = () => reject(new HubError(OUTCOME_UNKNOWN));
          }),
      );
      return { ask, cut: () => cut() };
    }

    test('stays not confirmed until it is settled', async () => {
      vi.spyOn(http, 'post').mockImplementation(() => new Promise(() => {}));
      const { ask, cut } = hanging();
      const result = commands.stop('M2');
      await vi.advanceTimersByTimeAsync(200);
      progress('M2', false);
      await vi.advanceTimersByTimeAsync(1000);
      expect(seen()).toMatchObject([{ text: 'M2 · stop.stop: stop.unconfirmed', more: 'stop.silent_yet' }]);
      store.setLinked(false);
      cut();
      const note = { kind: 'error', text: expect.stringContaining('stop.unconfirmed'), stays: true };
      expect(seen()).toMatchObject([note]);
      await vi.advanceTimersByTimeAsync(10_000);
      expect(seen()).toMatchObject([note]);
      ask.mockResolvedValue({ result: done } as Answered);
      store.setLinked(true);
      await result;
      expect(seen()).toMatchObject([{ kind: 'ok' }]);
    });

    test('stays not confirmed also where the other path has sent it', async () => {
      vi.spyOn(http, 'post').mockResolvedValue({ pending: true });
      const { cut } = hanging();
      const result = commands.stop('M2');
      await vi.advanceTimersByTimeAsync(500);
      progress('M2', false);
      await vi.advanceTimersByTimeAsync(1000);
      store.setLinked(false);
      cut();
      expect(await result).toEqual({ M2: { pending: true } });
      expect(seen()).toMatchObject([{ text: 'M2 · stop.stop: stop.unconfirmed', stays: true }]);
    });

    test('is not said to be unconfirmed before its second is over', async () => {
      vi.spyOn(http, 'post').mockImplementation(() => new Promise(() => {}));
      vi.spyOn(socket, 'ask').mockImplementation(() => new Promise(() => {}));
      void commands.stop('M2');
      await vi.advanceTimersByTimeAsync(300);
      progress('M2', false);
      store.setLinked(false);
      expect(seen()).toEqual([]);
      await vi.advanceTimersByTimeAsync(800);
      expect(seen()).toMatchObject([{ text: expect.stringContaining('stop.unconfirmed') }]);
    });
  });

  test('says in words of the operator what may be', () => {
    const one = noteOf({ monitor: 'M2', what: 'Stop All', urgent: true, error: unknown });
    expect(one).toMatchObject({ text: 'M2 · stop.stop: stop.unconfirmed', more: 'stop.silent', stays: true });
    const failed = [{ monitor: 'M2', error: unknown }];
    const all = noteOf({ monitor: null, what: 'Lockout All on', urgent: true, failed });
    expect(all).toMatchObject({ text: 'M2 · stop.lockout: stop.unconfirmed', more: 'stop.silent' });
  });

  test('keeps the texts of the hub for what is not urgent, and for what the page itself has lost', () => {
    expect(noteOf({ monitor: 'M2', what: 'Open Valve1', error: unknown })?.text).toContain(protocol);
    const cut = new HubError(OUTCOME_UNKNOWN);
    expect(noteOf({ monitor: 'M2', what: 'Stop All', urgent: true, error: cut })?.text).toContain(OUTCOME_UNKNOWN.en);
  });
});

test('a STOP to a monitor that the hub no longer knows goes to all of them, and says so', async () => {
  const told: Outcome[] = [];
  const end = commands.onOutcome((outcome) => told.push(outcome));
  const gone = new HubError({ code: 'no_monitor', en: '', ru: '' });
  const ask = vi
    .spyOn(socket, 'ask')
    .mockRejectedValueOnce(gone)
    .mockResolvedValue({ results: { M2: done } });
  expect(await commands.stop('M1')).toEqual({ M2: done });
  end();
  expect(ask.mock.calls.map(([message]) => message)).toEqual([
    { type: 'stop', monitor: 'M1', of: undefined },
    { type: 'stop' },
  ]);
  expect(told.some(({ gone }) => gone)).toBe(true);
});

test('every order to stop or close is one event, before it is sent', () => {
  vi.spyOn(socket, 'ask').mockImplementation(() => new Promise(() => {}));
  const heard: Halt[] = [];
  const stops: (string | null)[] = [];
  const ends = [onHalt((one) => heard.push(one)), commands.onStop((monitor) => stops.push(monitor))];
  void commands.stop('M1');
  void commands.stop();
  void commands.close('M2', 'Valve1');
  void commands.lockout('M3');
  for (const end of ends) end();
  expect(heard).toEqual([
    { kind: 'stop', monitor: 'M1', own: true },
    { kind: 'stop', monitor: null, own: true },
    { kind: 'close', monitor: 'M2', own: true },
    { kind: 'lockout', monitor: 'M3', own: true },
  ]);
  expect(stops).toEqual(['M1', null, 'M3']);
});
