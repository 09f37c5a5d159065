// Pressure, flow and the currents of the drives: as they arrive, or over hours and days from the history.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, query, state } from 'lit/decorators.js';
import { http } from '../../hub/http';
import { validOf } from '../../hub/readings';
import { SECOND, store, TopicController } from '../../hub/store';
import { t } from '../../i18n';
import type { LfPlot, PlotSeries } from '../../parts/lf-plot';
import '../../parts/lf-plot';
import { base, card } from '../../theme/shared';
import { digitsOf, fromWire, unitText } from '../../units';
import { type Past, steps } from './past';
import { SOURCES, type What } from './sources';

const RANGES: Partial<Record<string, [number, number]>> = { pressure: [0, 100], flow: [0, 25] };
const NO_WINDOWS: number[] = [];
const MINUTE_MS = 60_000;
const HOUR_MS = 60 * MINUTE_MS;
const DAY_MS = 24 * HOUR_MS;
const PAST_MS = 15 * MINUTE_MS;
/** Live values up to this span; longer ones are read from the history. */
const SPANS_MS = [1, 5, 15].map((n) => n * MINUTE_MS);
const LONG_MS = [HOUR_MS, 8 * HOUR_MS, DAY_MS, 7 * DAY_MS, 31 * DAY_MS];

@customElement('lf-trends')
export class LfTrends extends LitElement {
  static override styles = [
    base,
    card,
    css`
      :host {
        display: block;
        height: 256px;
        container-type: inline-size;
      }
      .both {
        display: grid;
        gap: var(--s3);
        height: 100%;
      }
      .card {
        position: relative;
        padding: var(--s2) var(--s25) var(--s15);
        display: grid;
        grid-template-rows: auto 1fr;
        gap: var(--s1);
      }
      .card.hidden {
        display: none;
      }
      .what {
        display: flex;
        gap: var(--s1);
        --lf-button-height: 48px;
        --lf-button-size: 13px;
        --lf-button-wrap: nowrap;
      }
      .span {
        font: inherit;
        font-size: var(--t-normal);
        min-height: 48px;
        padding: 0 var(--s2);
        border: 1px solid var(--line-strong);
        border-radius: var(--radius);
        background: var(--surface);
        color: var(--text);
      }
      [hidden] {
        display: none;
      }
      lf-past {
        min-height: 0;
      }
      lf-plot {
        min-height: 0;
        height: 100%;
      }
      @container (max-width: 540px) {
        .what {
          flex-wrap: wrap;
          gap: var(--s05);
          --lf-button-padding: var(--s2);
        }
      }
      @container (min-width: 1000px) {
        .both {
          grid-template-columns: 1fr 1fr;
        }
        .card.hidden {
          display: grid;
        }
        .tab {
          display: none;
        }
      }
    `,
  ];

  @property() monitor = '';
  @state() private span_ms = MINUTE_MS;
  @state() private shown: What = 'water';
  @query('#water') private water!: LfPlot;
  @query('#currents') private currents!: LfPlot;
  private end = () => {};

  constructor() {
    super();
    new TopicController(this, () => [SECOND]);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.end = store.subscribe(`monitors/${this.monitor}/status`, () => this.push());
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.end();
  }

  override firstUpdated(): void {
    void this.past();
  }

