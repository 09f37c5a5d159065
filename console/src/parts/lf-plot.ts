import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult, unsafeCSS } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import uPlot from 'uplot';
import uplotStyle from 'uplot/dist/uPlot.min.css?inline';
import { dayTime, num, t, time } from '../i18n';
import { magnified } from '../theme/display';
import { inUnit } from '../units';
import { emit, partStyle } from './part-style';
import { Columns, type Curve, type Value } from './plot/data';
import { Words } from './words';

export interface PlotSeries {
  id: string;
  label: string;
  unit: string;
  digits?: number;
  /** Series of one scale share an axis; the first scale is on the left, the second on the right. */
  scale?: string;
  /** Minimum range of the scale. */
  range?: readonly [number, number];
  /** Name of a colour token, without `--`. */
  colour?: string;
}

const COLOURS = ['accent', 'medium', 'foam', 'dim'];
const DASHES: (number[] | undefined)[] = [undefined, [8, 3], [2, 3], [8, 3, 2, 3]];
const KEEP_MS = 16 * 60_000;
const FRAME_MS = 100;
const DAY_MS = 86_400_000;
export const WINDOWS = [1, 5, 15] as const;

/**
 * Values over the last minutes. `push` adds them as they come, null where nothing is known; `fill`
 * sets them all. The right edge is `now()`. Event: `window` {minutes}.
 */
@customElement('lf-plot')
export class LfPlot extends LitElement {
  @property({ attribute: false }) series: readonly PlotSeries[] = [];
  @property({ type: Number }) minutes: number = 1;
  @property({ attribute: false }) windows: readonly number[] = WINDOWS;
  /** The clock of the right edge. */
  @property({ attribute: false }) now: () => number = () => Date.now();
  /** A fixed span instead of the last minutes: from, to. */
  @property({ attribute: false }) span: readonly [number, number] | null = null;
  /** Each series has an area around its line, and all of a long time is kept: `fillBands`. */
  @property({ type: Boolean }) banded: boolean = false;
  @property({ type: Boolean, reflect: true }) stale: boolean = false;
  @property() label: string = '';
  @state() hidden_: ReadonlySet<string> = new Set();
  @state() read: { values: Value[]; at_ms: number | null } = { values: [], at_ms: null };
  @state() empty: boolean = true;

  private columns = new Columns(0, KEEP_MS);
  private ids = '';
  private plot: uPlot | null = null;
  private frame = 0;
  private drawn_ms = 0;
  private seen = true;
  private observers: { disconnect(): void }[] = [];

  constructor() {
    super();
    new Words(this);
  }

  static override styles = [
    unsafeCSS(uplotStyle),
    partStyle,
    css`
      :host {
        display: grid;
        grid-template-rows: auto 1fr;
        min-height: 180px;
        min-width: 0;
      }
      header {
        display: flex;
        flex-wrap: wrap;
        gap: var(--s1) var(--s25);
        align-items: center;
        justify-content: space-between;
      }
      .keys {
        display: flex;
        flex-wrap: wrap;
        gap: var(--s1) var(--s2);
        margin: 0;
        padding: 0;
        list-style: none;
      }
      .key {
        display: inline-flex;
        align-items: center;
        gap: var(--s2);
        min-height: 48px;
        padding: var(--s1) var(--s2);
        border: 0;
        border-radius: var(--radius);
        background: none;
        color: var(--text);
        font: inherit;
        font-size: var(--t-note);
        cursor: pointer;
      }
      .key:hover {
        background: var(--surface-2);
      }
      .key:focus-visible,
      .windows button:focus-visible {
        outline: 3px solid var(--focus);
        outline-offset: -2px;
      }
      .key[aria-pressed='false'] {
        color: var(--dim);
        text-decoration: line-through;
      }
      .key svg {
        width: 22px;
        height: 8px;
        flex: none;
      }
      .key line {
        stroke-width: 2.5;
      }
      .key b {
        display: inline-block;
        min-width: 4.5ch;
        text-align: right;
        font-weight: 600;
      }
      :host([stale]) .key b {
        color: var(--dim);
        font-weight: 450;
      }
      .windows {
        display: inline-flex;
        border: 1px solid var(--line);
        border-radius: var(--radius);
        overflow: hidden;
      }
      .windows button {
        min-height: 48px;
        padding: 0 var(--s25);
        border: 0;
        background: none;
        color: var(--dim);
        font: inherit;
        font-size: var(--t-note);
        cursor: pointer;
      }
      .windows button + button {
        border-left: 1px solid var(--line);
      }
      .windows button[aria-checked='true'] {
        background: var(--surface-2);
        color: var(--text);
        font-weight: 600;
      }
      @media (pointer: coarse) {
        .windows button,
        .key {
          min-height: 48px;
        }
      }
      .area {
        position: relative;
        min-height: 120px;
        min-width: 0;
        overflow: hidden;
      }
      /* A canvas that is magnified would be blurred. */
      .area .uplot {
        position: absolute;
        font: inherit;
        zoom: calc(1 / var(--zoom, 1));
      }
      .none {
        position: absolute;
        inset: 0;
        display: grid;
        place-items: center;
        color: var(--dim);
        font-size: var(--t-note);
        pointer-events: none;
      }
      .u-cursor-x,
      .u-cursor-y {
        border-color: var(--line-strong) !important;
      }
    `,
  ];

