import { afterEach, expect, test, vi } from 'vitest';
import { fault } from '../../src/hub/faults';
import { Store } from '../../src/hub/store';
import type { Hello } from '../../src/hub/types';

afterEach(() => void vi.restoreAllMocks());

test('a listener that fails keeps nothing from the others, and the page knows of it', () => {
  vi.spyOn(console, 'error').mockImplementation(() => {});
  const store = new Store();
  const heard: string[] = [];
  store.subscribe('a', () => {
    throw new Error('odd');
  });
  store.subscribe('a', (topic) => heard.push(topic));
  expect(fault()).toBeNull();
  store.apply({ now_ms: 0, set: { a: 1 } });
  expect(heard).toEqual(['a']);
  expect(String(fault())).toContain('odd');
});

test('another version of the hub is noticed, the same one after a reconnection is not', () => {
  const store = new Store();
  const hello = (version: string) => ({ now_ms: 0, hub: { version } }) as unknown as Hello;
  store.setHello(hello('1'));
  store.setHello(hello('1'));
  expect(store.updated).toBe(false);
  store.setHello(hello('2'));
  expect(store.updated).toBe(true);
});
