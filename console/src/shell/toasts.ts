// Outcomes of commands, and notes of pages: `toast({kind, text})`.
import { css, html, LitElement, nothing } from 'lit';
import { customElement } from 'lit/decorators.js';
import { repeat } from 'lit/directives/repeat.js';
import { commands, type Outcome } from '../hub/commands';
import type { HubError } from '../hub/errors';
import type { Answer } from '../hub/types';
import { type Key, lang, t, tt } from '../i18n';
import { type IconName, icon } from '../parts/icons';
import { base } from '../theme/shared';
import { requestWords } from './request';

export interface Toast {
  kind: 'ok' | 'info' | 'warning' | 'error';
  text: string;
  /** What to do. */
  more?: string;
  /** Until a user dismisses it. */
  stays?: boolean;
  /** Takes the place of the one with the same key. */
  key?: string;
}

interface Shown extends Toast {
  id: number;
  count: number;
}

const MOST = 4;
const STAY_MS = { ok: 4000, info: 6000, warning: 9000, error: 12000 };
const ICONS: Record<Toast['kind'], IconName> = {
  ok: 'check',
  info: 'info',
  warning: 'warning',
  error: 'alarm',
};

/** The notes of the page. They outlive the element that shows them: another language or size makes another one. */
class Notes extends EventTarget {
  shown: readonly Shown[] = [];
  private nextId = 1;

  add(note: Toast): void {
    const former = note.key && this.shown.find(({ key }) => key === note.key);
    const same = this.shown.find((s) => s !== former && s.text === note.text && s.kind === note.kind);
    const id = this.nextId++;
    const others = this.shown.filter((s) => s !== same && s !== former);
    const all = [...others, { ...note, id, count: (same?.count ?? 0) + 1 }];
    const leaving = all.filter(({ stays }) => !stays).slice(0, -MOST);
    this.show(all.filter((one) => !leaving.includes(one)));
    if (!note.stays) setTimeout(() => this.drop(id), STAY_MS[note.kind]);
  }

  /** Some note waits until a user dismisses it. */
  get stay(): boolean {
    return this.shown.some(({ stays }) => stays);
  }

  drop(id: number): void {
    this.show(this.shown.filter((note) => note.id !== id));
  }

  /** What was said with this key is over. */
  settle(key: string): void {
    this.show(this.shown.filter((note) => note.key !== key));
  }

  private show(shown: readonly Shown[]): void {
    this.shown = shown;
    this.dispatchEvent(new Event('change'));
  }
}

export const notes = new Notes();

/** Shows a note. */
export function toast(note: Toast): void {
  notes.add(note);
}

/** Shows what becomes of commands: once, at the start. */
export function followOutcomes(): void {
  commands.onOutcome((outcome) => {
    const note = noteOf(outcome);
    if (note) toast(note);
    else if (outcome.key) notes.settle(outcome.key);
  });
}

/** The text of an outcome; none if the effect is visible anyway. */
export function noteOf(outcome: Outcome): Toast | null {
  const note = bare(outcome);
  const stays = outcome.urgent === true && (note?.kind === 'error' || note?.kind === 'warning');
  return note && { ...note, ...(stays && { stays }), ...(outcome.key && { key: outcome.key }) };
}

function bare(outcome: Outcome): Toast | null {
  const who = outcome.monitor ?? t('shell.all_monitors');
  if (outcome.gone) return { kind: 'warning', text: t('stop.gone', { monitor: who }), stays: true };
  const { waiting } = outcome;
  if (outcome.unconfirmed && waiting?.length) return notConfirmed(waiting, outcome.what);
  if (outcome.unconfirmed) {
    const what = `${who} · ${titleOf(outcome.what)}`;
    return { kind: 'error', text: `${what}: ${t('stop.unconfirmed')}`, more: t('stop.unconfirmed_more') };
  }
  if (outcome.error) {
    if (stands(outcome, outcome.error)) return { kind: 'info', text: t('stop.stands', { monitor: who }) };
    if (outcome.urgent && outcome.monitor && isSilent(outcome.error))
      return notConfirmed([outcome.monitor], outcome.what, true);
    const refused = refusals(outcome.error)?.[0];
    return {
      kind: outcome.error.code === 'refused' ? 'warning' : 'error',
      text: `${who} · ${titleOf(outcome.what)}: ${refused ? tt(refused.meaning) : outcome.error.text(lang())}`,
      more: tt(refused?.remedy),
    };
  }
  if (outcome.what.startsWith('authority')) return null;
  const silent = outcome.waiting?.length ? t('stop.no_answer_yet', { monitors: outcome.waiting.join(', ') }) : '';
  const failed = outcome.failed?.filter(({ error }) => !stands(outcome, error)) ?? [];
  if (failed.length) {
    const ids = failed.map(({ monitor }) => monitor);
    if (outcome.urgent && !waiting?.length && failed.every(({ error }) => isSilent(error)))
      return notConfirmed(ids, outcome.what, true);
    const monitors = ids.join(', ');
    return {
      kind: 'error',
      text: `${titleOf(outcome.what)} · ${t('stop.not_done', { monitors })}`,
      more: [failed[0]!.error.text(lang()), silent].filter(Boolean).join(' '),
    };
  }
  if (silent) return { kind: 'warning', text: silent };
  if (outcome.waiting) return null;
  const bad = outcome.result?.answers.find((answer) => !answer.success);
  if (bad)
    return {
      kind: 'warning',
      text: `${who} · ${titleOf(outcome.what)}: ${tt(bad.meaning) || bad.text}`,
      more: tt(bad.remedy),
    };
  return { kind: 'ok', text: `${who} · ${titleOf(outcome.what)}` };
}

