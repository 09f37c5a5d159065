import { html, LitElement, nothing, type PropertyValues, svg, type TemplateResult } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import type { FirePlace } from '../hub/api';
import { t } from '../i18n';
import { placeIn } from '../theme/display';
import {
  bearingOf,
  bearingTo,
  boundsOf,
  distanceTo,
  groundAt,
  horizontalOf,
  type Place,
  placeAt,
  type QuenchSector,
  quenchSector,
  type Sector,
  sectorMiddle,
  sightOf,
  toScreen,
  toSite,
  type View,
  viewOf,
  zoomed,
} from './geometry';
import { emit, partStyle } from './part-style';
import * as layers from './plan/layers';
import { landingLegend, landingText, legendStyle, schematicNote } from './plan/legend';
import { fireTitle, foundFires, type PlanMonitor, type PlanScene, type PlanSite, shownPlaces } from './plan/model';
import { planStyle } from './plan/plan-style';
import { dragged, drawnSector, GRIPS, type Grip, gripAt, keyed, tidy, usualSector } from './plan/sector-tool';
import { bearingText, lengthText, openingText, Words } from './words';

export { built, jetAsked, type PlanMonitor, type PlanScene, type PlanSite, planMonitor } from './plan/model';

/** What `aim` says: where the operator pointed. */
export interface AimDetail {
  monitor: string;
  at: Place;
  bearing: number;
  distance_m: number;
  horizontal_arcmin: number;
  /** Line of sight, without regard to the fall of the jet. */
  sight_arcmin: number;
  /** Height of the place above the nozzle: the roof of a tank, else the ground. */
  rise_m: number;
}

interface Drag {
  kind: 'pan' | 'draw' | 'point' | Grip;
  /** Of the mouse; 0 is also a finger or a pen. */
  button: number;
  /** Of the point that is dragged. */
  index: number;
  pointer: number;
  from: Place;
  view: View;
  began: Place;
  far: boolean;
}

const MARGIN_PX = 56;
const MARGIN_MINI_PX = 26;
/** Space that the buttons take on the right. */
const ZOOM_PX = 64;
const DRAG_LEAST_PX = 6;
const SPLASHES_MAX = 60;

/** What `point` says: a point of the trajectory was dragged there; `point-change` meanwhile. */
export interface PlanPointDetail extends AimDetail {
  index: number;
}

/**
 * Plan of the site, north up.
 *
 * Events: `select` {id}; `sector` QuenchSector when a drawing is finished, `sector-change` while it
 * goes on, null when it was taken away; `aim` AimDetail.
 */
@customElement('lf-plan')
export class LfPlan extends LitElement {
  @property({ attribute: false }) site: PlanSite | null = null;
  @property({ attribute: false }) monitors: readonly PlanMonitor[] = [];
  @property({ attribute: false }) scene: PlanScene | null = null;
  @property() selected: string = '';
  /** Where the zone controller has found fires, or what may be ghosts of them. */
  @property({ attribute: false }) located: readonly FirePlace[] = [];
  @property({ reflect: true }) mode: 'full' | 'mini' = 'full';
  @property({ reflect: true }) tool: 'look' | 'sector' | 'aim' = 'look';
  /** The drawing; the page may set it. */
  @property({ attribute: false }) sector: Sector | null = null;
  /** The sector of a running program, by monitor. */
  @property({ attribute: false }) running: Readonly<Record<string, Sector>> = {};
  /** Places of a trajectory. */
  @property({ attribute: false }) points: readonly Place[] = [];
  @property({ type: Number, attribute: 'point-selected' }) pointSelected: number = -1;
  /** Shown instead of the plan's own hint. */
  @property() note: string = '';
  /** Number of pixels at the upper edge that buttons of the page cover. */
  @property({ type: Number }) above: number = 0;
  /** Number of pixels below them that notes may cover. */
  @property({ type: Number }) notes: number = 0;
  @state() view: View | null = null;
  @state() size: Place = [0, 0];
  @state() drag: Drag | null = null;

  private touched = false;
  private drops: layers.Drop[] = [];
  private seen: PlanScene | null = null;
  private pinch = new Map<number, Place>();
  private observer?: ResizeObserver;

  constructor() {
    super();
    new Words(this);
  }

  static override styles = [partStyle, planStyle, legendStyle];

