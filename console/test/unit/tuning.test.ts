// A measurement ends with each way in which the page is left, also before the hub has answered that it begins.
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { HubError, NOT_LINKED } from '../../src/hub/errors';
import { type Answered, type Said, socket } from '../../src/hub/socket';
import { tuning } from '../../src/hub/tuning';

let sent: Said[];
let answer: (error?: HubError) => void;

beforeEach(() => {
  vi.useFakeTimers();
  Object.assign(globalThis, { document: { hidden: false } });
  sent = [];
  vi.spyOn(socket, 'send').mockImplementation((message) => sent.push(message) > 0);
  vi.spyOn(socket, 'ask').mockImplementation(
    () =>
      new Promise((resolve, reject) => {
        answer = (error) => (error ? reject(error) : resolve({} as Answered));
      }),
  );
});
afterEach(() => {
  tuning.end();
  vi.useRealTimers();
  vi.restoreAllMocks();
});

const END = { type: 'tune_beat', monitor: 'M1', end: true };
const BEAT = { type: 'tune_beat', monitor: 'M1' };

test('beats from the answer on, until it is ended', async () => {
  const given = tuning.begin('M1', 'Horizontal');
  expect([tuning.busy, sent]).toEqual([true, []]);
  answer();
  await given;
  await vi.advanceTimersByTimeAsync(1000);
  tuning.end();
  await vi.advanceTimersByTimeAsync(5000);
  expect(sent).toEqual([BEAT, BEAT, BEAT, END]);
  expect(tuning.busy).toBe(false);
});

test('that is ended before the answer ends at the answer, and does not beat', async () => {
  const given = tuning.begin('M1', 'Horizontal');
  tuning.end();
  answer();
  await given;
  await vi.advanceTimersByTimeAsync(5000);
  expect(sent).toEqual([END]);
  expect(tuning.busy).toBe(false);
});

test('that was refused is none, and the next one is not ended by the end before it', async () => {
  const refused = tuning.begin('M1', 'Horizontal').catch((error: HubError) => error.code);
  tuning.end();
  answer(new HubError(NOT_LINKED));
  expect(await refused).toBe('not_linked');
  expect([sent, tuning.busy]).toEqual([[], false]);
  const given = tuning.begin('M1', 'Horizontal');
  answer();
  await given;
  expect(sent).toEqual([BEAT]);
});
