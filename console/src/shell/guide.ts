// The first minute: leads a newcomer of the demo through taking control, moving, opening,
// extinguishing, the automatic way, and a lost link. Each step ends when the monitor says so.
import { LitElement, css, html, nothing } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { validOf } from '../hub/readings';
import { has, inControl } from '../hub/session';
import { socket } from '../hub/socket';
import { SECOND, store, TopicController } from '../hub/store';
import { t, type Key } from '../i18n';
import { icon } from '../parts/icons';
import { styled } from '../parts/styled';
import { magnified } from '../theme/display';
import { base } from '../theme/shared';
import { show } from '../units';
import { GUIDE_KEY, guideWanted } from './guide-key';
import { router } from './router';

interface Step {
  name: 'welcome' | 'control' | 'deploy' | 'move' | 'open' | 'fire' | 'auto' | 'link' | 'end';
  /** What to look at. */
  at?: string[];
  done?: () => boolean;
}

const MONITOR = 'M1';
const MOVED_ARCMIN = 180;
const HEAT_LEFT = 0.6;
const BREAK_MS = 6000;
const MARGIN_PX = 6;
/** Bottom left, unless something is there that must be seen. */
const CORNERS = ['', 'right', 'top', 'top right'] as const;
type Corner = (typeof CORNERS)[number];

@customElement('lf-guide')
export class LfGuide extends LitElement {
  static override styles = [
    base,
    css`
      .card {
        position: fixed;
        left: calc(var(--nav-now, 0px) + var(--s3));
        bottom: var(--s3);
        width: min(420px, calc(100vw / var(--zoom, 1) - 32px));
        z-index: 44;
        display: grid;
        gap: 12px;
        padding: 18px 20px;
        border-radius: 12px;
        border: 1px solid var(--accent);
        background: var(--surface);
        box-shadow: var(--shadow-large);
      }
      .card.right {
        left: auto;
        right: var(--s3);
      }
      .card.top {
        bottom: auto;
        top: calc(var(--topbar) + 56px + var(--s3));
      }
      header {
        display: flex;
        align-items: center;
        gap: var(--s2);
        min-height: 32px;
        --lf-button-size: 13px;
      }
      header span {
        flex: 1;
        font-size: 12px;
        font-weight: 600;
        color: var(--dim);
      }
      h2 {
        font-size: 19px;
        letter-spacing: -0.01em;
      }
      p {
        font-size: 15px;
        line-height: 1.5;
      }
      .dots {
        display: flex;
        gap: 5px;
      }
      .dots i {
        width: 100%;
        height: 4px;
        border-radius: 2px;
        background: var(--line);
      }
      .dots .past {
        background: var(--accent);
      }
      footer {
        display: flex;
        align-items: center;
        gap: var(--s2);
      }
      .done {
        display: flex;
        align-items: center;
        gap: 6px;
        font-weight: 650;
        color: var(--accent);
      }
      .ring {
        position: fixed;
        z-index: 43;
        pointer-events: none;
        border: 3px solid var(--accent);
        border-radius: 10px;
        box-shadow: 0 0 0 4px color-mix(in srgb, var(--accent) 30%, transparent);
        animation: pulse 1.6s ease-in-out infinite;
      }
      @keyframes pulse {
        50% {
          box-shadow: 0 0 0 9px color-mix(in srgb, var(--accent) 12%, transparent);
        }
      }
      @media (prefers-reduced-motion: reduce) {
        .ring {
          animation: none;
        }
      }
      @media (max-width: 720px) {
        .card,
        .card.right {
          left: 16px;
          right: auto;
          padding: 12px 14px;
        }
        .card:not(.top) {
          bottom: 84px;
        }
      }
    `,
  ];

  @state() private at = 0;
  @state() private ring: DOMRect | null = null;
  /** The corner where it covers nothing that the step speaks of. */
  @state() private corner: Corner = '';
  private from: { h: number; v: number } | null = null;
  private heat = 0;
  private broken = false;
  private timer = 0;
  private advancing = 0;

