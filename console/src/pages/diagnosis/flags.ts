// Every flag of every subsystem: meaning, cause, remedy.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { repeat } from 'lit/directives/repeat.js';
import type { Severity } from '../../hub/types';
import { lang, num, t, tt } from '../../i18n';
import { type IconName, icon } from '../../parts/icons';
import '../../parts/lf-blank';
import '../../parts/lf-chip';
import '../../parts/lf-find';
import { base, card } from '../../theme/shared';
import { subsystemText } from '../alarms/names';
import { type FlagSeen, matchingFlags } from './model';

export const SEVERITY_ICONS: Record<Severity, IconName> = {
  alarm: 'alarm',
  warning: 'warning',
  notice: 'info',
  info: 'dot',
};

export const flagStyle = css`
  .flag {
    display: grid;
    grid-template-columns: 28px minmax(0, 1fr);
    gap: var(--s05) var(--s2);
    padding: var(--s2) var(--s25) var(--s2) var(--s2);
    border-top: 1px solid var(--line);
    line-height: 1.45;
  }
  .flag .icon {
    margin-top: 1px;
  }
  .flag.set.alarm .icon {
    color: var(--high);
  }
  .flag.set.warning .icon {
    color: var(--medium);
  }
  .flag.set.alarm,
  .flag.set.warning {
    box-shadow: inset 4px 0 0 var(--edge);
  }
  .flag.alarm {
    --edge: var(--high);
  }
  .flag.warning {
    --edge: var(--medium);
  }
  .flag .name {
    display: flex;
    flex-wrap: wrap;
    gap: 0 var(--s2);
    align-items: baseline;
  }
  .flag .name b {
    font-weight: 650;
  }
  .flag .code {
    font-family: var(--mono);
    font-size: var(--t-small);
    color: var(--dim);
  }
  .flag .meaning {
    font-weight: 600;
    overflow-wrap: anywhere;
  }
  .flag:not(.set) .meaning {
    font-weight: 400;
  }
  .flag:not(.set) .icon {
    color: var(--faint);
  }
  .flag dl {
    margin: var(--s1) 0 0;
    display: grid;
    grid-template-columns: max-content minmax(0, 1fr);
    gap: var(--s05) var(--s25);
  }
  .flag dt {
    color: var(--dim);
    font-size: var(--t-note);
  }
  .flag dd {
    margin: 0;
  }
  .flag dd.do {
    font-weight: 600;
  }
  @media (max-width: 720px) {
    .flag dl {
      grid-template-columns: 1fr;
      gap: 0;
    }
    .flag dd {
      margin-bottom: var(--s15);
    }
  }
`;

export function renderFlag(flag: FlagSeen, { where, full }: { where: boolean; full: boolean }) {
  return html`<div class="flag ${flag.severity} ${flag.set ? 'set' : ''}" data-flag="${flag.subsystem}/${flag.flag.name}">
    ${flag.set ? icon(SEVERITY_ICONS[flag.severity]) : icon(SEVERITY_ICONS[flag.severity], 16)}
    <div>
      <div class="name">
        ${where ? html`<b>${subsystemText(flag.subsystem)}</b>` : nothing}
        <span class="code">${flag.name}</span>
        <span class="small dim">${t(`diagnosis.severity_${flag.severity}`)}</span>
        ${flag.set && !where ? html`<b class="small">${t('diagnosis.is_set')}</b>` : nothing}
      </div>
      <div class="meaning">${tt(flag.flag.meaning)}</div>
      ${
        full
          ? html`<dl>
            ${
              tt(flag.flag.cause)
                ? html`<dt>${t('diagnosis.cause')}</dt>
                  <dd>${tt(flag.flag.cause)}</dd>`
                : nothing
            }
            ${
              tt(flag.flag.remedy)
                ? html`<dt>${t('diagnosis.remedy')}</dt>
                  <dd class="do">${tt(flag.flag.remedy)}</dd>`
                : nothing
            }
          </dl>`
          : nothing
      }
    </div>
  </div>`;
}

