// Where the barrel points, as it sees the world: bearing across, elevation up; limits, a sector with
// the way of the jet over it, points of a trajectory, and where the barrel is. Drawn things are
// dragged, or moved with the arrow keys.
import { html, LitElement, nothing, type PropertyValues, svg, type TemplateResult } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { t } from '../i18n';
import { magnified, placeIn } from '../theme/display';
import { chartStyle } from './aim-chart-style';
import { ANGLE_MOST, pulled, type SectorDetail, type SectorGrip, whole } from './lf-aim-chart-model';
import { emit, partStyle } from './part-style';
import { areaOf, type Direction, type DriveLimits, inLimits, isInside, passOver, type Sector } from './raster';
import { angleText, Words } from './words';

export type { SectorDetail } from './lf-aim-chart-model';
export interface PointDetail {
  index: number;
  at: Direction;
}

interface View {
  h: number;
  v: number;
  /** Pixels of an arc-minute. */
  scale: number;
}

interface Drag {
  pointer: number;
  what: SectorGrip | number | 'pan';
  from: [number, number];
  view: View;
  sector: Sector | null;
  at: Direction | null;
  far: boolean;
}

const MARGIN_PX = 44;
const DRAG_LEAST_PX = 4;
const KEY_ARCMIN = 30;
const KEY_FAR_ARCMIN = 300;

@customElement('lf-aim-chart')
export class LfAimChart extends LitElement {
  @property({ attribute: false }) limits: DriveLimits | null = null;
  @property({ attribute: false }) barrel: Direction | null = null;
  @property({ type: Boolean, reflect: true }) stale: boolean = false;
  @property({ attribute: false }) sector: Sector | null = null;
  @property({ attribute: false }) points: readonly Direction[] = [];
  @property({ type: Number }) selected: number = -1;
  /** From the last point the way goes back to the first. */
  @property({ type: Boolean }) repeat: boolean = false;
  /** A press where nothing is adds a point: `point-add`. */
  @property({ type: Boolean, reflect: true }) adding: boolean = false;
  /** What is shown; when it changes, the view is fitted again. */
  @property() subject: string = '';
  @state() view: View | null = null;
  @state() size: [number, number] = [0, 0];

  private drag: Drag | null = null;
  private observer?: ResizeObserver;

  constructor() {
    super();
    new Words(this);
  }

  static override styles = [partStyle, chartStyle];

  override connectedCallback(): void {
    super.connectedCallback();
    this.observer = new ResizeObserver(([entry]) => {
      const { width, height } = entry!.contentRect;
      this.size = [Math.round(width), Math.round(height)];
    });
    this.observer.observe(this);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.observer?.disconnect();
  }

  protected override willUpdate(changed: PropertyValues): void {
    const fresh = changed.has('subject') || changed.has('size');
    if (this.size[0] > 0 && (fresh || !this.view)) this.view = this.fitted();
  }

  /** Shows what is drawn, and the barrel; `whole`: all of the limits. */
  fit(whole = false): void {
    this.view = this.fitted(whole);
  }

  protected override render(): TemplateResult {
    const [width, height] = this.size;
    return html`<svg
        viewBox="0 0 ${width} ${height}"
        role="group"
        aria-label=${t('parts.chart')}
        @pointerdown=${this.down}
        @pointermove=${this.move}
        @pointerup=${this.up}
        @pointercancel=${this.up}
        @wheel=${this.wheel}
      >
        ${this.view && width ? this.picture() : nothing}
      </svg>
      <div class="zoom">
        ${this.button('M12 5v14M5 12h14', t('parts.plan.zoom_in'), () => this.zoom(1.4))}
        ${this.button('M5 12h14', t('parts.plan.zoom_out'), () => this.zoom(1 / 1.4))}
        ${this.button('M4 8V4h4M16 4h4v4M20 16v4h-4M8 20H4v-4', t('parts.chart.fit'), () => this.fit())}
        ${this.button('M3 7h18v10H3zM12 7v10M3 12h18', t('parts.chart.whole'), () => this.fit(true))}
      </div>`;
  }

  private button(drawing: string, label: string, act: () => void): TemplateResult {
    return html`<button type="button" aria-label=${label} title=${label} @click=${act}>
      <svg viewBox="0 0 24 24" aria-hidden="true"><path d=${drawing}></path></svg>
    </button>`;
  }

