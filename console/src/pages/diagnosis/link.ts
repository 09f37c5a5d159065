// The link to a monitor in figures: since the hub's start, and over the last minutes.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { linkFigures } from '../../hub/session';
import { SECOND, store, TopicController } from '../../hub/store';
import type { LinkFigures } from '../../hub/types';
import { age, type Key, num, t, tt } from '../../i18n';
import '../../parts/lf-chip';
import '../../parts/lf-trend';
import { base } from '../../theme/shared';
import { fillSamples, type Measure, points, samplesOf, spanOf } from './samples';

const COUNTS = [
  'sent',
  'received',
  'retries',
  'timeouts',
  'errors',
  'late',
  'strays',
  'collisions',
  'reconnects',
] as const;

/** Counters that are harmless at any value. */
const USUAL = new Set<string>(['sent', 'received']);

const TRENDS: { measure: Measure; digits: number }[] = [
  { measure: 'rtt_ms', digits: 1 },
  { measure: 'loss_percent', digits: 1 },
  { measure: 'received', digits: 0 },
  { measure: 'retries', digits: 0 },
];

@customElement('lf-link-stats')
export class LfLinkStats extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--s3);
      }
      .state {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--s2) var(--s3);
      }
      .endpoint {
        font-family: var(--mono);
        font-size: var(--t-note);
        color: var(--dim);
        overflow-wrap: anywhere;
      }
      .trends {
        display: grid;
        grid-template-columns: repeat(auto-fit, minmax(220px, 1fr));
        gap: var(--s3);
      }
      .span {
        margin-top: calc(-1 * var(--s2));
        font-size: var(--t-small);
        color: var(--dim);
      }
      dl {
        margin: 0;
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(104px, 1fr));
        gap: var(--s2) var(--s3);
      }
      dt {
        font-size: var(--t-small);
        color: var(--dim);
      }
      dd {
        margin: 0;
        font-size: var(--t-field);
        font-weight: 600;
      }
      .zero dd {
        font-weight: 400;
        color: var(--dim);
      }
      .matters dd {
        color: var(--medium);
      }
      .stale dd {
        font-style: italic;
        font-weight: 400;
        color: var(--dim);
      }
      .error {
        font-weight: 600;
        line-height: 1.45;
      }
    `,
  ];

  @property() monitor = '';

  constructor() {
    super();
    new TopicController(this, () => [`monitors/${this.monitor}/link`, SECOND]);
  }

  override willUpdate(changed: Map<PropertyKey, unknown>): void {
    if (changed.has('monitor') && this.monitor) void fillSamples(this.monitor).then(() => this.requestUpdate());
  }

  override render() {
    const state = store.get(`monitors/${this.monitor}/link`)?.state;
    const link = linkFigures(this.monitor);
    if (!state) return nothing;
    if (!link) {
      const [kind, mark] = state === 'down' ? (['high', 'unlinked'] as const) : (['normal', 'link'] as const);
      return html`<div class="state"><lf-chip kind=${kind} icon=${mark}>${t(`diagnosis.replay_${state}`)}</lf-chip></div>
        <p class="dim">${t('diagnosis.replay_link')}</p>`;
    }
    const heard = store.linked;
    const down = state === 'down';
    const now = store.now();
    const span_ms = spanOf(now - (samplesOf(this.monitor)[0]?.t ?? now));
    return html`<div class="state">
        <lf-chip kind=${down ? 'high' : 'normal'} icon=${down ? 'unlinked' : 'link'} ?stale=${!heard}
          >${t(down ? 'diagnosis.link_down' : 'diagnosis.link_up', { age: age(store.now() - link.since_ms) })}</lf-chip
        >
        <span class="endpoint">${link.endpoint}</span>
      </div>
      ${link.error ? html`<div class="error">${tt(link.error)}</div>` : nothing}
      <div class="trends">
        ${TRENDS.map(
          ({ measure, digits }) => html`<lf-trend
            .name=${t(`diagnosis.trend_${measure}` as Key)}
            .unit=${t(`diagnosis.unit_${measure}` as Key)}
            .points=${points(this.monitor, measure)}
            .now=${now}
            .span_ms=${span_ms}
            .digits=${digits}
            ?stale=${!heard || down}
          ></lf-trend>`,
        )}
      </div>
      <div class="span">${t('diagnosis.span', { n: span_ms / 60_000 })}</div>
      <dl class=${heard ? '' : 'stale'}>${COUNTS.map((name) => this.renderCount(name, link))}</dl>`;
  }

  private renderCount(name: (typeof COUNTS)[number], link: LinkFigures) {
    const value = link[name];
    const recent = !USUAL.has(name) && name in link.last && link.last[name as 'retries'] > 0;
    return html`<div class="${value === 0 ? 'zero' : ''} ${recent ? 'matters' : ''}" title=${t(`diagnosis.about_${name}`)}>
      <dt>${t(`diagnosis.count_${name}`)}</dt>
      <dd>${num(value)}</dd>
    </div>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-link-stats': LfLinkStats;
  }
}
