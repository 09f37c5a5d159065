// Language, theme, units; the user; help with the keys.
import { html, nothing } from 'lit';
import { http } from '../hub/http';
import { session } from '../hub/me';
import { socket } from '../hub/socket';
import { store } from '../hub/store';
import { type Key, lang, setLang, t } from '../i18n';
import { applyDisplay, DISPLAYS, display } from '../theme/display';
import { choices, chosenUnit, setUnit } from '../units';
import { dialog } from './dialog';
import { setSound, soundWanted } from './fire';
import { guideWanted } from './guide-key';

export type Theme = 'day' | 'night' | 'auto';
const THEME_KEY = 'lafet.theme';
const dark = () => matchMedia('(prefers-color-scheme: dark)');

export function theme(): Theme {
  return (localStorage.getItem(THEME_KEY) as Theme | null) ?? 'auto';
}

export function applyTheme(wanted: Theme = theme()): void {
  localStorage.setItem(THEME_KEY, wanted);
  const night = wanted === 'night' || (wanted === 'auto' && dark().matches);
  document.documentElement.dataset.theme = night ? 'night' : 'day';
}

export function followTheme(): void {
  applyTheme();
  dark().addEventListener('change', () => applyTheme());
}

export function openSettings(): void {
  const choose = (act: () => unknown) => async () => {
    await act();
    dialog.update();
  };
  const choice = (on: boolean, text: string, act: () => unknown) =>
    html`<lf-button toggle .on=${on} @click=${choose(act)}>${text}</lf-button>`;
  const changed = (act: (value: string) => void) => (event: Event) => {
    act((event.target as HTMLSelectElement).value);
    dialog.update();
  };
  void dialog.open({
    title: t('settings.title'),
    content: () => html`
      <h2>${t('settings.language')}</h2>
      <div class="row wrap">
        ${choice(lang() === 'en', 'English', () => setLang('en'))}
        ${choice(lang() === 'ru', 'Русский', () => setLang('ru'))}
      </div>
      <h2>${t('settings.theme')}</h2>
      <div class="row wrap">
        ${(['day', 'night', 'auto'] as const).map((one) =>
          choice(theme() === one, t(`settings.theme_${one}`), () => applyTheme(one)),
        )}
      </div>
      <h2>${t('settings.display')}</h2>
      <div class="row wrap">
        ${DISPLAYS.map((one) => choice(display() === one, t(`settings.display_${one}`), () => applyDisplay(one)))}
      </div>
      <p class="dim small">${t('settings.display_text')}</p>
      <h2>${t('settings.sound')}</h2>
      <div class="row wrap">
        ${choice(soundWanted(), t('settings.sound_on'), () => setSound(true))}
        ${choice(!soundWanted(), t('settings.sound_off'), () => setSound(false))}
      </div>
      <p class="dim small">${t('settings.sound_text')}</p>
      <h2>${t('settings.units')}</h2>
      <div class="grid">
        ${choices().map(
          ({ quantity, units }) => html`<label class="field"
            >${t(`settings.${quantity}` as Key)}
            <select @change=${changed((id) => setUnit(quantity, id))}>
              ${units.map(
                (unit) => html`<option value=${unit.id} ?selected=${unit.id === chosenUnit(quantity)}>
                  ${unit.text}
                </option>`,
              )}
            </select>
          </label>`,
        )}
      </div>
      <h2>${t('settings.person')}</h2>
      <div class="row wrap">
        <span class="grow"
          ><b>${store.hello?.user ?? ''}</b> · ${t(`role.${store.hello?.role ?? 'observer'}`)}</span
        >
        ${
          session()?.kind === 'session'
            ? html`<lf-button icon="edit" @click=${openPassword}>${t('settings.password')}</lf-button>
              <lf-button icon="logout" @click=${logout}>${t('settings.logout')}</lf-button>`
            : nothing
        }
        <lf-button icon="help" @click=${openHelp}>${t('topbar.help')}</lf-button>
      </div>
      <p class="dim small">lafet ${store.hello?.hub.version ?? ''}</p>
    `,
  });
}

function openPassword(): void {
  const value = { old: '', new: '' };
  let error = '';
  const typed = (key: 'old' | 'new') => (event: Event) => {
    value[key] = (event.target as HTMLInputElement).value;
  };
  const save = (close: () => void) => async () => {
    try {
      await http.post('/api/password', value);
      close();
    } catch (cause) {
      error = (cause as { text?: (l: 'en' | 'ru') => string }).text?.(lang()) ?? String(cause);
      dialog.update();
    }
  };
  void dialog.open({
    title: t('settings.password'),
    content: () => html`<label class="field"
        >${t('settings.password_old')}<input type="password" autocomplete="current-password" @input=${typed('old')}
      /></label>
      <label class="field"
        >${t('settings.password_new')}<input type="password" autocomplete="new-password" @input=${typed('new')}
      /></label>
      <p class="error" role="alert">${error}</p>`,
    actions: (close) => html`<lf-button kind="primary" @click=${save(close)}>${t('settings.save')}</lf-button>`,
  });
}

async function logout(): Promise<void> {
  socket.stop();
  await http.post('/api/logout').catch(() => {});
  location.reload();
}

function showGuide(): void {
  dialog.closeAll();
  guideWanted(true);
}

const KEYS: [string, Key][] = [
  ['Pause · F9 · Shift+Esc', 'help.stop'],
  ['← → ↑ ↓', 'help.move'],
  ['+ −', 'help.nozzle'],
  ['Esc', 'help.escape'],
  ['?', 'help.help'],
  ['Tab', 'help.tab'],
];

export function openHelp(): void {
  void dialog.open({
    title: t('help.title'),
    wide: true,
    content: () => html`<p>${t('help.intro')}</p>
      <table>
        <tbody>
          ${KEYS.map(
            ([keys, text]) => html`<tr>
              <td class="mono keys"><b>${keys}</b></td>
              <td>${t(text)}</td>
            </tr>`,
          )}
        </tbody>
      </table>
      ${store.hello?.hub.demo ? html`<div><lf-button icon="training" @click=${showGuide}>${t('help.guide')}</lf-button></div>` : nothing}
      <p>${t('help.gamepad')}</p>
      <p>${t('help.hardware')}</p>`,
  });
}