  override connectedCallback(): void {
    super.connectedCallback();
    this.observer = new ResizeObserver(([entry]) => {
      const box = entry!.contentRect;
      if (box.width !== this.size[0] || box.height !== this.size[1]) {
        this.size = [Math.round(box.width), Math.round(box.height)];
      }
    });
    this.observer.observe(this);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.observer?.disconnect();
  }

  protected override willUpdate(changed: PropertyValues): void {
    if (changed.has('scene') && this.scene !== this.seen) this.keepDrops();
    const moved = changed.has('site') || changed.has('size') || changed.has('mode');
    const gone =
      !this.touched && (changed.has('scene') || changed.has('monitors') || changed.has('located')) && this.isBeyond();
    if (this.size[0] && (!this.view || (moved && !this.touched) || gone)) this.view = this.whole();
    this.toggleAttribute('listed', this.mode === 'full' && Boolean(this.site?.unplaced?.length));
    if (changed.has('tool') && this.tool === 'look') this.drag = null;
  }

  /** Shows everything again. */
  fit(): void {
    this.touched = false;
    this.view = this.whole();
  }

  /** A fire is outside of the picture, which shows everything else. */
  private isBeyond(): boolean {
    const { view } = this;
    const [width, height] = this.size;
    if (!view) return false;
    return shownPlaces(this.site, this.scene, this.monitors, this.located).some(([at]) => {
      const [x, y] = toScreen(view, width, height, at);
      return x < 0 || x > width || y < this.above + this.notes || y > height;
    });
  }

  private whole(): View {
    const known = this.site ?? siteOf(this.monitors);
    const [width, height] = this.size;
    const margin = this.mode === 'mini' ? MARGIN_MINI_PX : MARGIN_PX;
    const box = boundsOf(shownPlaces(known, this.scene, this.monitors, this.located));
    // Nothing at the edge may be covered by the buttons.
    const aside = this.mode === 'full' && width > ZOOM_PX * 4 ? ZOOM_PX : 0;
    const above = this.above + this.notes;
    const view = viewOf(box, width - aside, height - above, margin);
    const { scale } = view;
    return { scale, east: view.east + aside / 2 / scale, north: view.north + above / 2 / scale };
  }

  private keepDrops(): void {
    const backwards = this.scene && this.seen && this.scene.t_s < this.seen.t_s;
    if (!this.scene || backwards) this.drops = [];
    this.seen = this.scene;
    const now = performance.now();
    const fresh = (this.scene?.splashes ?? []).map(({ at, litres, foam }) => ({
      at,
      litres,
      foam: foam > 0,
      born_ms: now,
    }));
    this.drops = [...this.drops, ...fresh]
      .filter(({ born_ms }) => now - born_ms < layers.DROP_LIFE_MS)
      .slice(-SPLASHES_MAX);
  }

  private get chosen(): PlanMonitor | undefined {
    return this.monitors.find(({ id }) => id === this.selected) ?? this.only;
  }

  private get only(): PlanMonitor | undefined {
    return this.monitors.length === 1 ? this.monitors[0] : undefined;
  }

  /** The numbers of the drawing, for the request. */
  get quench(): QuenchSector | null {
    const stand = this.chosen;
    if (!stand || !this.sector) return null;
    return quenchSector(stand, this.sector, this.site?.tanks ?? [], stand.limits);
  }

  protected override render(): TemplateResult {
    const mini = this.mode === 'mini';
    const [width, height] = this.size;
    const canvas = this.view && width ? this.picture(mini) : nothing;
    if (mini) {
      return html`<svg viewBox="0 0 ${width} ${height}" role="img" aria-label=${this.summary()}>
        ${canvas}
      </svg>`;
    }
    return html`
      <svg
        viewBox="0 0 ${width} ${height}"
        tabindex="0"
        role="application"
        aria-label=${t('parts.plan')}
        aria-describedby="keys summary"
        @pointerdown=${this.down}
        @pointermove=${this.move}
        @pointerup=${this.up}
        @pointercancel=${this.cancel}
        @lostpointercapture=${this.cancel}
        @wheel=${this.wheel}
        @keydown=${this.key}
      >
        ${canvas}
      </svg>
      <p class="unseen" id="keys">
        ${t('parts.plan.keys')} ${this.tool === 'sector' ? t('parts.plan.keys_sector') : ''}
      </p>
      <p class="unseen" id="summary">${this.summary()}</p>
      <div class="notes">${schematicNote(this.site)} ${this.hint()} ${landingLegend(this.chosen?.landing)}</div>
      <div class="zoom" part="zoom">
        ${this.button('+', t('parts.plan.zoom_in'), () => this.zoom(1.4))}
        ${this.button('−', t('parts.plan.zoom_out'), () => this.zoom(1 / 1.4))}
        ${this.button('fit', t('parts.plan.fit'), () => this.fit())}
      </div>
      ${this.unplaced()}
    `;
  }

