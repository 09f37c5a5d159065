import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { commands, outcomeOf } from '../../src/hub/commands';
import { HubError, NOT_LINKED } from '../../src/hub/errors';
import { http } from '../../src/hub/http';
import { type Answered, socket } from '../../src/hub/socket';
import type { Result } from '../../src/hub/types';
import { noteOf } from '../../src/shell/toasts';

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