  private readonly steps: Step[] = [
    { name: 'welcome' },
    { name: 'control', at: ['#take'], done: () => inControl(MONITOR) },
    { name: 'deploy', at: ['#deploy'], done: () => has(MONITOR, 'Deployer', 'Deployed') },
    { name: 'move', at: ['lf-joystick'], done: () => this.moved() },
    { name: 'open', at: ['#Valve1 .open-button'], done: () => has(MONITOR, 'Valve1', 'Open') },
    { name: 'fire', at: ['#aim', 'lf-joystick'], done: () => (this.burns() ? this.cooled() : this.moved()) },
    { name: 'auto', at: ['#quench', '#draw'], done: () => has(MONITOR, 'Control', 'Quench') },
    { name: 'link', done: () => this.broken && store.linked },
    { name: 'end' },
  ];

  constructor() {
    super();
    new TopicController(this, () => [SECOND, 'monitors/', 'scene']);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.at = Number(sessionStorage.getItem(GUIDE_KEY) ?? 0) || 0;
    this.timer = window.setInterval(() => this.look(), 200);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
    clearTimeout(this.advancing);
    document.documentElement.style.removeProperty('--guide-height');
  }

  /** Notes stand above the guide. */
  override updated(): void {
    const height = this.renderRoot.querySelector<HTMLElement>('.card')?.offsetHeight ?? 0;
    document.documentElement.style.setProperty('--guide-height', `${this.corner === '' ? height + 12 : 0}px`);
  }

  override render() {
    const step = this.steps[this.at]!;
    const done = step.done?.() ?? false;
    const first = step.name === 'welcome';
    const last = step.name === 'end';
    return html`${this.ring && !done
        ? html`<div
            class="ring"
            ${styled({
              left: `${this.ring.x - MARGIN_PX}px`,
              top: `${this.ring.y - MARGIN_PX}px`,
              width: `${this.ring.width + 2 * MARGIN_PX}px`,
              height: `${this.ring.height + 2 * MARGIN_PX}px`,
            })}
          ></div>`
        : nothing}
      <section class="card ${this.corner}" role="complementary" aria-label=${t('guide.title')}>
        <header>
          <span>${t('guide.title')}${first || last ? '' : ` · ${this.at} / ${this.steps.length - 2}`}</span>
          <lf-button kind="quiet" icon="close" .label=${t('guide.leave')} @click=${this.leave}></lf-button>
        </header>
        <div class="dots" aria-hidden="true">
          ${this.steps.slice(1).map((_, n) => html`<i class=${n < this.at ? 'past' : ''}></i>`)}
        </div>
        <div role="status">
          <h2>${this.text(step, '_title')}</h2>
          <p>${this.text(step)}</p>
          ${step.name === 'fire' && this.burns() ? html`<p class="dim">${t('guide.heat', { heat: show('heat', this.heatNow()) })}</p>` : nothing}
        </div>
        <footer>
          ${first || last
            ? nothing
            : html`<lf-button kind="quiet" id="guide-skip" @click=${this.next}>${t('guide.skip')}</lf-button>`}
          ${done && !last && !first
            ? html`<span class="done grow">${icon('check')}${t('guide.well')}</span>`
            : html`<span class="grow"></span>`}
          ${step.name === 'link' && !this.broken
            ? html`<lf-button kind="primary" id="guide-break" @click=${this.breakLink}>${t('guide.break')}</lf-button>`
            : last
              ? html`<lf-button kind="primary" @click=${this.leave}>${t('guide.finish')}</lf-button>`
              : html`<lf-button
                  kind="primary"
                  id="guide-next"
                  .why=${first || done ? '' : t('guide.not_yet')}
                  @click=${this.next}
                  >${first ? t('guide.start') : t('guide.next')}</lf-button
                >`}
        </footer>
      </section>`;
  }

  /** A step whose words depend on whether something burns. */
  private text(step: Step, part = ''): string {
    const calm = (step.name === 'welcome' || step.name === 'fire') && !this.burns();
    return t(`guide.${step.name}${calm ? '_calm' : ''}${part}` as Key);
  }

  private burns(): boolean {
    return (store.get('scene')?.fires ?? []).some((fire) => fire.burns) || this.heat > 0;
  }

