// What still works after a session has ended: the page offers no more than the hub accepts.
import { t } from '../i18n';
import { HubError } from './errors';
import { http } from './http';
import { socket } from './socket';

export interface Left {
  /** The hub accepts STOP from this page; `null`: unknown. */
  stop: boolean | null;
  /** And LOCKOUT and Close. */
  lockout: boolean;
  /** For this time from now, in minutes; infinite: as long as the connection lasts. */
  minutes: number;
}

/** Until the hub has answered, and while it does not. */
export const UNKNOWN: Left = { stop: null, lockout: true, minutes: 0 };

/** What ends something goes by WebSocket, whatever the hub says of the session by HTTP. */
export const CONNECTED: Left = { stop: true, lockout: true, minutes: Infinity };

export async function whatIsLeft(): Promise<Left> {
  if (socket.alive) return CONNECTED;
  return http.get('/api/session').then(
    () => UNKNOWN,
    (cause) => leftOf(HubError.of(cause)),
  );
}

/** From the refusal of `/api/session`. */
export function leftOf(error: HubError): Left {
  if (error.code !== 'login_needed') return UNKNOWN;
  const minutes = Math.ceil(Number(error.details.left_ms ?? 0) / 60_000);
  const standing = minutes > 0 ? error.details.standing : undefined;
  return { stop: standing === 'expired' || standing === 'ended', lockout: standing === 'expired', minutes };
}

export function leftInWords({ stop, lockout, minutes }: Left): string {
  if (stop === null) return t('login.ended');
  if (!stop) return t('login.ended_nothing');
  if (!lockout) return t('login.ended_stop', { n: minutes });
  if (minutes === Infinity) return t('login.ended_linked');
  return minutes > 90
    ? t('login.ended_all_hours', { n: Math.floor(minutes / 60) })
    : t('login.ended_all', { n: minutes });
}