  /** Below the plan: they are nowhere on it. */
  private unplaced(): TemplateResult | typeof nothing {
    const ids = this.site?.unplaced ?? [];
    if (!ids.length) return nothing;
    return html`<div class="unplaced" role="group" aria-label=${t('parts.plan.unplaced')}>
      <span>${t('parts.plan.unplaced')}</span>
      ${ids.map((id) => html`<button type="button" @click=${() => emit(this, 'select', { id })}>${id}</button>`)}
    </div>`;
  }

  private button(sign: string, label: string, act: () => void): TemplateResult {
    const drawing =
      sign === 'fit' ? 'M4 8V4h4M16 4h4v4M20 16v4h-4M8 20H4v-4' : sign === '+' ? 'M12 5v14M5 12h14' : 'M5 12h14';
    return html`<button type="button" aria-label=${label} title=${label} @click=${act}>
      <svg viewBox="0 0 24 24" aria-hidden="true"><path d=${drawing}></path></svg>
    </button>`;
  }

  private hint(): TemplateResult | typeof nothing {
    if (this.note) return html`<p class="hint">${this.note}</p>`;
    if (!this.site) return html`<p class="hint">${t('parts.plan.no_site')}</p>`;
    if (this.tool === 'aim') return html`<p class="hint">${t('parts.plan.aim')}</p>`;
    if (this.tool === 'sector' && !this.sector) {
      return html`<p class="hint">${t('parts.plan.draw')}</p>`;
    }
    return nothing;
  }

  private picture(mini: boolean): unknown {
    const camera: layers.Camera = {
      view: this.view!,
      width: this.size[0],
      height: this.size[1],
      mini,
      above: this.above,
    };
    const names = layers.namesOf(camera, this.monitors);
    const chosen = this.chosen;
    const schematic = this.site?.schematic;
    return svg`
      ${
        mini
          ? nothing
          : svg`<defs><pattern id="hatch" width="8" height="8" patternUnits="userSpaceOnUse"
        patternTransform="rotate(45)"><line class="hatch" y2="8"></line></pattern></defs>${schematic ? nothing : layers.grid(camera)}`
      }
      ${!mini && chosen ? layers.ranges(camera, chosen) : nothing}
      ${!mini && chosen && this.site ? layers.keepOuts(camera, this.site, chosen) : nothing}
      ${this.site ? layers.structures(camera, this.site) : nothing}
      ${!mini && chosen ? layers.rangeNames(camera, chosen, lengthText, (d) => t('parts.plan.reach', { d }), layers.taken(camera, this.site, this.monitors, names)) : nothing}
      ${layers.drops(camera, this.drops, performance.now())}
      ${this.scene ? layers.fires(camera, this.scene) : layers.found(camera, foundFires(this.monitors))}
      ${layers.located(camera, this.located)}
      ${mini ? nothing : this.monitors.map((m) => this.runningOf(camera, m))}
      ${!mini && chosen ? layers.landingArea(camera, chosen) : nothing}
      ${layers.jets(camera, this.monitors)}
      ${this.site ? layers.tankNames(camera, this.site, this.burning()) : nothing}
      ${mini ? nothing : this.monitors.filter((m) => m.id === chosen?.id).map((m) => layers.aims(camera, m))}
      ${mini ? nothing : this.monitors.map((m) => layers.hotbeds(camera, m))}
      ${layers.monitorMarks(camera, this.monitors, this.selected, names)}
      ${mini ? nothing : layers.route(camera, this.points, this.pointSelected, (n) => t('parts.plan.point', { n }))}
      ${!mini && chosen ? this.drawing(camera, chosen) : nothing}
      ${mini || schematic ? nothing : layers.scaleBar(camera, lengthText)}
      ${mini || schematic ? nothing : layers.compassMark(camera, t('parts.plan.north'), this.scene, (v, short) => t(short ? 'parts.plan.wind_short' : 'parts.plan.wind', { v }), t('parts.plan.no_wind'))}
    `;
  }

