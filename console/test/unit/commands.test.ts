import { expect, test } from 'vitest';
import { outcomeOf } from '../../src/hub/commands';
import { noteOf } from '../../src/shell/toasts';
import type { Result } from '../../src/hub/types';

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