  private picture(): unknown {
    return svg`<defs><pattern id="hatch" width="8" height="8" patternUnits="userSpaceOnUse"
        patternTransform="rotate(45)"><line class="hatch" y2="8"></line></pattern></defs>
      ${this.outside()} ${this.grid()} ${this.sector ? this.drawing(this.sector) : nothing}
      ${this.way()} ${this.mark()}`;
  }

  /** The area beyond the limits is hatched. */
  private outside(): unknown {
    const [width, height] = this.size;
    const { Horizontal: h, Vertical: v } = this.limits ?? {};
    const left = h ? this.x(h.max) : 0;
    const right = h ? this.x(h.min) : width;
    const top = v ? this.y(v.max) : 0;
    const bottom = v ? this.y(v.min) : height;
    const whole = `M0 0H${width}V${height}H0Z`;
    const inside = `M${left} ${top}V${bottom}H${right}V${top}Z`;
    return svg`<path class="beyond" fill-rule="evenodd" d="${whole}${inside}"></path>
      <path class="limits" d=${inside}></path>`;
  }

  private grid(): unknown {
    const [width, height] = this.size;
    const step = stepFor(70 / this.view!.scale);
    const lines: unknown[] = [];
    for (let h = Math.ceil(this.hAt(width) / step) * step; h <= this.hAt(0); h += step) {
      const x = this.x(h);
      lines.push(svg`<path class=${h === 0 ? 'axis' : 'grid'} d="M${x} 0V${height}"></path>`);
      if (x > 60 && x < width - 30) lines.push(svg`<text x=${x} y=${height - 8}>${short(h)}</text>`);
    }
    for (let v = Math.ceil(this.vAt(height) / step) * step; v <= this.vAt(0); v += step) {
      const y = this.y(v);
      lines.push(svg`<path class=${v === 0 ? 'axis' : 'grid'} d="M0 ${y}H${width}"></path>`);
      if (y > 20 && y < height - 30) lines.push(svg`<text class="side" x="8" y=${y - 5}>${short(v)}</text>`);
    }
    return lines;
  }

  private drawing(sector: Sector): unknown {
    const area = areaOf(sector);
    const [x, y] = [this.x(area.left), this.y(area.top)];
    const [wide, high] = [this.x(area.right) - x, this.y(area.bottom) - y];
    const from = this.barrel ?? { h: 0, v: 0 };
    const way = passOver(sector, this.limits, from);
    const path = way.map((at, n) => `${n ? 'L' : 'M'}${this.x(at.h)} ${this.y(at.v)}`).join('');
    const begin = way[0];
    return svg`<rect class="sector" data-what="move" x=${x} y=${y} width=${Math.max(wide, 0)}
        height=${Math.max(high, 0)}></rect>
      ${
        way.length > 1
          ? svg`<path class="way" d=${path}></path>${arrow(way.map((at) => [this.x(at.h), this.y(at.v)]))}`
          : nothing
      }
      ${begin ? svg`<circle class="begin" cx=${this.x(begin.h)} cy=${this.y(begin.v)} r="5"></circle>` : nothing}
      ${this.grip('move', sector.centre)}
      ${this.grip('left', { h: area.left, v: sector.centre.v })}
      ${this.grip('right', { h: area.right, v: sector.centre.v })}
      ${this.grip('top', { h: sector.centre.h, v: area.top })}
      ${this.grip('bottom', { h: sector.centre.h, v: area.bottom })}`;
  }

  private grip(grip: SectorGrip, at: Direction): unknown {
    const { width, height, centre } = this.sector!;
    // Grips of a narrow sector would overlap: they are moved apart.
    const away = 26;
    const [dx, dy] = [
      grip === 'left'
        ? -Math.max(0, away - (width / 2) * this.view!.scale)
        : grip === 'right'
          ? Math.max(0, away - (width / 2) * this.view!.scale)
          : 0,
      grip === 'top'
        ? -Math.max(0, away - (height / 2) * this.view!.scale)
        : grip === 'bottom'
          ? Math.max(0, away - (height / 2) * this.view!.scale)
          : 0,
    ];
    const text =
      grip === 'move'
        ? `${angleText(centre.h)}, ${angleText(centre.v)}`
        : angleText(grip === 'left' || grip === 'right' ? width : height);
    const now = grip === 'move' ? centre.h : grip === 'left' || grip === 'right' ? width : height;
    return svg`<g class="grip ${grip}" data-what=${grip} tabindex="0" role="slider"
      aria-label=${t(`parts.chart.${grip}`)} aria-valuetext=${text} aria-valuenow=${now}
      aria-valuemin=${-ANGLE_MOST} aria-valuemax=${ANGLE_MOST}
      transform="translate(${this.x(at.h) + dx} ${this.y(at.v) + dy})"
      @keydown=${(event: KeyboardEvent) => this.key(event, grip)}>
      <circle class="hit" r="24"></circle><circle class="knob" r=${grip === 'move' ? 9 : 7}></circle>
    </g>`;
  }

