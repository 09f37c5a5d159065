// The page is not loaded again while a STOP is on its way, or while it was not confirmed.
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { commands } from '../../src/hub/commands';
import { HubError, NOT_LINKED } from '../../src/hub/errors';
import { http } from '../../src/hub/http';
import { socket } from '../../src/hub/socket';
import { store } from '../../src/hub/store';
import type { Result } from '../../src/hub/types';
import { mayReload, reloadWhenSettled } from '../../src/shell/reload';
import { notes, toast } from '../../src/shell/toasts';
import { abortZone } from '../../src/shell/zones';

const done: Result = { ok: true, request: 'Stop All', took_ms: 4, audit: 1, answers: [] };
const listeners = Reflect.get(socket, 'listeners') as Map<string, Set<(message: object) => void>>;
const reload = vi.fn();

beforeEach(() => {
  vi.useFakeTimers();
  Object.assign(globalThis, { location: { reload } });
  reload.mockClear();
});
afterEach(() => {
  for (const { id } of [...notes.shown]) notes.drop(id);
  vi.useRealTimers();
  vi.restoreAllMocks();
});

/** The hub answers by HTTP only after `answer`. */
function deaf(): { answer: () => void } {
  let free = () => {};
  vi.spyOn(socket, 'ask').mockRejectedValue(new HubError(NOT_LINKED));
  vi.spyOn(http, 'post').mockImplementation(
    () =>
      new Promise((resolve) => {
        free = () => resolve(done as never);
      }),
  );
  return { answer: () => free() };
}

test.each([
  ['STOP', () => commands.stop('M1')],
  ['Abort', () => abortZone('hall')],
])('not while %s has no answer', async (_, order) => {
  const hub = deaf();
  expect(mayReload()).toBe(true);
  const given = order();
  expect(mayReload()).toBe(false);
  await vi.advanceTimersByTimeAsync(5000);
  hub.answer();
  await given;
  for (const { id } of [...notes.shown]) notes.drop(id);
  expect(mayReload()).toBe(true);
});

test('not while a monitor is silent', () => {
  const progress = (answered: boolean) => {
    for (const hear of listeners.get('progress')!) hear({ monitor: 'M2', answered });
  };
  progress(false);
  expect(mayReload()).toBe(false);
  progress(true);
  expect(mayReload()).toBe(true);
});

test('not while a note waits to be dismissed', () => {
  toast({ kind: 'ok', text: 'passes' });
  expect(mayReload()).toBe(true);
  toast({ kind: 'error', text: 'NOT CONFIRMED', stays: true });
  expect(mayReload()).toBe(false);
  notes.drop(notes.shown.at(-1)!.id);
  expect(mayReload()).toBe(true);
});

test('another user has logged in: after two seconds, and not before STOP is settled', async () => {
  store.setLinked(false);
  const hub = deaf();
  const given = commands.stop('M1');
  for (let n = 0; n < 3; n += 1) reloadWhenSettled(2000);
  await vi.advanceTimersByTimeAsync(10_000);
  expect(reload).not.toHaveBeenCalled();
  hub.answer();
  await given;
  await vi.advanceTimersByTimeAsync(3000);
  expect(reload).toHaveBeenCalledTimes(1);
});