  /** Adds values by the ids of their series; missing ones are unknown at that time. */
  push(at_ms: number, values: Readonly<Record<string, Value | undefined>>): void {
    this.fitted().push(
      at_ms,
      this.series.map(({ id }) => values[id] ?? null),
    );
    if (this.empty) this.empty = false;
    this.draw();
  }

  /** Replaces all values: [time, value] of each series. */
  fill(values: Readonly<Record<string, readonly (readonly [number, Value])[]>>): void {
    this.fitted().fill(this.series.map(({ id }) => values[id] ?? []));
    this.empty = this.columns.length === 0;
    this.drawn_ms = 0;
    this.draw();
  }

  /** The same with areas, for a plot that is `banded`. */
  fillBands(curves: Readonly<Record<string, Curve>>): void {
    const of = (part: keyof Curve) => this.series.map(({ id }) => curves[id]?.[part] ?? []);
    this.fitted().fill([...of('value'), ...of('low'), ...of('high')]);
    this.empty = this.columns.length === 0;
    this.drawn_ms = 0;
    this.draw();
  }

  clear(): void {
    this.columns.clear();
    this.empty = true;
    this.draw();
  }

  override connectedCallback(): void {
    super.connectedCallback();
    const resize = new ResizeObserver(() => this.resized());
    resize.observe(this);
    const visible = new IntersectionObserver(([entry]) => {
      this.seen = entry!.isIntersecting;
      this.draw();
    });
    visible.observe(this);
    const theme = new MutationObserver(() => this.build());
    theme.observe(document.documentElement, { attributeFilter: ['data-theme', 'lang'] });
    this.observers = [resize, visible, theme];
    if (this.hasUpdated) this.build();
    this.draw();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    for (const observer of this.observers) observer.disconnect();
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    this.plot?.destroy();
    this.plot = null;
  }

  protected override willUpdate(changed: PropertyValues): void {
    if (changed.has('series')) this.fitted();
  }

  /** The columns belong to these series; other series start with new columns. */
  private fitted(): Columns {
    const ids = [this.banded, ...this.series.map(({ id }) => id)].join();
    if (ids !== this.ids) {
      this.ids = ids;
      const count = this.series.length;
      this.columns = this.banded ? new Columns(3 * count, Infinity) : new Columns(count, KEEP_MS);
      this.empty = true;
    }
    return this.columns;
  }

  protected override updated(changed: PropertyValues): void {
    const shape = ['series', 'hidden_', 'banded'].some((name) => changed.has(name));
    if (shape || !this.plot) this.build();
    else if (changed.has('minutes') || changed.has('span')) {
      this.drawn_ms = 0;
      this.draw();
    }
  }

  protected override render(): TemplateResult {
    const several = this.windows.length > 1 && !this.span;
    return html`<header>
        <ul class="keys" aria-label=${t('parts.plot.lines')}>
          ${this.series.map((series, index) => this.key(series, index))}
        </ul>
        ${several ? this.choice() : nothing}
      </header>
      <div class="area" role="img" aria-label=${this.spoken()}>
        ${this.empty ? html`<div class="none">${t('parts.plot.empty')}</div>` : nothing}
      </div>`;
  }