  /** The trajectory. */
  private way(): unknown {
    const { points } = this;
    if (!points.length) return nothing;
    const closed = this.repeat && points.length > 2 ? 'Z' : '';
    const path = points.map(({ h, v }, n) => `${n ? 'L' : 'M'}${this.x(h)} ${this.y(v)}`).join('');
    return svg`<path class="way route" d="${path}${closed}"></path>
      ${points.map((at, n) => {
        const bad = isInside(at, this.limits) ? '' : 'bad';
        return svg`<g class="point ${n === this.selected ? 'selected' : ''} ${bad}" data-what=${n}
          tabindex="0" role="slider" aria-label=${t('parts.chart.point', { n: n + 1 })}
          aria-valuetext="${angleText(at.h)}, ${angleText(at.v)}" aria-valuenow=${at.h}
          aria-valuemin=${-ANGLE_MOST} aria-valuemax=${ANGLE_MOST}
          transform="translate(${this.x(at.h)} ${this.y(at.v)})"
          @focus=${() => emit(this, 'point-select', { index: n, at })}
          @keydown=${(event: KeyboardEvent) => this.key(event, n)}>
          <circle class="hit" r="24"></circle><circle class="knob" r="13"></circle><text dy="4.5">${n + 1}</text>
        </g>`;
      })}`;
  }

  private mark(): unknown {
    if (!this.barrel) return nothing;
    const [x, y] = [this.x(this.barrel.h), this.y(this.barrel.v)];
    return svg`<g class="barrel ${this.stale ? 'stale' : ''}" transform="translate(${x} ${y})">
      <circle r="11"></circle><path d="M-18 0H-6M6 0H18M0 -18V-6M0 6V18"></path>
      <text y="-24">${t('parts.chart.barrel')}</text></g>`;
  }

  private x(h: number): number {
    return round(this.size[0] / 2 - (h - this.view!.h) * this.view!.scale);
  }

  private y(v: number): number {
    return round(this.size[1] / 2 - (v - this.view!.v) * this.view!.scale);
  }

  private hAt(x: number): number {
    return this.view!.h - (x - this.size[0] / 2) / this.view!.scale;
  }

  private vAt(y: number): number {
    return this.view!.v - (y - this.size[1] / 2) / this.view!.scale;
  }

  private fitted(whole = false): View {
    const shown: Direction[] = [...this.points];
    const { Horizontal: h, Vertical: v } = this.limits ?? {};
    if (this.sector) {
      const area = areaOf(this.sector);
      shown.push({ h: area.left, v: area.top }, { h: area.right, v: area.bottom });
    }
    if (this.barrel) shown.push(this.barrel);
    if (whole && h && v) shown.push({ h: h.min, v: v.min }, { h: h.max, v: v.max });
    if (!shown.length) shown.push({ h: 0, v: 0 });
    const [hs, vs] = [shown.map((at) => at.h), shown.map((at) => at.v)];
    const wide = Math.max(Math.max(...hs) - Math.min(...hs), 1200);
    const high = Math.max(Math.max(...vs) - Math.min(...vs), 600);
    const [width, height] = this.size;
    return {
      h: (Math.max(...hs) + Math.min(...hs)) / 2,
      v: (Math.max(...vs) + Math.min(...vs)) / 2,
      scale: Math.min(
        Math.max(width - 2 * MARGIN_PX - 30, 40) / wide,
        Math.max(height - 2 * MARGIN_PX - 20, 40) / high,
      ),
    };
  }