  /** Away from what the step speaks of, and from the monitor on the plan. */
  private settle(): void {
    const card = laidOut(this.renderRoot.querySelector('.card')?.getBoundingClientRect() ?? null);
    if (!card) return;
    const mark = laidOut(deepQuery(document, `[data-id="${MONITOR}"]`)?.getBoundingClientRect() ?? null);
    const kept = [this.ring, mark].filter((box) => box !== null && box.width > 0) as DOMRect[];
    const [width, height] = [innerWidth / magnified(), innerHeight / magnified()];
    const nav = card.x > width / 2 ? 16 : card.x;
    const at = (corner: Corner) =>
      new DOMRect(
        corner.includes('right') ? width - card.width - 16 : nav,
        corner.includes('top') ? 136 : height - card.height - 16,
        card.width,
        card.height,
      );
    const covered = (corner: Corner) => kept.reduce((sum, box) => sum + overlap(at(corner), box), 0);
    if (covered(this.corner) === 0) return;
    this.corner = [...CORNERS].sort((a, b) => covered(a) - covered(b))[0]!;
  }

  /** Where the ring is; and on to the next step, a moment after this one is done. */
  private look(): void {
    const step = this.steps[this.at]!;
    const boxes = (step.at ?? []).map((s) => deepQuery(document, s)?.getBoundingClientRect());
    const box = laidOut(boxes.find((one) => one && one.width > 0) ?? null);
    if (box?.x !== this.ring?.x || box?.y !== this.ring?.y || box?.width !== this.ring?.width) this.ring = box;
    this.settle();
    if (!step.done?.() || this.advancing) return;
    this.advancing = window.setTimeout(this.next, 1400);
  }

  private readonly next = (): void => {
    clearTimeout(this.advancing);
    this.advancing = 0;
    if (this.at === 0) router.go('operate', MONITOR);
    this.at = Math.min(this.at + 1, this.steps.length - 1);
    // What was done before is not asked for again.
    while (['control', 'deploy', 'open'].includes(this.steps[this.at]!.name) && this.steps[this.at]!.done!()) {
      this.at += 1;
    }
    this.from = this.place();
    this.heat = this.heatNow();
    sessionStorage.setItem(GUIDE_KEY, String(this.at));
  };

  private readonly leave = (): void => {
    guideWanted(false);
    this.dispatchEvent(new CustomEvent('left', { bubbles: true, composed: true }));
  };

  private readonly breakLink = (): void => {
    this.broken = true;
    socket.interrupt(BREAK_MS);
    this.requestUpdate();
  };

  private place(): { h: number; v: number } {
    const of = (drive: string) => validOf(store.get(`monitors/${MONITOR}/status`)?.subsystems[drive], 'position') ?? 0;
    return { h: of('Horizontal'), v: of('Vertical') };
  }

  private moved(): boolean {
    const now = this.place();
    this.from ??= now;
    return Math.abs(now.h - this.from.h) + Math.abs(now.v - this.from.v) > MOVED_ARCMIN;
  }

  private heatNow(): number {
    const fires = store.get('scene')?.fires ?? [];
    return fires.reduce((sum, fire) => sum + (fire.burns ? fire.heat_kw : 0), 0);
  }

  private cooled(): boolean {
    this.heat = Math.max(this.heat, this.heatNow());
    return this.heat > 0 && this.heatNow() < this.heat * HEAT_LEFT;
  }
}

/** In the pixels of the layout. */
function laidOut(box: DOMRect | null): DOMRect | null {
  const zoom = magnified();
  return box && new DOMRect(box.x / zoom, box.y / zoom, box.width / zoom, box.height / zoom);
}

/** Area that two boxes share. */
function overlap(a: DOMRect, b: DOMRect): number {
  const wide = Math.min(a.right, b.right) - Math.max(a.x, b.x);
  const high = Math.min(a.bottom, b.bottom) - Math.max(a.y, b.y);
  return Math.max(wide, 0) * Math.max(high, 0);
}

function deepQuery(root: Document | ShadowRoot, selector: string): Element | null {
  const found = root.querySelector(selector);
  if (found) return found;
  for (const element of root.querySelectorAll('*')) {
    const inner = element.shadowRoot && deepQuery(element.shadowRoot, selector);
    if (inner) return inner;
  }
  return null;
}