@customElement('lf-all-flags')
export class LfAllFlags extends LitElement {
  static override styles = [
    base,
    card,
    flagStyle,
    css`
      .card {
        padding: 0;
      }
      .card > header {
        padding: var(--s3) var(--s3) 0;
        flex-wrap: wrap;
      }
      lf-find {
        flex: 1 1 240px;
        max-width: 420px;
      }
      details {
        border-top: 1px solid var(--line);
      }
      summary {
        display: flex;
        align-items: center;
        gap: var(--s25);
        min-height: 52px;
        padding: 0 var(--s3);
        cursor: pointer;
        list-style: none;
      }
      summary::-webkit-details-marker {
        display: none;
      }
      summary::before {
        content: '›';
        font-size: var(--t-title);
        width: 12px;
        text-align: center;
        color: var(--dim);
      }
      details[open] > summary::before {
        transform: rotate(90deg);
      }
      summary:hover {
        background: var(--surface-2);
      }
      summary .title {
        font-weight: 650;
      }
      @media (max-width: 720px) {
        summary {
          flex-wrap: wrap;
          gap: var(--s05) var(--s25);
          padding: var(--s2) var(--s3);
        }
        summary .mono {
          display: none;
        }
        lf-find {
          flex-basis: 100%;
        }
      }
      .flags {
        padding: 0 var(--s3) var(--s2) calc(var(--s3) + var(--s25));
      }
    `,
  ];

  @property({ attribute: false }) flags: FlagSeen[] = [];
  @property({ type: Boolean }) stale = false;
  /** The monitor has never answered. */
  @property({ type: Boolean }) never = false;
  @state() private text = '';
  @state() private open = new Set<string>();

  override render() {
    const shown = matchingFlags(this.flags, this.text, lang());
    const subsystems = [...new Set(shown.map((flag) => flag.subsystem))];
    return html`<section class="card">
      <header>
        <h2>${t('diagnosis.all')}</h2>
        <lf-find
          .label=${t('diagnosis.find')}
          .clear=${t('diagnosis.find_clear')}
          .value=${this.text}
          @find=${(e: CustomEvent<string>) => (this.text = e.detail)}
        ></lf-find>
      </header>
      ${
        subsystems.length === 0
          ? html`<lf-blank icon="search" .head=${t('diagnosis.none_match')}></lf-blank>`
          : repeat(
              subsystems,
              (name) => name,
              (name) =>
                this.renderSubsystem(
                  name,
                  shown.filter((flag) => flag.subsystem === name),
                ),
            )
      }
    </section>`;
  }

  /** Only open sections are in the page: there are hundreds of flags. */
  private toggled(name: string, event: Event): void {
    if (this.text.trim() !== '') return;
    const open = new Set(this.open);
    if ((event.target as HTMLDetailsElement).open) open.add(name);
    else open.delete(name);
    this.open = open;
  }

  private renderSubsystem(name: string, flags: FlagSeen[]) {
    const set = flags.filter((flag) => flag.set);
    const bad = set.filter((flag) => flag.severity === 'alarm' || flag.severity === 'warning');
    const worst = bad.some((flag) => flag.severity === 'alarm') ? 'high' : 'medium';
    const open = this.open.has(name) || this.text.trim() !== '';
    return html`<details ?open=${open} @toggle=${(event: Event) => this.toggled(name, event)}>
      <summary>
        <span class="title">${subsystemText(name)}</span>
        <span class="small dim mono">${name}</span>
        <span class="grow"></span>
        ${
          bad.length > 0
            ? html`<lf-chip kind=${worst} icon=${worst === 'high' ? 'alarm' : 'warning'} ?stale=${this.stale}
              >${bad.map((flag) => flag.flag.name).join(', ')}</lf-chip
            >`
            : html`<span class="small dim">${this.never ? t('diagnosis.unknown') : t('diagnosis.set_of', { n: num(set.length), of: num(flags.length) })}</span>`
        }
      </summary>
      <div class="flags">
        ${
          open
            ? [...set, ...flags.filter((flag) => !flag.set)].map((flag) =>
                renderFlag(flag, { where: false, full: true }),
              )
            : nothing
        }
      </div>
    </details>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-all-flags': LfAllFlags;
  }
}