  private key(series: PlotSeries, index: number): TemplateResult {
    const value = this.read.values[index];
    const shown = !this.hidden_.has(series.id);
    const dash = DASHES[index % DASHES.length]?.join(' ') ?? '';
    return html`<li>
      <button type="button" class="key" aria-pressed=${shown} @click=${() => this.toggle(series.id)}>
        <svg viewBox="0 0 22 8" aria-hidden="true">
          <line x1="0" x2="22" y1="4" y2="4" stroke=${`var(--${this.colour(series, index)})`} stroke-dasharray=${dash}></line>
        </svg>
        ${series.label} <b>${this.text(series, value)}</b>${inUnit('', series.unit)}${this.band(series, index)}
      </button>
    </li>`;
  }

  /** Minimum and maximum at the time under the pointer. */
  private band(series: PlotSeries, index: number): string {
    const count = this.series.length;
    const [low, high] = [this.read.values[count + index], this.read.values[2 * count + index]];
    if (!this.banded || low == null || high == null || low === high) return '';
    return ` (${this.text(series, low)} … ${this.text(series, high)})`;
  }

  private choice(): TemplateResult {
    return html`<div class="windows" role="radiogroup" aria-label=${t('parts.plot.window')}>
      ${this.windows.map(
        (minutes) => html`<button
          type="button"
          role="radio"
          aria-checked=${minutes === this.minutes}
          tabindex=${minutes === this.minutes ? 0 : -1}
          @click=${() => this.choose(minutes)}
          @keydown=${this.choiceKey}
        >
          ${t('parts.plot.minutes', { n: minutes })}
        </button>`,
      )}
    </div>`;
  }

  private choose(minutes: number): void {
    this.minutes = minutes;
    emit(this, 'window', { minutes });
  }

  private choiceKey(event: KeyboardEvent): void {
    const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (!by) return;
    event.preventDefault();
    const count = this.windows.length;
    const next = (this.windows.indexOf(this.minutes) + by + count) % count;
    this.choose(this.windows[next]!);
    void this.updateComplete.then(() =>
      this.renderRoot.querySelectorAll<HTMLButtonElement>('.windows button')[next]?.focus(),
    );
  }

  private spoken(): string {
    const values = this.series.map(
      (series, index) => `${series.label} ${inUnit(this.text(series, this.read.values[index]), series.unit)}`,
    );
    return [this.label, ...values].filter(Boolean).join(', ');
  }

  private text(series: PlotSeries, value: Value | undefined): string {
    return value === null || value === undefined ? '—' : num(value, series.digits ?? 1);
  }

  private toggle(id: string): void {
    const hidden = new Set(this.hidden_);
    if (!hidden.delete(id)) hidden.add(id);
    this.hidden_ = hidden;
  }

  private colour(series: PlotSeries, index: number): string {
    return series.colour ?? COLOURS[index % COLOURS.length]!;
  }

  private get area(): HTMLElement | null {
    return this.renderRoot.querySelector('.area');
  }

  private resized(): void {
    const { area } = this;
    if (!area || !this.plot) return;
    const { width, height } = sizeOf(area);
    if (width !== this.plot.width || height !== this.plot.height) {
      this.plot.setSize({ width, height });
    }
  }

  private build(): void {
    const { area } = this;
    this.plot?.destroy();
    this.plot = null;
    if (!area || !this.isConnected || !this.series.length) return;
    this.plot = new uPlot(this.options(area), this.columns.table as uPlot.AlignedData, area);
    this.drawn_ms = 0;
    this.draw();
  }

