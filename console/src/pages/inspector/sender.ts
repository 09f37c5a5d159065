// Sends a request as text, completed from the dictionary while it is typed.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { commands } from '../../hub/commands';
import { dictionaryNow } from '../../hub/dictionary';
import { HubError } from '../../hub/errors';
import { whyNot } from '../../hub/session';
import { store, TopicController } from '../../hub/store';
import type { Answer, Result } from '../../hub/types';
import { type Key, lang, t, tt } from '../../i18n';
import '../../parts/lf-button';
import '../../parts/lf-chip';
import { confirmDialog } from '../../shell/dialog';
import { base, fields } from '../../theme/shared';
import { show } from '../../units';
import { type Completed, complete, needsOf } from './complete';

const KEPT = 50;

interface Outcome {
  ok: boolean;
  head: string;
  text: string;
  answers: Answer[];
  /** Position of the error in the text. */
  column: number | null;
}

@customElement('lf-request-sender')
export class LfRequestSender extends LitElement {
  static override styles = [
    base,
    fields,
    css`
      :host {
        display: grid;
        gap: var(--s2);
      }
      .line {
        display: grid;
        grid-template-columns: minmax(0, 1fr) auto;
        gap: var(--s2);
        align-items: end;
      }
      .box {
        position: relative;
      }
      input.text:not([type='checkbox']) {
        font-family: var(--mono);
        font-size: var(--t-field);
      }
      [role='listbox'] {
        position: absolute;
        left: 0;
        top: calc(100% + 4px);
        width: min(560px, 100%);
        max-height: 336px;
        overflow: auto;
        margin: 0;
        padding: var(--s1);
        list-style: none;
        background: var(--surface);
        border: 1px solid var(--line-strong);
        border-radius: var(--radius);
        box-shadow: var(--shadow-large);
        z-index: 5;
        font-size: var(--t-normal);
        font-weight: 400;
        color: var(--text);
      }
      [role='option'] {
        display: grid;
        grid-template-columns: minmax(128px, max-content) minmax(0, 1fr);
        gap: var(--s3);
        align-items: center;
        min-height: 48px;
        padding: var(--s1) var(--s25);
        border-radius: var(--radius-small);
        cursor: pointer;
      }
      [role='option'][aria-selected='true'],
      [role='option']:hover {
        background: var(--accent-soft);
      }
      [role='option'] b {
        font-family: var(--mono);
        font-weight: 600;
      }
      [role='option'] span {
        color: var(--dim);
        font-size: var(--t-note);
        line-height: 1.35;
        display: -webkit-box;
        -webkit-line-clamp: 2;
        -webkit-box-orient: vertical;
        overflow: hidden;
      }
      .needs {
        min-height: 20px;
        font-size: var(--t-note);
        color: var(--dim);
      }
      .outcome {
        border: 1px solid var(--line);
        border-left: 4px solid var(--line-strong);
        border-radius: var(--radius);
        background: var(--surface);
        padding: var(--s2) var(--s3);
        max-height: 240px;
        overflow: auto;
      }
      .outcome.bad {
        border-left-color: var(--medium);
      }
      .outcome header {
        display: flex;
        align-items: center;
        gap: var(--s2);
        font-weight: 650;
      }
      .outcome ul {
        margin: var(--s15) 0 0;
        padding: 0;
        list-style: none;
        display: grid;
        gap: var(--s15);
      }
      .at {
        font-family: var(--mono);
        font-size: var(--t-normal);
        white-space: pre;
        overflow-x: auto;
        margin-top: var(--s1);
      }
      .at u {
        text-decoration: underline wavy var(--medium);
        text-underline-offset: 4px;
      }
      .answer {
        font-family: var(--mono);
        font-size: var(--t-note);
      }
    `,
  ];

  @property() monitor = '';
  @state() private text = '';
  @state() private offered: Completed | null = null;
  @state() private active = -1;
  @state() private busy = false;
  @state() private outcome: Outcome | null = null;
  private sent: string[] = [];
  private back = 0;

  constructor() {
    super();
    new TopicController(this, () => [
      `monitors/${this.monitor}/authority`,
      `monitors/${this.monitor}/link`,
      `monitors/${this.monitor}/status`,
    ]);
  }

