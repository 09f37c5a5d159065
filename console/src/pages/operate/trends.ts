// Pressure and flow, and the currents of the drives, as they come.
import { LitElement, css, html } from 'lit';
import { customElement, property, query, state } from 'lit/decorators.js';
import { http } from '../../hub/http';
import { validOf } from '../../hub/readings';
import { store } from '../../hub/store';
import { t } from '../../i18n';
import type { LfPlot, PlotSeries } from '../../parts/lf-plot';
import '../../parts/lf-plot';
import { base, card } from '../../theme/shared';
import { digitsOf, fromWire, unitText, type Quantity } from '../../units';

type What = 'water' | 'currents';

interface Source {
  id: string;
  subsystem: string;
  field: string;
  quantity: Quantity;
}

const SOURCES: Record<What, Source[]> = {
  water: [
    { id: 'pressure', subsystem: 'General', field: 'pressure', quantity: 'pressure' },
    { id: 'flow', subsystem: 'General', field: 'flowrate', quantity: 'flow' },
  ],
  currents: [
    { id: 'Horizontal', subsystem: 'Horizontal', field: 'current', quantity: 'current' },
    { id: 'Vertical', subsystem: 'Vertical', field: 'current', quantity: 'current' },
    { id: 'Nozzle', subsystem: 'Nozzle', field: 'current', quantity: 'current' },
  ],
};
const RANGES: Partial<Record<string, [number, number]>> = { pressure: [0, 100], flow: [0, 25] };
const NO_WINDOWS: number[] = [];
const PAST_MS = 15 * 60_000;

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
        padding: 10px 12px 6px;
        display: grid;
        grid-template-rows: auto 1fr;
        gap: 4px;
      }
      .card.hidden {
        display: none;
      }
      .what {
        display: flex;
        gap: 4px;
        --lf-button-height: 48px;
        --lf-button-size: 13px;
        --lf-button-wrap: nowrap;
      }
      lf-plot {
        min-height: 0;
        height: 100%;
      }
      @container (max-width: 540px) {
        .what {
          flex-wrap: wrap;
          gap: 2px;
          --lf-button-padding: 9px;
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
  @state() private stale = false;
  @state() private minutes = 1;
  @state() private shown: What = 'water';
  @query('#water') private water!: LfPlot;
  @query('#currents') private currents!: LfPlot;
  private end = () => {};

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
            (one) => html`<lf-button class="tab" kind="quiet" toggle .on=${one === this.shown} @click=${() => (this.shown = one)}
              >${t(`operate.plot_${one}`)}</lf-button
            >`,
          )}
          <span class="grow"></span>
          ${[1, 5, 15].map(
            (n) => html`<lf-button kind="quiet" toggle .on=${n === this.minutes} @click=${() => (this.minutes = n)}
              >${t('operate.minutes', { n })}</lf-button
            >`,
          )}
        </div>
        <lf-plot
          id=${what}
          .series=${this.series(what)}
          .minutes=${this.minutes}
          .windows=${NO_WINDOWS}
          .now=${() => store.now()}
          .stale=${this.stale}
          .label=${t(`operate.plot_${what}`)}
        ></lf-plot>
      </section>`,
    )}</div>`;
  }

  private readonly made = new Map<What, PlotSeries[]>();

  /** Once: a new list would clear the plot. */
  private series(what: What): PlotSeries[] {
    const made = this.made.get(what) ?? seriesOf(what);
    this.made.set(what, made);
    return made;
  }

  private push(): void {
    const status = store.get(`monitors/${this.monitor}/status`);
    if (!status || !this.hasUpdated) return;
    this.stale = status.stale;
    const at = status.stale ? store.now() : (status.at_ms ?? store.now());
    for (const what of ['water', 'currents'] as const) {
      const values = SOURCES[what].map(({ id, subsystem, field, quantity }) => {
        const value = validOf(status.subsystems[subsystem], field);
        return [id, value !== null && !status.stale ? fromWire(quantity, value) : null] as const;
      });
      (what === 'water' ? this.water : this.currents).push(at, Object.fromEntries(values));
    }
  }

  /** What was before the page was opened, from the history. */
  private async past(): Promise<void> {
    if (store.source === 'replay') return;
    const to = store.now();
    for (const what of ['water', 'currents'] as const) {
      const series = SOURCES[what].map((s) => `${s.subsystem}.${s.field}`).join(',');
      const query = `monitor=${this.monitor}&series=${series}&from_ms=${Math.round(to - PAST_MS)}&to_ms=${Math.round(to)}`;
      const answer = await http
        .get<{ series: Record<string, Past[]> }>(`/api/history?${query}`)
        .catch(() => null);
      if (!answer || !this.isConnected) return;
      const values = SOURCES[what].map((s) => {
        const points = answer.series[`${s.subsystem}.${s.field}`] ?? [];
        return [s.id, steps(points, to).map(([at, v]) => [at, v === null ? null : fromWire(s.quantity, v)] as const)] as const;
      });
      (what === 'water' ? this.water : this.currents).fill(Object.fromEntries(values));
    }
  }
}

/** A value since when; null: from then on it is not known. */
type Past = [number, number | null];

/** A value holds until the next change. */
function steps(points: Past[], to: number): Past[] {
  return points.flatMap(([at, value], n): Past[] => [
    [at, value],
    [Math.max(at, (points[n + 1]?.[0] ?? to) - 1), value],
  ]);
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