  /** The fires that are shown: those that burn, or without a simulation those that detectors have found. */
  private burning(): { at: Place; size: number }[] {
    if (this.scene) return this.scene.fires.filter(({ burns }) => burns);
    return foundFires(this.monitors).map(({ at }) => ({ at, size: 0 }));
  }

  private runningOf(camera: layers.Camera, monitor: PlanMonitor): unknown {
    const sector = this.running[monitor.id];
    return sector ? layers.sectorShape(camera, monitor, sector, 'running') : nothing;
  }

  private drawing(camera: layers.Camera, monitor: PlanMonitor): unknown {
    const { sector } = this;
    if (!sector) return nothing;
    const quench = this.quench!;
    const far = monitor.reach_m ? sectorMiddle(sector) > monitor.reach_m : false;
    const bad = quench.clipped || far;
    const on = (at: Place): Place => toScreen(camera.view, camera.width, camera.height, at);
    const edges = GRIPS.map((grip) => on(gripAt(monitor.at, sector, grip)));
    const x = edges[0]![0];
    const high_y = Math.min(...edges.map(([, y]) => y));
    const low_y = Math.max(...edges.map(([, y]) => y));
    const lines = [
      `${bearingText(sector.bearing)} · ${lengthText(quench.distance_m)}`,
      `↔ ${openingText(sector.width)} · ↕ ${lengthText(Math.round(sector.far_m - sector.near_m))}`,
    ];
    if (far) lines.push(t('parts.plan.too_far'));
    else if (quench.clipped) lines.push(t('parts.plan.out_of_limits'));
    const wide = Math.max(...lines.map((line) => line.length)) * 7.2 + 20;
    const high = lines.length * 17 + 10;
    const left = Math.min(Math.max(x - wide / 2, 8), camera.width - wide - 8);
    const above = high_y - high - 18;
    const top = above < 8 ? low_y + 18 : above;
    return svg`${layers.sectorShape(camera, monitor, sector, bad ? 'drawn bad' : 'drawn')}
      ${this.tool === 'sector' ? GRIPS.map((grip) => this.grip(camera, monitor, sector, grip)) : nothing}
      <g class="sector-label ${bad ? 'bad' : ''}" transform="translate(${left} ${top})">
        <rect width=${wide} height=${high} rx="6"></rect>
        ${lines.map((line, index) => svg`<text x="10" y=${19 + index * 17}>${line}</text>`)}
      </g>`;
  }

  private grip(camera: layers.Camera, monitor: PlanMonitor, sector: Sector, grip: Grip): unknown {
    const at = gripAt(monitor.at, sector, grip);
    const [x, y] = toScreen(camera.view, camera.width, camera.height, at);
    const text = t('parts.sector.value', {
      b: bearingText(sector.bearing),
      d: lengthText(Math.round(sectorMiddle(sector) * 10) / 10),
      w: openingText(sector.width),
    });
    const value =
      grip === 'near' || grip === 'far' ? sector[`${grip}_m`] : grip === 'move' ? sector.bearing : sector.width;
    return svg`<g class="grip ${grip}" data-grip=${grip} tabindex="0" role="slider"
      aria-label=${t(`parts.sector.${grip}`)} aria-valuetext=${text} aria-valuenow=${Math.round(value)}
      aria-valuemin="0" aria-valuemax=${grip === 'move' ? 360 : 350}
      transform="translate(${x.toFixed(1)} ${y.toFixed(1)})"
      @keydown=${(event: KeyboardEvent) => this.gripKey(event, grip)}>
      <circle class="hit" r="24"></circle><circle class="knob" r=${grip === 'move' ? 9 : 7}></circle>
    </g>`;
  }

  private summary(): string {
    const monitors = this.monitors.map((monitor) => {
      const { id } = monitor;
      const b = bearingText(bearingOf(monitor.heading, monitor.horizontal_arcmin ?? 0));
      const parts = [
        monitor.horizontal_arcmin === null
          ? t('parts.plan.monitor_unknown', { id })
          : t('parts.plan.monitor', { id, b }),
      ];
      if (monitor.stale) parts.push(t('parts.plan.stale'));
      if (monitor.wrapped) parts.push(t('parts.plan.wrapped'));
      if (monitor.water) parts.push(t(monitor.foam ? 'parts.plan.foam' : 'parts.plan.water'));
      const { landing } = monitor;
      if (landing && typeof landing !== 'string') parts.push(landingText(landing));
      return parts.join(', ');
    });
    const burning = (this.scene?.fires ?? []).filter(({ burns }) => burns);
    const found = this.scene ? [] : foundFires(this.monitors);
    return [
      ...monitors,
      ...burning.map(({ name }) =>
        t('parts.plan.fire', { name: fireTitle(name, this.scene?.fires ?? [], this.site?.tanks ?? []) }),
      ),
      ...this.located.map(({ zone, standing }) => t(`parts.plan.located_${standing}`, { zone })),
      ...found.map(({ seen_by }) => t('parts.plan.found', { monitors: seen_by.join(', ') })),
    ].join('; ');
  }