  private options(area: HTMLElement): uPlot.Options {
    const style = getComputedStyle(this);
    const colour = (name: string): string => style.getPropertyValue(`--${name}`).trim();
    const names = [...new Set(this.series.map(({ scale, unit }) => scale ?? unit))];
    const zoom = magnified();
    const font = `${Math.round(12 * zoom)}px ${style.fontFamily}`;
    const axis = (scale: string, index: number): uPlot.Axis => ({
      scale,
      side: index === 0 ? 3 : 1,
      stroke: colour('dim'),
      font,
      size: 48 * zoom,
      gap: 6 * zoom,
      ticks: { show: false },
      grid: { show: index === 0, stroke: colour('line'), width: 1 },
      values: (_, values, __, ___, step) => values.map((value) => (value === null ? '' : num(value, digitsOf(step)))),
      space: 28 * zoom,
    });
    return {
      ...sizeOf(area),
      padding: [10 * zoom, names.length > 1 ? 0 : (this.isLong() ? 40 : 14) * zoom, 0, 0],
      legend: { show: false },
      cursor: { drag: { x: false, y: false }, points: { size: 7 * zoom }, y: false },
      hooks: { setCursor: [(plot) => this.pointed(plot)] },
      scales: {
        x: { time: true, range: () => this.range() },
        ...Object.fromEntries(names.map((name) => [name, { range: this.ranger(name) }])),
      },
      axes: [
        {
          stroke: colour('dim'),
          font,
          size: 28 * zoom,
          ticks: { show: false },
          grid: { stroke: colour('line'), width: 1 },
          space: (this.isLong() ? 112 : 84) * zoom,
          values: (_, times) => times.map((at) => (this.isLong() ? dayTime : time)(at * 1000)),
        },
        ...names.slice(0, 2).map(axis),
      ],
      series: [
        {},
        ...this.series.map((series, index) => ({
          scale: series.scale ?? series.unit,
          stroke: colour(this.colour(series, index)),
          width: 2 * zoom,
          dash: DASHES[index % DASHES.length]?.map((part) => part * zoom),
          show: !this.hidden_.has(series.id),
          spanGaps: false,
          points: { show: false },
        })),
        ...(this.banded ? [...this.edges(), ...this.edges()] : []),
      ],
      bands: this.banded
        ? this.series.map((series, index) => ({
            series: [1 + 2 * this.series.length + index, 1 + this.series.length + index] as [number, number],
            fill: `color-mix(in srgb, ${colour(this.colour(series, index))} 28%, transparent)`,
          }))
        : [],
    };
  }

  /** The edge of the area of each series: of no line of its own. */
  private edges(): uPlot.Series[] {
    return this.series.map((series) => ({
      scale: series.scale ?? series.unit,
      width: 0,
      show: !this.hidden_.has(series.id),
      spanGaps: false,
      points: { show: false },
    }));
  }

  /** Whether the time of day alone is ambiguous. */
  private isLong(): boolean {
    return this.span !== null && this.span[1] - this.span[0] > DAY_MS;
  }

  private ranger(name: string): uPlot.Scale.Range {
    const mine = this.series.filter(({ scale, unit }) => (scale ?? unit) === name);
    const least = mine.map(({ range }) => range).find((range) => range);
    return (_plot, low, high) => {
      const from = Math.min(low ?? least?.[0] ?? 0, least?.[0] ?? Infinity);
      const to = Math.max(high ?? least?.[1] ?? 1, least?.[1] ?? -Infinity);
      const room = (to - from || 1) * 0.08;
      return [from - (from === least?.[0] ? 0 : room), to + (to === least?.[1] ? 0 : room)];
    };
  }

  private range(): [number, number] {
    if (this.span) return [this.span[0] / 1000, this.span[1] / 1000];
    const now = this.now() / 1000;
    return [now - this.minutes * 60, now];
  }

  /** Drawn at most ten times a second, and not at all while it is invisible. */
  private draw(): void {
    if (this.frame || !this.seen || !this.isConnected) return;
    this.frame = requestAnimationFrame((at) => {
      this.frame = 0;
      if (!this.plot || !this.seen) return;
      if (at - this.drawn_ms >= FRAME_MS) {
        this.drawn_ms = at;
        this.plot.setData(this.columns.table as uPlot.AlignedData, true);
        this.pointed(this.plot);
      }
      // The window also moves on without new values, so that a gap is visible.
      if (!this.span && this.columns.length) this.draw();
    });
  }

  private pointed(plot: uPlot): void {
    const { left } = plot.cursor;
    const on = left !== undefined && left !== null && left >= 0;
    const at_ms = on ? plot.posToVal(left, 'x') * 1000 : (this.span?.[1] ?? this.columns.last_ms);
    const values = at_ms === null ? [] : this.columns.at(at_ms);
    const same =
      values.length === this.read.values.length && values.every((value, index) => value === this.read.values[index]);
    if (!same) this.read = { values, at_ms };
  }
}

/** In the pixels of the screen. */
function sizeOf(area: HTMLElement): { width: number; height: number } {
  const zoom = magnified();
  return {
    width: Math.round(Math.max(area.clientWidth, 120) * zoom),
    height: Math.round(Math.max(area.clientHeight, 80) * zoom),
  };
}

/** As many as the step of an axis has, the same for each of its numbers. */
function digitsOf(step: number): number {
  return step >= 1 ? 0 : Math.min(Math.ceil(-Math.log10(step) - 1e-9), 3);
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-plot': LfPlot;
  }
}
