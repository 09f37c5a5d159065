// Taking, asking for, granting and forcing the authority over a monitor.
import { html, nothing } from 'lit';
import { commands } from '../hub/commands';
import { may } from '../hub/session';
import { socket } from '../hub/socket';
import { store } from '../hub/store';
import type { AskedSeen, LostSeen } from '../hub/types';
import { t } from '../i18n';
import { dialog } from './dialog';
import { toast } from './toasts';

const REASON_LEAST = 5;

/** The user who asks this page for a monitor. */
export const asked = new Map<string, AskedSeen>();
export const askedChanged = new EventTarget();

/** Takes a monitor that is free; requests it if another user holds it. */
export async function takeControl(monitor: string): Promise<void> {
  const holder = store.get(`monitors/${monitor}/authority`)?.holder;
  if (!holder || holder.seat === store.hello?.seat) {
    await commands.authority(monitor, 'take').catch(() => {});
    return;
  }
  let reason = '';
  const short = () => (reason.length < REASON_LEAST ? t('authority.reason_short') : '');
  await dialog.open({
    title: t('authority.held_title', { monitor, user: holder.user }),
    content: () => html`<p>${t('authority.held_text', { user: holder.user })}</p>
      ${
        may('engineer')
          ? html`<label class="field"
            >${t('authority.reason')}
            <input
              @input=${(e: Event) => {
                reason = (e.target as HTMLInputElement).value.trim();
                dialog.update();
              }}
            />
          </label>`
          : nothing
      }`,
    actions: (close) => html`${
      may('engineer')
        ? html`<lf-button
            kind="danger"
            .why=${short()}
            @click=${() => {
              close();
              commands.authority(monitor, 'force', reason).catch(() => {});
            }}
            >${t('authority.force')}</lf-button
          >`
        : nothing
    }
      <lf-button
        kind="primary"
        @click=${() => {
          close();
          commands.authority(monitor, 'request').catch(() => {});
        }}
        >${t('authority.request')}</lf-button
      >`,
  });
}

export function releaseControl(monitor: string): void {
  commands.authority(monitor, 'release').catch(() => {});
}

export function answerAsked(monitor: string, action: 'grant' | 'deny'): void {
  asked.delete(monitor);
  askedChanged.dispatchEvent(new Event('change'));
  commands.authority(monitor, action).catch(() => {});
}

export function followAuthority(): void {
  socket.on('asked', (message) => {
    asked.set(message.monitor, message);
    askedChanged.dispatchEvent(new Event('change'));
    window.setTimeout(
      () => {
        if (asked.get(message.monitor) !== message) return;
        asked.delete(message.monitor);
        askedChanged.dispatchEvent(new Event('change'));
      },
      Math.max(0, message.until_ms - store.hubNow()),
    );
  });
  socket.on('authority_lost', (message) => {
    asked.delete(message.monitor);
    askedChanged.dispatchEvent(new Event('change'));
    toast({ kind: 'warning', text: lostText(message), more: message.reason ?? undefined });
  });
  socket.on('authority_denied', ({ monitor }) => toast({ kind: 'warning', text: t('authority.denied', { monitor }) }));
  socket.on('authority_granted', ({ monitor }) => toast({ kind: 'ok', text: t('authority.granted', { monitor }) }));
}

function lostText({ monitor, how, by }: LostSeen): string {
  const user = by?.user ?? '';
  if (how === 'forced') return t('authority.lost_forced', { monitor, user });
  if (how === 'granted') return t('authority.lost_granted', { monitor, user });
  return t('authority.lost_expired', { monitor });
}