  /** Puts a text into the field. */
  put(text: string): void {
    this.text = text;
    this.field.value = text;
    this.field.focus();
  }

  override render() {
    const offers = this.offered?.offers ?? [];
    const open = offers.length > 0;
    return html`<div class="line">
        <label class="field"
          >${t('inspector.send_label', { monitor: this.monitor })}
          <span class="box">
            <input
              class="text"
              name="request"
              role="combobox"
              autocomplete="off"
              autocapitalize="off"
              spellcheck="false"
              placeholder=${t('inspector.send_hint')}
              aria-expanded=${open ? 'true' : 'false'}
              aria-controls="offers"
              aria-autocomplete="list"
              aria-activedescendant=${this.active >= 0 ? `o${this.active}` : nothing}
              .value=${this.text}
              @input=${this.typed}
              @keydown=${this.keyed}
              @focus=${this.typed}
              @blur=${() => window.setTimeout(() => this.close(), 150)}
            />
            <ul id="offers" role="listbox" aria-label=${t('inspector.offers')} ?hidden=${!open}>
              ${offers.map(
                (offer, index) => html`<li
                  id="o${index}"
                  role="option"
                  aria-selected=${index === this.active ? 'true' : 'false'}
                  @pointerdown=${(event: Event) => event.preventDefault()}
                  @click=${() => this.take(index)}
                >
                  <b>${offer.insert}</b><span>${tt(offer.text)}</span>
                </li>`,
              )}
            </ul>
          </span>
        </label>
        <lf-button kind="primary" id="send" .why=${this.why()} @click=${() => this.send()}
          >${t('inspector.send')}</lf-button
        >
      </div>
      <div class="needs">${this.needs()}</div>
      ${this.outcome ? this.renderOutcome(this.outcome) : nothing}`;
  }

  private renderOutcome(outcome: Outcome) {
    const { column } = outcome;
    return html`<div class="outcome ${outcome.ok ? '' : 'bad'}" role="status">
      <header>
        <lf-chip kind=${outcome.ok ? 'normal' : 'medium'} icon=${outcome.ok ? 'check' : 'warning'}>${outcome.head}</lf-chip>
        <span class="grow"></span>
        <lf-button kind="quiet" icon="close" .label=${t('shell.close')} @click=${() => (this.outcome = null)}></lf-button>
      </header>
      ${outcome.text ? html`<div>${outcome.text}</div>` : nothing}
      ${
        column === null
          ? nothing
          : html`<div class="at">${this.text.slice(0, column)}<u>${this.text.slice(column) || ' … '}</u></div>`
      }
      ${
        outcome.answers.length > 0
          ? html`<ul>
            ${outcome.answers.map(
              (answer) => html`<li>
                <div class="answer">${answer.text}</div>
                ${answer.success ? nothing : html`<div>${tt(answer.meaning)} <b>${tt(answer.remedy)}</b></div>`}
              </li>`,
            )}
          </ul>`
          : nothing
      }
    </div>`;
  }

  private why(): string {
    const dict = dictionaryNow();
    if (this.busy) return t('inspector.send_sending');
    if (!this.text.trim()) return t('inspector.send_empty');
    if (!dict) return t('shell.loading');
    return whyNot(this.monitor, needsOf(this.text, dict));
  }

  private needs(): string {
    const dict = dictionaryNow();
    if (!dict || !this.text.trim()) return '';
    const { role, authority, confirm } = needsOf(this.text, dict);
    const what = [
      role === 'observer' ? '' : t('inspector.needs_role', { role: t(`role.${role}` as Key) }),
      authority ? t('inspector.needs_authority') : '',
      confirm ? t('inspector.needs_confirm') : '',
    ].filter(Boolean);
    return what.length ? t('inspector.needs', { what: what.join(', ') }) : t('inspector.needs_nothing');
  }

  private get field(): HTMLInputElement {
    return this.renderRoot.querySelector('input')!;
  }

  private readonly typed = (): void => {
    const { field } = this;
    this.text = field.value;
    this.offer(field.selectionStart ?? field.value.length);
  };