  private zoom(by: number): void {
    this.view = { ...this.view!, scale: Math.min(Math.max(this.view!.scale * by, 0.01), 4) };
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    this.zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)));
  }

  private down(event: PointerEvent): void {
    if (!this.view || event.button !== 0) return;
    const found = (event.target as Element).closest?.('[data-what]')?.getAttribute('data-what');
    const index = found && /^\d+$/.test(found) ? Number(found) : null;
    this.drag = {
      pointer: event.pointerId,
      what: index ?? (found as SectorGrip | undefined) ?? 'pan',
      from: [event.clientX, event.clientY],
      view: this.view,
      sector: this.sector,
      at: index === null ? null : (this.points[index] ?? null),
      far: false,
    };
    if (index !== null) emit(this, 'point-select', { index, at: this.points[index] });
    (event.currentTarget as Element).setPointerCapture(event.pointerId);
  }

  private move(event: PointerEvent): void {
    const { drag } = this;
    if (!drag || drag.pointer !== event.pointerId) return;
    const zoom = magnified();
    const [x, y] = [(event.clientX - drag.from[0]) / zoom, (event.clientY - drag.from[1]) / zoom];
    if (!drag.far && Math.hypot(x, y) < DRAG_LEAST_PX) return;
    drag.far = true;
    const by = { h: -x / drag.view.scale, v: -y / drag.view.scale };
    if (drag.what === 'pan') {
      this.view = { ...drag.view, h: drag.view.h - by.h, v: drag.view.v - by.v };
    } else this.shift(drag.what, drag.sector, drag.at, by, false);
  }

  private up(event: PointerEvent): void {
    const { drag } = this;
    if (!drag || drag.pointer !== event.pointerId) return;
    this.drag = null;
    if (!drag.far) {
      // A press that the system cancels, or that another button ends, adds nothing.
      const pressed = event.type === 'pointerup' && event.button === 0;
      if (pressed && drag.what === 'pan' && this.adding) this.add(event);
      return;
    }
    if (typeof drag.what === 'number') {
      emit<PointDetail>(this, 'point', { index: drag.what, at: this.points[drag.what]! });
    } else if (drag.what !== 'pan' && this.sector) emit<SectorDetail>(this, 'sector', this.sector);
  }

  private add(event: PointerEvent): void {
    const [x, y] = placeIn(this.getBoundingClientRect(), event);
    const at = { h: this.hAt(x), v: this.vAt(y) };
    emit<Direction>(this, 'point-add', whole(inLimits(at, this.limits)));
  }

  private shift(
    what: SectorGrip | number,
    sector: Sector | null,
    at: Direction | null,
    by: Direction,
    done: boolean,
  ): void {
    if (typeof what === 'number') {
      if (!at) return;
      const moved = whole({ h: at.h + by.h, v: at.v + by.v });
      emit<PointDetail>(this, done ? 'point' : 'point-change', { index: what, at: moved });
    } else if (sector) {
      emit<SectorDetail>(this, done ? 'sector' : 'sector-change', pulled(sector, what, by));
    }
  }

  private key(event: KeyboardEvent, what: SectorGrip | number): void {
    const by = event.shiftKey ? KEY_FAR_ARCMIN : KEY_ARCMIN;
    const ways: Record<string, Direction> = {
      ArrowLeft: { h: by, v: 0 },
      ArrowRight: { h: -by, v: 0 },
      ArrowUp: { h: 0, v: by },
      ArrowDown: { h: 0, v: -by },
    };
    const way = ways[event.key];
    if (way) this.shift(what, this.sector, typeof what === 'number' ? (this.points[what] ?? null) : null, way, true);
    else if (typeof what === 'number' && (event.key === 'Delete' || event.key === 'Backspace')) {
      emit(this, 'point-remove', { index: what, at: this.points[what] });
    } else return;
    event.preventDefault();
    event.stopPropagation();
  }
}

function round(value: number): number {
  return Math.round(value * 10) / 10;
}

/** Whole degrees need no tenths. */
function short(arcmin: number): string {
  return angleText(arcmin).replace(/[.,]0(?=°)/, '');
}

/** Distance of the lines of the grid, arc-minutes: 1, 5, 10, 15, 30, 45, 90 degrees. */
function stepFor(least: number): number {
  const steps = [60, 120, 300, 600, 900, 1800, 2700, 5400];
  return steps.find((step) => step >= least) ?? 10800;
}

/** An arrowhead in the middle of the first line. */
function arrow(points: number[][]): unknown {
  const [[x0, y0], [x1, y1]] = [points[0] as [number, number], points[1] as [number, number]];
  const angle = (Math.atan2(y1 - y0, x1 - x0) * 180) / Math.PI;
  return svg`<path class="arrow" d="M-7 -7L6 0L-7 7Z"
    transform="translate(${(x0 + x1) / 2} ${(y0 + y1) / 2}) rotate(${angle})"></path>`;
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-aim-chart': LfAimChart;
  }
}
