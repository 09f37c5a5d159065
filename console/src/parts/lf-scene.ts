import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { t } from '../i18n';
import { emit, partStyle } from './part-style';
import { landingLegend, legendStyle, schematicNote, unshown } from './plan/legend';
import type { PlanMonitor, PlanScene, PlanSite } from './plan/model';
import type { Palette } from './scene/particles';
import type { Colours } from './scene/structures';
import type { Preset, World } from './scene/world';
import { Words } from './words';

const PRESETS: readonly Preset[] = ['eye', 'orbit', 'side', 'top'];
/** A frame that comes later than this (a tab that slept) does not move things further. */
const FRAME_MAX_S = 0.1;

/**
 * The site in three dimensions. The drawing (three.js) is loaded when the element is first seen.
 * Event: `no-webgl`, when the browser cannot: show the plan instead.
 */
@customElement('lf-scene')
export class LfScene extends LitElement {
  @property({ attribute: false }) site: PlanSite | null = null;
  @property({ attribute: false }) monitors: readonly PlanMonitor[] = [];
  @property({ attribute: false }) scene: PlanScene | null = null;
  @property() selected: string = '';
  @property() preset: Preset = 'orbit';
  /** Nothing moves (a paused simulation or replay). */
  @property({ type: Boolean }) paused: boolean = false;
  @state() state: 'idle' | 'loading' | 'drawing' | 'unable' = 'idle';

  private world: World | null = null;
  private frame = 0;
  private last_ms = 0;
  private seen = false;
  private observers: { disconnect(): void }[] = [];

  constructor() {
    super();
    new Words(this);
  }

  static override styles = [
    partStyle,
    legendStyle,
    css`
      :host {
        display: block;
        position: relative;
        min-height: 160px;
        overflow: hidden;
        border-radius: var(--radius);
        background: var(--surface-2);
        contain: strict;
        container-type: inline-size;
      }
      canvas {
        position: absolute;
        inset: 0;
        width: 100%;
        height: 100%;
        touch-action: none;
        outline-offset: -3px;
        border-radius: inherit;
        cursor: grab;
      }
      canvas:active {
        cursor: grabbing;
      }
      canvas:focus-visible,
      button:focus-visible {
        outline: 3px solid var(--focus);
      }
      .views {
        position: absolute;
        left: 12px;
        bottom: 12px;
        max-width: calc(100% - 24px);
        display: flex;
        border: 1px solid var(--line);
        border-radius: var(--radius);
        overflow: hidden;
        background: var(--surface);
      }
      .views button {
        min-height: 48px;
        padding: 0 clamp(var(--s2), 3cqw, var(--s3));
        border: 0;
        background: none;
        color: var(--dim);
        font: inherit;
        font-size: var(--t-note);
        cursor: pointer;
        outline-offset: -3px;
      }
      .views button + button {
        border-left: 1px solid var(--line);
      }
      .views button:hover {
        background: var(--surface-2);
      }
      .views button[aria-pressed='true'] {
        background: var(--surface-2);
        color: var(--text);
        font-weight: 600;
      }
      .word {
        position: absolute;
        inset: 0;
        display: grid;
        place-items: center;
        padding: var(--s4);
        text-align: center;
        color: var(--dim);
        font-size: var(--t-normal);
        pointer-events: none;
      }
    `,
  ];

  /** Draw calls and particles of the last frame, for measurements. */
  get figures(): { calls: number; particles: number; share: number } | null {
    return this.world?.figures ?? null;
  }

  override connectedCallback(): void {
    super.connectedCallback();
    const size = new ResizeObserver(() => this.resized());
    size.observe(this);
    const view = new IntersectionObserver(([entry]) => {
      this.seen = entry!.isIntersecting;
      if (this.seen) void this.begin();
      this.run();
    });
    view.observe(this);
    const theme = new MutationObserver(() => this.again());
    theme.observe(document.documentElement, { attributeFilter: ['data-theme'] });
    this.observers = [size, view, theme];
    document.addEventListener('visibilitychange', this.run);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    for (const observer of this.observers) observer.disconnect();
    document.removeEventListener('visibilitychange', this.run);
    this.seen = false;
    this.end();
    if (this.state !== 'unable') this.state = 'idle';
  }

  protected override updated(changed: PropertyValues): void {
    if (changed.has('preset') && changed.get('preset') !== undefined) this.world?.look(this.preset);
    this.world?.show(this);
    if (changed.has('paused')) this.run();
  }

  protected override render(): TemplateResult {
    if (this.state === 'unable') return html`<p class="word">${t('parts.scene.no_webgl')}</p>`;
    const unplaced = this.site?.unplaced ?? [];
    return html`
      <canvas
        tabindex="0"
        role="application"
        aria-label=${t('parts.scene')}
        aria-describedby="keys"
        @keydown=${this.key}
        @webglcontextlost=${this.lost}
      ></canvas>
      <p class="unseen" id="keys">${t('parts.scene.keys')}</p>
      ${this.state === 'drawing' ? nothing : html`<p class="word">${t('parts.scene.loading')}</p>`}
      <div class="notes" role="status">
        ${schematicNote(this.site)} ${landingLegend(this.chosen?.landing)}
        ${unplaced.length ? html`<p class="landing-legend">${t('parts.plan.unplaced')} ${unplaced.join(', ')}</p>` : nothing}
        ${unshown(this.monitors, this.scene).map((text) => html`<p class="landing-legend unshown">${text}</p>`)}
      </div>
      <div class="views" role="group" aria-label=${t('parts.scene.view')}>
        ${PRESETS.map(
          (preset) => html`<button
            type="button"
            aria-pressed=${preset === this.preset}
            @click=${() => this.choose(preset)}
          >
            ${t(`parts.scene.${preset}`)}
          </button>`,
        )}
      </div>
    `;
  }

