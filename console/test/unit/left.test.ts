import { afterEach, expect, test, vi } from 'vitest';
import { HubError } from '../../src/hub/errors';
import { http } from '../../src/hub/http';
import { CONNECTED, type Left, leftInWords, leftOf, UNKNOWN, whatIsLeft } from '../../src/hub/left';
import { socket } from '../../src/hub/socket';
import en from '../../src/i18n/en/login';
import ru from '../../src/i18n/ru/login';

const refused = (details: object) =>
  leftOf(new HubError({ code: 'login_needed', en: 'Log in first.', ru: 'Сначала войдите.', ...details } as never));

/** No language is loaded here: the key is used as the text. */
const said = (left: Left) => {
  const key = leftInWords(left) as keyof typeof en;
  return { en: en[key], ru: ru[key] };
};

afterEach(() => void vi.restoreAllMocks());

test('the page offers what the hub accepts, and no more', () => {
  const expired = refused({ standing: 'expired', left_ms: 23.5 * 3_600_000 });
  expect(expired).toMatchObject({ stop: true, lockout: true });
  expect(said(expired).en).toContain('STOP and LOCKOUT still work here for {n} h');
  expect(said(expired).ru).toContain('СТОП и БЛОКИРОВКА здесь работают ещё {n} ч');
  const ended = refused({ standing: 'ended', left_ms: 599_000 });
  expect(ended).toEqual({ stop: true, lockout: false, minutes: 10 });
  expect(said(ended).en).toContain('Only STOP still works here');
  for (const nothing of [refused({}), refused({ standing: 'ended', left_ms: 0 })]) {
    expect(nothing).toMatchObject({ stop: false, lockout: false });
    expect(said(nothing).en).toContain('STOP does NOT work here');
    expect(said(nothing).ru).toContain('СТОП здесь больше НЕ работает');
  }
  expect(leftOf(new HubError({ code: 'not_linked', en: '', ru: '' } as never))).toBe(UNKNOWN);
  expect(said(UNKNOWN).en).not.toContain('STOP');
});

test('a connection that is heard takes STOP and LOCKOUT, whatever becomes of the session', async () => {
  const nothing = new HubError({ code: 'login_needed', en: '', ru: '' });
  vi.spyOn(http, 'get').mockRejectedValue(nothing);
  const heard = vi.spyOn(socket, 'alive', 'get').mockReturnValue(true);
  expect(await whatIsLeft()).toBe(CONNECTED);
  expect(said(CONNECTED).en).toContain('STOP and LOCKOUT still work here as long as there is a connection');
  expect(said(CONNECTED).ru).toContain('СТОП и БЛОКИРОВКА здесь работают, пока есть связь');
  heard.mockReturnValue(false);
  expect(await whatIsLeft()).toEqual(leftOf(nothing));
});