  // Pointer.

  private point(event: PointerEvent | WheelEvent): Place {
    return placeIn(this.renderRoot.querySelector('svg')!.getBoundingClientRect(), event);
  }

  private siteAt(point: Place): Place {
    return toSite(this.view!, this.size[0], this.size[1], point);
  }

  private down(event: PointerEvent): void {
    if (!this.view || event.button > 1) return;
    const from = this.point(event);
    // All others are up, whatever was heard of them.
    if (event.isPrimary) this.pinch.clear();
    this.pinch.set(event.pointerId, from);
    (event.currentTarget as Element).setPointerCapture(event.pointerId);
    if (this.pinch.size > 1) {
      this.drag = null;
      return;
    }
    // The middle button moves the plan, and nothing on it.
    const on = event.button === 0 ? (event.target as Element) : null;
    const grip = on?.closest?.('[data-grip]')?.getAttribute('data-grip');
    const draws = this.tool === 'sector' && this.chosen && on;
    const point = on?.closest?.('[data-point]')?.getAttribute('data-point');
    const kind = grip ? (grip as Grip) : point ? 'point' : draws ? 'draw' : 'pan';
    if (point) emit(this, 'point-select', { index: Number(point) });
    this.drag = {
      kind,
      button: event.button,
      index: Number(point ?? -1),
      pointer: event.pointerId,
      from,
      view: this.view,
      began: this.siteAt(from),
      far: false,
    };
    if (!grip) (event.currentTarget as SVGElement).focus({ preventScroll: true });
    else event.preventDefault();
  }

  private move(event: PointerEvent): void {
    const at = this.point(event);
    const before = this.pinch.get(event.pointerId);
    if (this.pinch.size > 1 && before && this.view) {
      this.pinched(event.pointerId, before, at);
      return;
    }
    if (before) this.pinch.set(event.pointerId, at);
    const { drag } = this;
    if (!drag || drag.pointer !== event.pointerId) return;
    const [right, down] = [at[0] - drag.from[0], at[1] - drag.from[1]];
    if (!drag.far && Math.hypot(right, down) < DRAG_LEAST_PX) return;
    drag.far = true;
    const stand = this.chosen;
    if (drag.kind === 'pan') {
      this.touched = true;
      const { view } = drag;
      this.view = { ...view, east: view.east - right / view.scale, north: view.north + down / view.scale };
    } else if (stand && drag.kind === 'point') {
      const detail = { ...this.aimAt(stand, this.siteAt(at)), index: drag.index };
      emit<PlanPointDetail>(this, 'point-change', detail);
    } else if (stand && drag.kind === 'draw') {
      this.draw(tidy(drawnSector(stand.at, drag.began, this.siteAt(at))), false);
    } else if (stand && this.sector && drag.kind !== 'draw' && drag.kind !== 'point') {
      this.draw(tidy(dragged(stand.at, this.sector, drag.kind, this.siteAt(at))), false);
    }
  }

  private pinched(id: number, before: Place, at: Place): void {
    const other = [...this.pinch].find(([pointer]) => pointer !== id)?.[1];
    this.pinch.set(id, at);
    if (!other) return;
    const by =
      Math.hypot(at[0] - other[0], at[1] - other[1]) /
      Math.max(Math.hypot(before[0] - other[0], before[1] - other[1]), 1);
    this.touched = true;
    const middle: Place = [(at[0] + other[0]) / 2, (at[1] + other[1]) / 2];
    this.view = zoomed(this.view!, this.size[0], this.size[1], middle, by);
  }

  private up(event: PointerEvent): void {
    const { drag } = this;
    this.pinch.delete(event.pointerId);
    if (!drag || drag.pointer !== event.pointerId) return;
    this.drag = null;
    if (drag.far) {
      if (drag.kind !== 'pan' && drag.kind !== 'point') this.draw(this.sector, true);
      return;
    }
    // While several buttons are down, only the first press and the last release are reported.
    if (drag.button !== 0 || event.button !== 0) return;
    if (drag.kind === 'pan' || drag.kind === 'draw') this.clicked(event, drag);
  }