  private get chosen(): PlanMonitor | undefined {
    const { monitors } = this;
    return monitors.find(({ id }) => id === this.selected) ?? (monitors.length === 1 ? monitors[0] : undefined);
  }

  private choose(preset: Preset): void {
    if (preset === this.preset) this.world?.look(preset);
    this.preset = preset;
  }

  private async begin(): Promise<void> {
    if (this.world || this.state === 'loading' || this.state === 'unable') return;
    if (!able()) {
      this.unable();
      return;
    }
    this.state = 'loading';
    await this.updateComplete;
    try {
      const { World } = await import('./scene/world');
      const canvas = this.renderRoot.querySelector('canvas');
      if (!this.isConnected || !canvas) {
        this.state = 'idle';
        return;
      }
      const still = matchMedia('(prefers-reduced-motion: reduce)').matches;
      const [colours, palette, dark] = this.looks();
      this.world = new World(canvas, colours, palette, still, dark);
    } catch {
      this.unable();
      return;
    }
    this.state = 'drawing';
    this.resized();
    this.world.show(this);
    this.world.look(this.preset, true);
    this.run();
  }

  private end(): void {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    this.world?.dispose();
    this.world = null;
  }

  /** A new theme: everything is created again, on a new canvas, because the old context is lost. */
  private again(): void {
    if (!this.world) return;
    this.end();
    const canvas = this.renderRoot.querySelector('canvas')!;
    const fresh = canvas.cloneNode() as HTMLCanvasElement;
    fresh.addEventListener('keydown', this.key);
    fresh.addEventListener('webglcontextlost', this.lost);
    canvas.replaceWith(fresh);
    this.state = 'idle';
    if (this.seen) void this.begin();
  }

  private unable(): void {
    this.end();
    this.state = 'unable';
    emit(this, 'no-webgl');
  }

  private readonly lost = (event: Event): void => {
    event.preventDefault();
    if (this.world) this.unable();
  };

  private resized(): void {
    if (this.clientWidth) this.world?.resize(this.clientWidth, this.clientHeight);
  }

  /** Frames are drawn only while they are visible. */
  private readonly run = (): void => {
    const wanted = this.seen && this.world && document.visibilityState === 'visible';
    if (!wanted) {
      cancelAnimationFrame(this.frame);
      this.frame = 0;
      return;
    }
    if (this.frame) return;
    this.last_ms = performance.now();
    const step = (now: number): void => {
      const seconds = Math.min(Math.max((now - this.last_ms) / 1000, 0), FRAME_MAX_S);
      this.last_ms = now;
      this.world?.frame(this.paused ? 0 : seconds);
      this.frame = requestAnimationFrame(step);
    };
    this.frame = requestAnimationFrame(step);
  };

  private readonly key = (event: KeyboardEvent): void => {
    if (!this.world || event.ctrlKey || event.altKey || event.metaKey) return;
    const turns: Record<string, [number, number, number]> = {
      ArrowLeft: [-8, 0, 1],
      ArrowRight: [8, 0, 1],
      ArrowUp: [0, 6, 1],
      ArrowDown: [0, -6, 1],
      '+': [0, 0, 0.85],
      '=': [0, 0, 0.85],
      '-': [0, 0, 1.18],
    };
    const turn = turns[event.key];
    const preset = PRESETS[Number(event.key) - 1];
    if (turn) this.world.turn(...turn);
    else if (preset) this.choose(preset);
    else return;
    event.preventDefault();
    event.stopPropagation();
  };

  private looks(): [Colours, Palette, boolean] {
    const style = getComputedStyle(this);
    const of = (name: string): string => style.getPropertyValue(`--${name}`).trim();
    const dark = document.documentElement.dataset.theme === 'night';
    const colours: Colours = {
      sky: of('scene-sky'),
      ground: of('scene-ground'),
      grid: of('scene-grid'),
      shell: of('scene-shell'),
      roof: of('scene-roof'),
      wall: of('scene-wall'),
      steel: of('scene-steel'),
      dark: of('scene-dark'),
      accent: of('accent'),
      high: of('high'),
      water: of('water'),
      text: of('text'),
      surface: of('surface'),
      line: of('line-strong'),
      quiet: of('scene-quiet'),
    };
    const palette: Palette = {
      water: dark ? [0.5, 0.74, 0.96] : [0.24, 0.53, 0.85],
      foam: dark ? [0.9, 0.9, 0.86] : [0.98, 0.98, 0.95],
      smoke: dark ? [0.13, 0.13, 0.14] : [0.2, 0.2, 0.21],
      flame: dark ? [1, 0.74, 0.28] : [1, 0.66, 0.14],
      ember: dark ? [0.92, 0.24, 0.05] : [0.88, 0.22, 0.03],
      shine: dark ? 0.35 : 0.85,
    };
    return [colours, palette, dark];
  }
}

function able(): boolean {
  try {
    const gl = document.createElement('canvas').getContext('webgl2');
    gl?.getExtension('WEBGL_lose_context')?.loseContext();
    return gl !== null;
  } catch {
    return false;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-scene': LfScene;
  }
}
