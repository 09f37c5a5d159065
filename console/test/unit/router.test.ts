import { expect, test, vi } from 'vitest';

vi.stubGlobal('location', { hash: '' });
vi.stubGlobal('window', { addEventListener: () => {} });
const { hrefOf, parseRoute } = await import('../../src/shell/router');

test('an address names a page and a monitor, whatever characters its id has', () => {
  expect(parseRoute(hrefOf('params', 'Вышка 1/2'))).toEqual({ page: 'params', monitor: 'Вышка 1/2' });
  expect(parseRoute('#/alarms?from=1')).toEqual({ page: 'alarms', monitor: null });
  expect(parseRoute('#/nothing')).toEqual({ page: 'overview', monitor: null });
});

test('a malformed escape in an address is a monitor that does not exist', () => {
  expect(parseRoute('#/m/%E0%A4%A/operate')).toEqual({ page: 'operate', monitor: '%E0%A4%A' });
});
