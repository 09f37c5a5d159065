// Dialogs. They are not `showModal`, which would put everything else, STOP among it, out of reach:
// the page behind is inert, STOP is not.
import { css, html, LitElement, nothing, type TemplateResult } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { jog } from '../hub/jog';
import { t } from '../i18n';
import '../parts/lf-button';
import '../parts/lf-hold';
import { Moved } from '../parts/moved';
import { base, fields, table } from '../theme/shared';

export interface DialogOptions<T> {
  title: string;
  /** Its content; `close(value)` ends it. */
  content: (close: (value?: T) => void) => TemplateResult;
  /** Buttons at its foot; a single Close without. */
  actions?: (close: (value?: T) => void) => TemplateResult;
  wide?: boolean;
}

interface Open {
  id: string;
  options: DialogOptions<unknown>;
  resolve: (value: unknown) => void;
  before: HTMLElement | null;
}

class Dialogs extends EventTarget {
  stack: Open[] = [];
  private opened = 0;

  /** Opens a dialog; resolves to the value it was closed with, undefined if it was dismissed. */
  open<T>(options: DialogOptions<T>): Promise<T | undefined> {
    jog.endAll();
    return new Promise((resolve) => {
      this.stack.push({
        id: `dialog ${++this.opened}`,
        options: options as DialogOptions<unknown>,
        resolve: resolve as (value: unknown) => void,
        before: activeElement(),
      });
      this.changed();
    });
  }

  /** Closes one, wherever it is: the top one without. One that is closed already stays so. */
  close(value?: unknown, one = this.stack.at(-1)): void {
    const at = one ? this.stack.indexOf(one) : -1;
    if (!one || at < 0) return;
    this.stack.splice(at, 1);
    one.resolve(value);
    this.changed();
    queueMicrotask(() => one.before?.focus());
  }

  closeAll(): void {
    while (this.stack.length > 0) this.close();
  }

  /** Renders the open dialog again. */
  update(): void {
    this.changed();
  }

  private changed(): void {
    this.dispatchEvent(new Event('change'));
  }
}

export const dialog = new Dialogs();

export interface ConfirmOptions {
  title: string;
  /** As a function: called again when something changes. */
  text: string | TemplateResult | (() => string | TemplateResult);
  yes: string;
  danger?: boolean;
  /** Time that the button must be held, s. */
  hold?: number;
  /** Why it cannot be done now; called again when something changes. */
  why?: () => string;
  /** Text that must be typed first, e.g. the monitor's id. */
  typed?: string;
}

/** Asks for a confirmation. */
export async function confirmDialog(options: ConfirmOptions): Promise<boolean> {
  let typed = '';
  const missing = () =>
    options.why?.() || (options.typed && typed !== options.typed ? t('shell.type_first', { what: options.typed }) : '');
  const typing = (event: Event) => {
    typed = (event.target as HTMLInputElement).value.trim();
    dialog.update();
  };
  const kind = options.danger ? 'danger' : 'primary';
  const answer = await dialog.open<boolean>({
    title: options.title,
    content: () => html`<p>${typeof options.text === 'function' ? options.text() : options.text}</p>
      ${
        options.typed
          ? html`<label class="field"
            >${t('shell.type', { what: options.typed })}
            <input autocomplete="off" autocapitalize="off" spellcheck="false" @input=${typing} />
          </label>`
          : nothing
      }`,
    actions: (close) => html`<lf-button @click=${() => close(false)}>${t('shell.cancel')}</lf-button>
      ${
        options.hold
          ? html`<lf-hold kind=${kind} .seconds=${options.hold} .why=${missing()} @held=${() => close(true)}
            >${options.yes}</lf-hold
          >`
          : html`<lf-button kind=${kind} .why=${missing()} @click=${() => close(true)}
            >${options.yes}</lf-button
          >`
      }`,
  });
  return answer === true;
}

