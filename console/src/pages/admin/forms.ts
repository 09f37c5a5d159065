// Forms to create or change a user or a token.
import { html, nothing } from 'lit';
import { HubError } from '../../hub/errors';
import type { Role } from '../../hub/types';
import { lang, t } from '../../i18n';
import { dialog } from '../../shell/dialog';
import { toast } from '../../shell/toasts';
import { badName, badPassword, ROLES, suggestPassword } from './model';

interface Wanted {
  name: string;
  role: Role;
  password: string;
}

interface Form {
  title: string;
  text: string;
  yes: string;
  /** Null: the name is not asked for. */
  name: { label: string; taken: string[] } | null;
  role: Role | null;
  password: boolean;
  /** The action; an error that it throws is shown, and the form stays. */
  send: (wanted: Wanted) => Promise<void>;
}

/** True: it was done. */
export async function askForm(form: Form): Promise<boolean> {
  const value: Wanted = { name: '', role: form.role ?? 'operator', password: '' };
  let error = '';
  let busy = false;
  const set = (change: Partial<Wanted>) => {
    Object.assign(value, change);
    error = '';
    dialog.update();
  };
  const why = () => {
    if (busy) return t('shell.loading');
    const name = form.name ? badName(value.name, form.name.taken) : null;
    if (name) return t(`admin.bad_${name}`);
    const password = form.password ? badPassword(value.password) : null;
    return password ? t(`admin.bad_${password}`) : '';
  };
  const send = (close: (value?: boolean) => void) => async () => {
    busy = true;
    dialog.update();
    try {
      await form.send(value);
      close(true);
    } catch (cause) {
      error = HubError.of(cause).text(lang());
    }
    busy = false;
    dialog.update();
  };
  const done = await dialog.open<boolean>({
    title: form.title,
    content: () => html`<p>${form.text}</p>
      ${
        form.name
          ? html`<label class="field"
            >${form.name.label}
            <input
              name="name"
              autocomplete="off"
              autocapitalize="off"
              spellcheck="false"
              maxlength="64"
              .value=${value.name}
              @input=${(e: Event) => set({ name: (e.target as HTMLInputElement).value })}
            />
          </label>`
          : nothing
      }
      ${form.role ? roleField(value.role, (role) => set({ role })) : nothing}
      ${form.password ? passwordField(value.password, (password) => set({ password })) : nothing}
      <p class="error" role="alert">${error}</p>`,
    actions: (close) => html`<lf-button @click=${() => close()}>${t('shell.cancel')}</lf-button>
      <lf-button kind="primary" data-yes .why=${why()} @click=${send(close)}>${form.yes}</lf-button>`,
  });
  return done === true;
}

function roleField(role: Role, set: (role: Role) => void) {
  return html`<label class="field"
      >${t('admin.role')}
      <select name="role" @change=${(e: Event) => set((e.target as HTMLSelectElement).value as Role)}>
        ${ROLES.map((one) => html`<option value=${one} ?selected=${one === role}>${t(`role.${one}`)}</option>`)}
      </select>
    </label>
    <p class="dim small">${t(`admin.about_${role}`)}</p>`;
}

function passwordField(password: string, set: (password: string) => void) {
  const suggest = () => set(suggestPassword((count) => crypto.getRandomValues(new Uint8Array(count))));
  return html`<label class="field"
      >${t('admin.password')}
      <input
        name="password"
        autocomplete="new-password"
        spellcheck="false"
        autocapitalize="off"
        class="mono"
        .value=${password}
        @input=${(e: Event) => set((e.target as HTMLInputElement).value)}
      />
    </label>
    <div class="row wrap">
      <lf-button icon="refresh" @click=${suggest}>${t('admin.suggest')}</lf-button>
      <lf-button .why=${password ? '' : t('admin.bad_short')} @click=${() => copy(password)}>${t('admin.copy')}</lf-button>
    </div>`;
}

export async function copy(text: string): Promise<void> {
  try {
    await navigator.clipboard.writeText(text);
    toast({ kind: 'ok', text: t('admin.copied') });
  } catch {
    toast({ kind: 'warning', text: t('admin.copy_failed') });
  }
}

/** A token is shown only once. */
export function showToken(name: string, token: string): Promise<unknown> {
  return dialog.open<void>({
    title: t('admin.token_title', { name }),
    content: () => html`<p>${t('admin.token_once')}</p>
      <label class="field"
        >${t('admin.token')}
        <textarea readonly rows="3" class="mono" name="token" @focus=${(e: Event) => (e.target as HTMLTextAreaElement).select()} .value=${token}></textarea>
      </label>
      <p class="dim small mono">curl -H "Authorization: Bearer …" ${location.origin}/api/monitors</p>`,
    actions: (close) => html`<lf-button icon="check" @click=${() => copy(token)}>${t('admin.copy')}</lf-button>
      <lf-button kind="primary" data-yes @click=${() => close()}>${t('admin.token_kept')}</lf-button>`,
  });
}