  private offer(caret: number): void {
    const dict = dictionaryNow();
    const status = store.get(`monitors/${this.monitor}/status`);
    const has = (name: string) => !status?.at_ms || name in status.subsystems;
    this.offered = dict ? complete(this.text, caret, dict, has) : null;
    this.active = -1;
  }

  private take(index: number): void {
    const offer = this.offered?.offers[index];
    if (!offer || !this.offered) return;
    const { field } = this;
    const caret = field.selectionStart ?? field.value.length;
    const before = this.text.slice(0, this.offered.from) + offer.insert + (offer.more ? ' ' : '');
    this.text = before + this.text.slice(caret).replace(/^\S*\s?/, '');
    field.value = this.text;
    field.setSelectionRange(before.length, before.length);
    field.focus();
    if (offer.more) this.offer(before.length);
    else this.close();
  }

  private close(): void {
    this.offered = null;
    this.active = -1;
  }

  private readonly keyed = (event: KeyboardEvent): void => {
    const count = this.offered?.offers.length ?? 0;
    const taken = this.handle(event, count);
    if (!taken) return;
    event.preventDefault();
    event.stopPropagation();
    void this.updateComplete.then(() =>
      this.renderRoot.querySelector('[role="option"][aria-selected="true"]')?.scrollIntoView({ block: 'nearest' }),
    );
  };

  /** Whether the key was for the list or the line. */
  private handle(event: KeyboardEvent, count: number): boolean {
    switch (event.key) {
      case 'ArrowDown':
      case 'ArrowUp': {
        const step = event.key === 'ArrowDown' ? 1 : -1;
        if (count > 0 && (this.text || this.active >= 0 || step > 0)) {
          this.active = (this.active + step + count + (this.active < 0 && step < 0 ? 1 : 0)) % count;
        } else this.recall(-step);
        return true;
      }
      case 'Tab':
        if (event.shiftKey || count === 0 || !this.text.trim()) return false;
        this.take(Math.max(0, this.active));
        return true;
      case 'Enter':
        if (this.active >= 0) this.take(this.active);
        else if (!this.why()) void this.send();
        return true;
      case 'Escape':
        if (event.shiftKey || count === 0) return false;
        this.close();
        return true;
      default:
        return false;
    }
  }

  private recall(step: number): void {
    this.back = Math.max(0, Math.min(this.sent.length, this.back + step));
    const text = this.back === 0 ? '' : this.sent[this.sent.length - this.back]!;
    this.text = this.field.value = text;
  }

  private async send(): Promise<void> {
    const dict = dictionaryNow();
    const text = this.text.trim();
    if (!dict || !text) return;
    const { monitor } = this;
    this.close();
    if (needsOf(text, dict).confirm) {
      const sure = await confirmDialog({
        title: t('inspector.confirm_title', { request: text, monitor }),
        text: t('inspector.confirm_text'),
        yes: t('inspector.send'),
        danger: true,
        typed: monitor,
      });
      if (!sure) return;
    }
    this.sent = [...this.sent.filter((known) => known !== text), text].slice(-KEPT);
    this.back = 0;
    this.busy = true;
    try {
      const confirm = needsOf(text, dict).confirm ? monitor : undefined;
      this.outcome = wentWell(await commands.request(monitor, text, { quiet: true, confirm }));
    } catch (cause) {
      this.outcome = failed(HubError.of(cause));
    }
    this.busy = false;
  }
}

function wentWell(result: Result): Outcome {
  const head = t('inspector.answered', { took: show('duration_ms', result.took_ms) });
  const ok = result.answers.every((answer) => answer.success);
  return { ok, head: `${result.request} · ${head}`, text: '', answers: result.answers, column: null };
}

function failed(error: HubError): Outcome {
  const { answers, column } = error.details;
  return {
    ok: false,
    head: error.code,
    text: Array.isArray(answers) ? '' : error.text(lang()),
    answers: Array.isArray(answers) ? (answers as Answer[]) : [],
    column: typeof column === 'number' ? column : null,
  };
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-request-sender': LfRequestSender;
  }
}