@customElement('lf-dialogs')
export class LfDialogs extends LitElement {
  static override styles = [
    base,
    fields,
    table,
    css`
      .veil {
        position: fixed;
        inset: calc(var(--topbar) + var(--zones-height, 0px)) 0 0 0;
        display: grid;
        place-items: center;
        padding: var(--s3);
        background: var(--scrim);
        z-index: 50;
        overflow: auto;
      }
      .grid {
        display: grid;
        grid-template-columns: repeat(auto-fit, minmax(min(100%, 170px), 1fr));
        gap: var(--s2) var(--s3);
      }
      .touch {
        min-height: 48px;
      }
      .top {
        align-items: flex-start;
        gap: var(--s25);
      }
      .keys {
        min-width: 9ch;
      }
      .paper {
        width: 100%;
        height: auto;
        background: var(--white);
        border-radius: var(--radius);
      }
      .dialog {
        width: min(520px, 100%);
        max-height: 100%;
        display: flex;
        flex-direction: column;
        background: var(--surface);
        border: 1px solid var(--line);
        border-radius: var(--radius-large);
        box-shadow: var(--shadow-large);
      }
      :host([moved]) .dialog {
        pointer-events: none;
      }
      .dialog:focus {
        outline: none;
      }
      .wide {
        width: min(920px, 100%);
      }
      .dialog > header {
        display: flex;
        align-items: center;
        gap: var(--s2);
        padding: var(--s2) var(--s2) var(--s2) var(--s4);
        border-bottom: 1px solid var(--line);
      }
      .dialog > header h1 {
        flex: 1;
        font-size: var(--t-large);
      }
      .body {
        padding: var(--s4);
        overflow: auto;
        display: flex;
        flex-direction: column;
        gap: var(--s3);
        line-height: 1.5;
      }
      footer {
        display: flex;
        flex-wrap: wrap;
        justify-content: flex-end;
        gap: var(--s2);
        padding: var(--s3) var(--s4);
        border-top: 1px solid var(--line);
      }
      @media (max-width: 720px) {
        .veil {
          inset: calc(56px + var(--zones-height, 0px)) 0 72px 0;
        }
      }
    `,
  ];

  @state() private count = 0;

  constructor() {
    super();
    new Moved(this, '.veil', () => dialog.stack.slice(-1).map(({ id }) => id), true);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    dialog.addEventListener('change', this.changed);
    window.addEventListener('keydown', this.keyed);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    dialog.removeEventListener('change', this.changed);
    window.removeEventListener('keydown', this.keyed);
  }

  override render() {
    const top = dialog.stack.at(-1);
    if (!top) return nothing;
    const close = (value?: unknown) => dialog.close(value, top);
    const { title, content, actions, wide } = top.options;
    return html`<div class="veil">
      <div
        class="dialog ${wide ? 'wide' : ''}"
        role="dialog"
        aria-modal="true"
        aria-labelledby="title"
        tabindex="-1"
      >
        <header>
          <h1 id="title">${title}</h1>
          <lf-button kind="quiet" icon="close" .label=${t('shell.close')} @click=${() => close()}></lf-button>
        </header>
        <div class="body" tabindex="0">${content(close)}</div>
        ${actions ? html`<footer>${actions(close)}</footer>` : nothing}
      </div>
    </div>`;
  }

  private readonly changed = async (): Promise<void> => {
    const opened = dialog.stack.length > this.count;
    this.count = dialog.stack.length;
    this.requestUpdate();
    if (!opened) return;
    await this.updateComplete;
    const field = this.renderRoot.querySelector<HTMLElement>('[autofocus], input, select, textarea');
    (field ?? this.renderRoot.querySelector<HTMLElement>('.dialog'))?.focus();
  };

  private readonly keyed = (event: KeyboardEvent): void => {
    if (event.key !== 'Escape' || event.shiftKey || dialog.stack.length === 0) return;
    event.preventDefault();
    dialog.close();
  };
}

function activeElement(): HTMLElement | null {
  let at = document.activeElement;
  while (at?.shadowRoot?.activeElement) at = at.shadowRoot.activeElement;
  return at instanceof HTMLElement ? at : null;
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-dialogs': LfDialogs;
  }
}
