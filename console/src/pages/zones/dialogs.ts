// Orders that need a deliberate gesture: release, mode, bypass.
import { html } from 'lit';
import type { DetectorBypass, DetectorState, ZoneMode, ZoneState } from '../../hub/api';
import { whyNotOrder, zones } from '../../hub/zones';
import { age, t } from '../../i18n';
import { confirmDialog, dialog } from '../../shell/dialog';
import { unableWords } from '../../shell/zone-words';
import { bypassDetector, releaseZone, runPump, setMode } from '../../shell/zones';

/** Times of a mode that is not automatic, s; null: as configured. */
const FOR_S: Record<'mode' | 'test', readonly (number | null)[]> = {
  mode: [null, 900, 3600, 8 * 3600, 24 * 3600],
  test: [null, 300, 1800, 3600],
};
const MODES: readonly ZoneMode[] = ['automatic', 'manual', 'off', 'test_dry'];
/** Time that a test lasts unless another is chosen, s. */
const TEST_S = 900;
const BYPASSES: readonly DetectorBypass[] = ['none', 'masked', 'disabled'];
const HOLD_S = 2;

/** Water by hand: held for two seconds, with the monitors named. */
export async function askRelease(zone: string): Promise<void> {
  const monitors = zones.configured(zone)?.monitors.join(', ') ?? '';
  const mode = zones.zone(zone)?.mode;
  const tests = mode === 'test_dry' || mode === 'test_outlet';
  const sure = await confirmDialog({
    title: t('zones.release_title', { zone }),
    text: t(tests ? 'zones.release_test_text' : 'zones.release_text', { monitors }),
    yes: t('zones.release'),
    danger: true,
    hold: HOLD_S,
    why: () => whyNotOrder(),
  });
  if (sure) await releaseZone(zone);
}

export async function askMode(zone: ZoneState): Promise<void> {
  let mode: ZoneMode = zone.mode;
  let for_s: number | null = null;
  const isTest = () => mode === 'test_dry';
  const chosen = await dialog.open<boolean>({
    title: t('zones.mode_title', { zone: zone.zone }),
    content: () => html`<label class="field"
        >${t('zones.mode')}
        <select
          id="mode-wanted"
          @change=${(event: Event) => {
            mode = (event.target as HTMLSelectElement).value as ZoneMode;
            for_s = null;
            dialog.update();
          }}
        >
          ${MODES.map((one) => html`<option value=${one} ?selected=${one === mode}>${t(`zones.mode_${one}`)}</option>`)}
        </select>
      </label>
      ${
        mode === 'automatic'
          ? ''
          : html`<label class="field"
            >${t('zones.mode_for')}
            <select
              id="mode-for"
              @change=${(event: Event) => {
                const { value } = event.target as HTMLSelectElement;
                for_s = value ? Number(value) : null;
              }}
            >
              ${FOR_S[isTest() ? 'test' : 'mode'].map(
                (time) =>
                  html`<option value=${time ?? ''} ?selected=${time === for_s}>${forWords(zone.zone, time, isTest())}</option>`,
              )}
            </select>
          </label>`
      }
      <p>${t(`zones.mode_text_${mode}` as 'zones.mode_text_off')}</p>`,
    actions: (close) => html`<lf-button @click=${() => close(false)}>${t('shell.cancel')}</lf-button>
      ${
        mode === 'automatic'
          ? html`<lf-hold kind="danger" .seconds=${HOLD_S} .why=${whyNotOrder('engineer')} @held=${() => close(true)}>${t('zones.mode_set')}</lf-hold>`
          : html`<lf-button kind="primary" .why=${whyNotOrder('engineer')} @click=${() => close(true)}>${t('zones.mode_set')}</lf-button>`
      }`,
  });
  if (chosen) await setMode(zone.zone, mode, mode === 'automatic' ? undefined : (for_s ?? undefined));
}

/** When it returns to automatic, if nothing else is chosen: as the hub's configuration says. */
function forWords(zone: string, time: number | null, test: boolean): string {
  if (time !== null) return age(time * 1000);
  if (test) return t('zones.mode_as_configured', { age: age(TEST_S * 1000) });
  const returns = zones.configured(zone)?.return_after_s;
  return returns == null ? t('zones.mode_stays') : t('zones.mode_as_configured', { age: age(returns * 1000) });
}

/** A pump by hand: held, for a stop leaves a fire without water. */
export async function askPump(pump: string, on: boolean): Promise<void> {
  const which = on ? 'on' : 'off';
  const sure = await confirmDialog({
    title: t(`zones.pump_title_${which}`, { pump }),
    text: t(`zones.pump_text_${which}`),
    yes: t(on ? 'zones.pump_start' : 'zones.pump_stop'),
    danger: !on,
    hold: HOLD_S,
  });
  if (sure) await runPump(pump, on);
}

/** Masked or disabled at once; a vote that counts again needs the held button. */
export async function askBypass({ detector, unable }: DetectorState): Promise<void> {
  const now: DetectorBypass =
    unable != null && typeof unable !== 'string' && 'bypass' in unable ? unable.bypass : 'none';
  const wanted = await dialog.open<DetectorBypass>({
    title: t('zones.bypass_title', { detector }),
    content: () => html`<p>${unableWords(unable) || t('zones.can_vote')}</p>
      ${BYPASSES.map((one) => html`<p>${t(`zones.bypass_text_${one}`)}</p>`)}`,
    actions: (close) => html`<lf-button @click=${() => close()}>${t('shell.cancel')}</lf-button>
      ${BYPASSES.filter((one) => one !== now).map((one) =>
        one === 'none'
          ? html`<lf-hold id="bypass-none" .seconds=${HOLD_S} .why=${whyNotOrder('engineer')} @held=${() => close(one)}>${t('zones.bypass_none')}</lf-hold>`
          : html`<lf-button id="bypass-${one}" .why=${whyNotOrder('engineer')} @click=${() => close(one)}>${t(`zones.bypass_${one}`)}</lf-button>`,
      )}`,
  });
  if (wanted) await bypassDetector(detector, wanted);
}