/** The monitor did not answer, however often it was sent. */
function isSilent({ code, details }: HubError): boolean {
  return (code === 'outcome_unknown' || code === 'no_answer') && details.cut !== true;
}

/** What an operator must know of monitors that do not answer an order to stop or close; `over`: it is no longer sent. */
function notConfirmed(ids: readonly string[], what: string, over = false): Toast {
  const monitors = ids.join(', ');
  const order = what ? orderOf(what) : t('stop.order');
  return {
    kind: 'error',
    text: `${monitors} · ${order}: ${t('stop.unconfirmed')}`,
    more: t(over ? 'stop.silent' : 'stop.silent_yet', { monitors }),
  };
}

/** As its button has it. */
function orderOf(what: string): string {
  if (what === 'Stop All') return t('stop.stop');
  return what.startsWith('Lockout') ? t('stop.lockout') : titleOf(what);
}

/** A monitor that is locked out denies Stop (§3.18/2): the lockout has stopped it already. */
function stands({ what }: Outcome, error: HubError): boolean {
  const denied = refusals(error)?.[0];
  return what.startsWith('Stop') && denied?.from === 'General' && denied.status === 'Denied';
}

function refusals(error: HubError): Answer[] | undefined {
  return error.details.answers as Answer[] | undefined;
}

function titleOf(what: string): string {
  return what.startsWith('authority ') ? t(what.replace(' ', '.') as Key) : requestWords(what);
}

@customElement('lf-toasts')
export class LfToasts extends LitElement {
  static override styles = [
    base,
    css`
      /* What stays has a row of its own: it covers nothing that the operator looks at. */
      :host {
        display: block;
        grid-area: notes;
        position: relative;
        min-width: 0;
        z-index: 60;
      }
      .live {
        display: contents;
      }
      .stays {
        max-height: 34dvh;
        overflow-y: auto;
      }
      .stays .toast {
        border-width: 1px 0 0 5px;
        border-radius: 0;
        box-shadow: none;
        font-weight: 650;
      }
      .stays .more {
        font-weight: 400;
      }
      .passing {
        position: absolute;
        left: var(--s3);
        bottom: calc(100% + var(--s3));
        width: min(440px, calc(100% - 2 * var(--s3)));
        display: flex;
        flex-direction: column;
        gap: var(--s2);
        pointer-events: none;
      }
      .toast {
        pointer-events: auto;
        display: flex;
        align-items: flex-start;
        gap: var(--s25);
        padding: var(--s25) var(--s1) var(--s25) var(--s25);
        border-radius: var(--radius);
        border: 1px solid var(--chrome-line);
        background: var(--chrome);
        color: var(--on-chrome);
        box-shadow: var(--shadow-large);
      }
      .warning {
        border-left: 5px solid var(--chrome-medium);
      }
      .error {
        border-left: 5px solid var(--chrome-high);
      }
      .text {
        flex: 1;
        min-width: 0;
        overflow-wrap: anywhere;
      }
      .more {
        color: var(--on-chrome-dim);
        margin-top: var(--s1);
      }
      button {
        all: unset;
        width: 48px;
        height: 48px;
        margin: calc(-1 * var(--s25)) 0;
        display: grid;
        place-items: center;
        cursor: pointer;
        color: var(--on-chrome-dim);
      }
      button:focus-visible {
        outline: 3px solid var(--focus);
      }
      @media (max-width: 720px) {
        .passing {
          left: var(--s2);
          bottom: calc(100% + var(--s2));
        }
      }
    `,
  ];

  /** Pages that fill the window are lower by it. */
  private readonly sized = new ResizeObserver(() =>
    document.documentElement.style.setProperty('--notes-height', `${this.offsetHeight}px`),
  );

  override connectedCallback(): void {
    super.connectedCallback();
    notes.addEventListener('change', this.changed);
    this.sized.observe(this);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    notes.removeEventListener('change', this.changed);
    this.sized.disconnect();
  }

  override render() {
    return html`<div role="status" aria-live="polite" class="live">
      <div class="stays">${this.those(true)}</div>
      <div class="passing">${this.those(false)}</div>
    </div>`;
  }

  private those(stay: boolean) {
    return repeat(
      notes.shown.filter(({ stays = false }) => stays === stay),
      (note) => note.id,
      (note) => html`<div class="toast ${note.kind}">
        ${icon(ICONS[note.kind])}
        <div class="text">
          ${note.text}${note.count > 1 ? html` <b>×${note.count}</b>` : nothing}
          ${note.more ? html`<div class="more">${note.more}</div>` : nothing}
        </div>
        <button aria-label=${t('shell.close')} @click=${() => notes.drop(note.id)}>${icon('close', 18)}</button>
      </div>`,
    );
  }

  private readonly changed = (): void => this.requestUpdate();
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-toasts': LfToasts;
  }
}
