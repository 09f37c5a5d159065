import { afterEach, expect, test, vi } from 'vitest';

vi.stubGlobal('location', { hash: '' });
vi.stubGlobal('window', { addEventListener: () => {} });
const { store } = await import('../../src/hub/store');
const { unacknowledged } = await import('../../src/shell/nav');

afterEach(() => void vi.restoreAllMocks());

const alarm = (priority: string, state: string, active: boolean) => ({ priority, state, active });

test('the number of alarms has the colour of the worst that waits and has not cleared', () => {
  const all = vi.spyOn(store, 'alarms');
  const told = (...alarms: object[]) => {
    all.mockReturnValue(alarms as never);
    return unacknowledged();
  };
  expect(told(alarm('medium', 'unack', true), alarm('low', 'unack', true))).toEqual([2, 'medium']);
  expect(told(alarm('high', 'ack', true), alarm('low', 'unack', true))).toEqual([1, 'low']);
  expect(told(alarm('high', 'rtn_unack', false))).toEqual([1, 'cleared']);
});