  private clicked(event: PointerEvent, drag: Drag): void {
    const hit =
      this.renderRoot instanceof ShadowRoot
        ? this.renderRoot.elementFromPoint(event.clientX, event.clientY)?.closest('[data-id]')
        : null;
    const id = hit?.getAttribute('data-id');
    if (id && this.tool === 'look') {
      emit(this, 'select', { id });
      return;
    }
    const stand = this.chosen;
    if (!stand) return;
    if (drag.kind === 'draw') this.draw(usualSector(stand.at, drag.began), true);
    else if (this.tool === 'aim') emit(this, 'aim', this.aimAt(stand, drag.began));
  }

  private aimAt(stand: PlanMonitor, at: Place): AimDetail {
    const bearing = bearingTo(stand.at, at);
    const distance_m = distanceTo(stand.at, at);
    const rise_m = groundAt(at, this.site?.tanks ?? []) - stand.height;
    return {
      monitor: stand.id,
      at,
      bearing,
      distance_m,
      horizontal_arcmin: horizontalOf(stand.heading, bearing, stand.limits?.Horizontal),
      sight_arcmin: sightOf(rise_m, distance_m),
      rise_m,
    };
  }

  private cancel(event: PointerEvent): void {
    this.pinch.delete(event.pointerId);
    if (this.drag?.pointer !== event.pointerId) return;
    const drew = this.drag.far && this.drag.kind !== 'pan' && this.drag.kind !== 'point';
    this.drag = null;
    if (drew) this.draw(this.sector, true);
  }

  private draw(sector: Sector | null, done: boolean): void {
    this.sector = sector;
    emit(this, done ? 'sector' : 'sector-change', this.quench);
  }

  private wheel(event: WheelEvent): void {
    if (!this.view) return;
    event.preventDefault();
    this.touched = true;
    const by = Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015));
    this.view = zoomed(this.view, this.size[0], this.size[1], this.point(event), by);
  }

  private zoom(by: number): void {
    this.touched = true;
    const [width, height] = this.size;
    this.view = zoomed(this.view!, width, height, [width / 2, height / 2], by);
  }

  // Keyboard.

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.altKey || event.metaKey || !this.view) return;
    const stand = this.chosen;
    const step = 48 / this.view.scale;
    const moves: Record<string, Place> = {
      ArrowLeft: [-step, 0],
      ArrowRight: [step, 0],
      ArrowUp: [0, step],
      ArrowDown: [0, -step],
    };
    const way = moves[event.key];
    if (way) {
      this.touched = true;
      this.view = { ...this.view, east: this.view.east + way[0], north: this.view.north + way[1] };
    } else if (event.key === '+' || event.key === '=') this.zoom(1.25);
    else if (event.key === '-') this.zoom(0.8);
    else if (event.key === '0') this.fit();
    else if (event.key === 'Enter' && stand && this.tool !== 'look') this.placeByKey(stand);
    else if ((event.key === 'Delete' || event.key === 'Backspace') && this.sector) this.draw(null, true);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  private placeByKey(stand: PlanMonitor): void {
    const bearing = bearingOf(stand.heading, stand.horizontal_arcmin ?? 0);
    const at = placeAt(stand.at, bearing, Math.min(stand.reach_m ?? 30, 28));
    if (this.tool === 'aim') {
      emit(this, 'aim', this.aimAt(stand, [this.view!.east, this.view!.north]));
    } else if (!this.sector) {
      this.draw(usualSector(stand.at, at), true);
    }
  }

  private gripKey(event: KeyboardEvent, grip: Grip): void {
    if (!this.sector) return;
    const next = keyed(this.sector, grip, event.key, event.shiftKey);
    if (!next) return;
    event.preventDefault();
    event.stopPropagation();
    this.draw(tidy(next), true);
  }
}

/** Without a description of the site each monitor is alone in its own plan. */
function siteOf(monitors: readonly PlanMonitor[]): PlanSite {
  return {
    monitors: Object.fromEntries(monitors.map((monitor) => [monitor.id, monitor])),
    tanks: [],
    walls: [],
    keep_outs: [],
  };
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-plan': LfPlan;
  }
}
