// Hours and days of a few values, from the history: the mean of each interval as a line, minimum to maximum as an area.
import { css, html, LitElement, nothing, type PropertyValues } from 'lit';
import { customElement, property, query, state } from 'lit/decorators.js';
import { HubError } from '../../hub/errors';
import { http } from '../../hub/http';
import { store } from '../../hub/store';
import { age, lang, t } from '../../i18n';
import type { LfPlot, PlotSeries } from '../../parts/lf-plot';
import { type Curve, curveOf } from '../../parts/plot/data';
import { base } from '../../theme/shared';
import { fromWire } from '../../units';
import type { Source } from './sources';

/** Number of intervals that fit into a wide picture. */
const POINTS = 600;
/** For changes the hub keeps the extremes of a quarter as many parts. */
const CHANGES = 4 * POINTS;
const AGAIN_MS = 30_000;

/** A value since when; null: from then on it is not known. */
export type Past = [number, number | null];
type Span = [begin_ms: number, mean: number, least: number, greatest: number];

interface History {
  resolution_ms: number;
  series: Record<string, (Past | Span)[]>;
}

/** A value holds until the next change. */
export function steps(points: Past[], to: number): Past[] {
  return points.flatMap(([at, value], n): Past[] => [
    [at, value],
    [Math.max(at, (points[n + 1]?.[0] ?? to) - 1), value],
  ]);
}

@customElement('lf-past')
export class LfPast extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-rows: minmax(0, 1fr) auto;
      }
      lf-plot {
        min-height: 0;
      }
    `,
  ];

  @property() monitor = '';
  @property({ attribute: false }) sources: Source[] = [];
  @property({ attribute: false }) series: PlotSeries[] = [];
  @property({ attribute: false }) span_ms = 0;
  @property() label = '';
  @state() private shown: [number, number] = [0, 1];
  @state() private resolution_ms = 0;
  @state() private fault = '';
  @query('lf-plot') private plot!: LfPlot;
  /** Only the latest query counts. */
  private asked = 0;
  private timer = 0;

  override connectedCallback(): void {
    super.connectedCallback();
    this.timer = window.setInterval(() => void this.read(), AGAIN_MS);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
    this.asked++;
  }

  override updated(changed: PropertyValues): void {
    if (changed.has('span_ms') || changed.has('monitor')) void this.read();
  }

  override render() {
    return html`<lf-plot
        banded
        .series=${this.series}
        .span=${this.shown}
        .label=${this.label}
      ></lf-plot>
      ${
        this.fault
          ? html`<p class="small error" role="status">${this.fault}</p>`
          : this.resolution_ms
            ? html`<p class="small dim">${t('operate.band', { step: age(this.resolution_ms) })}</p>`
            : nothing
      }`;
  }

  private async read(): Promise<void> {
    const turn = ++this.asked;
    const to = Math.round(store.now());
    const from = to - this.span_ms;
    const names = this.sources.map(nameOf).join(',');
    const points = this.span_ms > 2 * 3_600_000 ? POINTS : CHANGES;
    const query = `monitor=${this.monitor}&series=${names}&from_ms=${from}&to_ms=${to}&points=${points}`;
    try {
      const answer = await http.get<History>(`/api/history?${query}`);
      if (turn !== this.asked) return;
      this.fault = '';
      this.resolution_ms = answer.resolution_ms;
      this.shown = [from, to];
      this.plot.fillBands(Object.fromEntries(this.sources.map((source) => [source.id, curve(source, answer, to)])));
    } catch (cause) {
      if (turn === this.asked) this.fault = t('operate.past_failed', { why: HubError.of(cause).text(lang()) });
    }
  }
}

function nameOf({ subsystem, field }: Source): string {
  return `${subsystem}.${field}`;
}

function curve(source: Source, { resolution_ms, series }: History, to: number): Curve {
  const points = series[nameOf(source)] ?? [];
  const own = (value: number) => fromWire(source.quantity, value);
  if (resolution_ms > 0) {
    const spans = (points as Span[]).map(
      ([at, ...values]): Span => [at, ...(values.map(own) as [number, number, number])],
    );
    return curveOf(spans, resolution_ms);
  }
  const value = steps(points as Past[], to).map(([at, one]): Past => [at, one === null ? null : own(one)]);
  return { value, low: [], high: [] };
}
