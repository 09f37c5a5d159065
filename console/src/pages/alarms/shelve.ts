// Asks for how long and why an alarm is shelved.
import { html } from 'lit';
import { store } from '../../hub/store';
import type { Alarm } from '../../hub/types';
import { t, time, tt } from '../../i18n';
import { dialog } from '../../shell/dialog';

const TIMES_MIN = [15, 60, 120, 240, 480] as const;
const REASONS = ['alarms.reason_known', 'alarms.reason_work', 'alarms.reason_sensor'] as const;

export interface Shelving {
  minutes: number;
  reason: string;
}

export function minutesText(minutes: number): string {
  return minutes < 60 ? t('alarms.minutes', { n: minutes }) : t('alarms.hours', { n: minutes / 60 });
}

export function askShelve(alarm: Alarm): Promise<Shelving | undefined> {
  const chosen: Shelving = { minutes: 60, reason: '' };
  const set = (change: Partial<Shelving>) => {
    Object.assign(chosen, change);
    dialog.update();
  };
  return dialog.open<Shelving>({
    title: t('alarms.shelve_title'),
    content: () => html`<p><b>${alarm.monitor} · ${alarm.subsystem}</b><br />${tt(alarm.what)}</p>
      <p class="dim">${t('alarms.shelve_text')}</p>
      <label class="field"
        >${t('alarms.shelve_reason')}
        <input
          name="reason"
          maxlength="200"
          autocomplete="off"
          .value=${chosen.reason}
          @input=${(event: Event) => set({ reason: (event.target as HTMLInputElement).value })}
        />
      </label>
      <div class="row wrap">
        ${REASONS.map((key) => html`<lf-button @click=${() => set({ reason: t(key) })}>${t(key)}</lf-button>`)}
      </div>
      <div class="col" role="group" aria-label=${t('alarms.shelve_for')}>
        <h3>${t('alarms.shelve_for')}</h3>
        <div class="row wrap">
          ${TIMES_MIN.map(
            (minutes) => html`<lf-button
              toggle
              ?on=${chosen.minutes === minutes}
              @click=${() => set({ minutes })}
              >${minutesText(minutes)}</lf-button
            >`,
          )}
        </div>
        <p class="dim">${t('alarms.shelve_until', { time: time(store.now() + chosen.minutes * 60_000) })}</p>
      </div>`,
    actions: (close) => html`<lf-button @click=${() => close()}>${t('shell.cancel')}</lf-button>
      <lf-button
        kind="primary"
        data-yes
        .why=${chosen.reason.trim() ? '' : t('alarms.shelve_why')}
        @click=${() => close({ ...chosen, reason: chosen.reason.trim() })}
        >${t('alarms.shelve_yes')}</lf-button
      >`,
  });
}