  override render() {
    return html`<div class="both">${(['water', 'currents'] as const).map(
      (what) => html`<section class="card ${what === this.shown ? '' : 'hidden'}">
        <div class="what">
          ${(['water', 'currents'] as const).map(
            (
              one,
            ) => html`<lf-button class="tab" kind="quiet" toggle .on=${one === this.shown} @click=${() => (this.shown = one)}
              >${t(`operate.plot_${one}`)}</lf-button
            >`,
          )}
          <span class="grow"></span>
          ${this.choice()}
        </div>
        <lf-plot
          id=${what}
          ?hidden=${this.span_ms > PAST_MS}
          .series=${this.series(what)}
          .minutes=${Math.min(this.span_ms, PAST_MS) / MINUTE_MS}
          .windows=${NO_WINDOWS}
          .now=${() => store.now()}
          .stale=${store.stale(this.monitor)}
          .label=${t(`operate.plot_${what}`)}
        ></lf-plot>
        ${
          this.span_ms > PAST_MS
            ? html`<lf-past
              .monitor=${this.monitor}
              .sources=${SOURCES[what]}
              .series=${this.series(what)}
              .span_ms=${this.span_ms}
              .label=${t(`operate.plot_${what}`)}
            ></lf-past>`
            : nothing
        }
      </section>`,
    )}</div>`;
  }

  /** A recording has no other data. */
  private choice() {
    const all = store.source === 'replay' ? SPANS_MS : [...SPANS_MS, ...LONG_MS];
    return html`<select
      class="span"
      aria-label=${t('operate.time_shown')}
      @change=${(e: Event) => (this.span_ms = Number((e.target as HTMLSelectElement).value))}
    >
      ${all.map((ms) => html`<option value=${ms} ?selected=${ms === this.span_ms}>${spanText(ms)}</option>`)}
    </select>`;
  }

  private readonly made = new Map<What, PlotSeries[]>();

  /** Created once: a new list would clear the plot. */
  private series(what: What): PlotSeries[] {
    const made = this.made.get(what) ?? seriesOf(what);
    this.made.set(what, made);
    return made;
  }

  private push(): void {
    const status = store.get(`monitors/${this.monitor}/status`);
    if (!status || !this.hasUpdated) return;
    const at = status.stale ? store.now() : (status.at_ms ?? store.now());
    for (const what of ['water', 'currents'] as const) {
      const values = SOURCES[what].map(({ id, subsystem, field, quantity }) => {
        const value = validOf(status.subsystems[subsystem], field);
        return [id, value !== null && !status.stale ? fromWire(quantity, value) : null] as const;
      });
      (what === 'water' ? this.water : this.currents).push(at, Object.fromEntries(values));
    }
  }

  /** Values from before the page was opened, from the history. */
  private async past(): Promise<void> {
    if (store.source === 'replay') return;
    const to = store.now();
    for (const what of ['water', 'currents'] as const) {
      const series = SOURCES[what].map((s) => `${s.subsystem}.${s.field}`).join(',');
      const query = `monitor=${this.monitor}&series=${series}&from_ms=${Math.round(to - PAST_MS)}&to_ms=${Math.round(to)}`;
      const answer = await http.get<{ series: Record<string, Past[]> }>(`/api/history?${query}`).catch(() => null);
      if (!answer || !this.isConnected) return;
      const values = SOURCES[what].map((s) => {
        const points = answer.series[`${s.subsystem}.${s.field}`] ?? [];
        return [
          s.id,
          steps(points, to).map(([at, v]) => [at, v === null ? null : fromWire(s.quantity, v)] as const),
        ] as const;
      });
      (what === 'water' ? this.water : this.currents).fill(Object.fromEntries(values));
    }
  }
}

function spanText(ms: number): string {
  if (ms < HOUR_MS) return t('operate.minutes', { n: ms / MINUTE_MS });
  return ms <= DAY_MS ? t('operate.hours', { n: ms / HOUR_MS }) : t('operate.days', { n: ms / DAY_MS });
}

function seriesOf(what: What): PlotSeries[] {
  return SOURCES[what].map(({ id, quantity }) => {
    const range = RANGES[id];
    return {
      id,
      label: t(`operate.series_${id}` as 'operate.series_flow'),
      unit: unitText(quantity),
      digits: digitsOf(quantity),
      scale: quantity,
      range: range ? [fromWire(quantity, range[0]), fromWire(quantity, range[1])] : [0, 2],
      colour: id === 'flow' ? 'water' : undefined,
    };
  });
}
