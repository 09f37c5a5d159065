// The first minute: leads a newcomer of the demo through taking control, moving, opening,
// extinguishing, the automatic way, and a lost link. Each step ends when the monitor says so.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { validOf } from '../hub/readings';
import { has, inControl } from '../hub/session';
import { socket } from '../hub/socket';
import { SECOND, store, TopicController } from '../hub/store';
import { t } from '../i18n';
import { icon } from '../parts/icons';
import { styled } from '../parts/styled';
import { magnified } from '../theme/display';
import { base } from '../theme/shared';
import { show } from '../units';
import { GUIDE_KEY, guideWanted } from './guide-key';
import { guideWords } from './guide-words';
import { router } from './router';

interface Step {
  name: 'welcome' | 'control' | 'deploy' | 'move' | 'open' | 'fire' | 'auto' | 'link' | 'end';
  /** The element to point at. */
  at?: string[];
  done?: () => boolean;
}

const MONITOR = 'M1';
const MOVED_ARCMIN = 180;
const HEAT_LEFT = 0.6;
const BREAK_MS = 6000;
const MARGIN_PX = 6;

@customElement('lf-guide')
export class LfGuide extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
        background: var(--surface);
        border-top: 2px solid var(--accent);
      }
      .card {
        display: grid;
        grid-template-columns: minmax(0, 1fr) auto;
        align-items: center;
        gap: var(--s1) var(--s4);
        padding: var(--s2) var(--s3) var(--s2);
        max-height: 40dvh;
        overflow-y: auto;
      }
      /* Beside the text, so that the bar takes little of a low window. */
      .name {
        grid-area: 1 / 2;
        display: flex;
        align-items: center;
        gap: var(--s3);
        font-size: var(--t-small);
        font-weight: 600;
        color: var(--dim);
      }
      .text {
        grid-area: 1 / 1 / span 2;
      }
      h2 {
        font-size: var(--t-large);
        letter-spacing: -0.01em;
      }
      p {
        font-size: var(--t-normal);
        line-height: 1.4;
      }
      .dots {
        flex: 1;
        max-width: 320px;
        display: flex;
        gap: var(--s1);
      }
      .dots i {
        width: 100%;
        height: 4px;
        border-radius: var(--radius-small);
        background: var(--line);
      }
      .dots .past {
        background: var(--accent);
      }
      footer {
        display: flex;
        flex-wrap: wrap;
        justify-content: end;
        align-items: center;
        gap: var(--s2);
      }
      .done {
        display: flex;
        align-items: center;
        gap: var(--s15);
        font-weight: 650;
        color: var(--accent);
      }
      .ring {
        position: fixed;
        z-index: 43;
        pointer-events: none;
        border: 3px solid var(--accent);
        border-radius: var(--radius-large);
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
        .card {
          grid-template-columns: minmax(0, 1fr);
          padding: var(--s2) var(--s25);
        }
        .name,
        .text {
          grid-area: auto;
        }
      }
    `,
  ];

  @state() private at = 0;
  @state() private ring: DOMRect | null = null;
  /** The step whose ring has been brought into sight, and the size of the window. */
  private shown = '';
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
    new TopicController(this, () => [SECOND, 'monitors/', 'scene', 'hub']);
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

  /** It has a row of its own: pages that fill the window are lower by it. */
  override updated(): void {
    document.documentElement.style.setProperty('--guide-height', `${this.offsetHeight}px`);
  }

  override render() {
    const step = this.steps[this.at]!;
    const done = step.done?.() ?? false;
    const first = step.name === 'welcome';
    const last = step.name === 'end';
    const words = this.words(step);
    return html`${
      this.ring && !done
        ? html`<div
            class="ring"
            ${styled({
              left: `${this.ring.x - MARGIN_PX}px`,
              top: `${this.ring.y - MARGIN_PX}px`,
              width: `${this.ring.width + 2 * MARGIN_PX}px`,
              height: `${this.ring.height + 2 * MARGIN_PX}px`,
            })}
          ></div>`
        : nothing
    }
      <section class="card" role="complementary" aria-label=${t('guide.title')}>
        <div class="name">
          <span>${t('guide.title')}${first || last ? '' : ` · ${this.at} / ${this.steps.length - 2}`}</span>
          <div class="dots" aria-hidden="true">
            ${this.steps.slice(1).map((_, n) => html`<i class=${n < this.at ? 'past' : ''}></i>`)}
          </div>
        </div>
        <div class="text" role="status">
          <h2>${words.title}</h2>
          <p>
            ${words.text}
            ${step.name === 'fire' && this.burns() ? html`<span class="dim">${t('guide.heat', { heat: show('heat', this.heatNow()) })}</span>` : nothing}
          </p>
        </div>
        <footer>
          ${
            first || last
              ? nothing
              : html`<lf-button kind="quiet" id="guide-skip" @click=${this.next}>${t('guide.skip')}</lf-button>`
          }
          ${done && !last && !first ? html`<span class="done">${icon('check')}${t('guide.well')}</span>` : nothing}
          ${
            step.name === 'link' && !this.broken
              ? html`<lf-button kind="primary" id="guide-break" @click=${this.breakLink}>${t('guide.break')}</lf-button>`
              : last
                ? html`<lf-button kind="primary" @click=${this.leave}>${t('guide.finish')}</lf-button>`
                : html`<lf-button
                  kind="primary"
                  id="guide-next"
                  .why=${first || done ? '' : t('guide.not_yet')}
                  @click=${this.next}
                  >${first ? t('guide.start') : t('guide.next')}</lf-button
                >`
          }
          <lf-button kind="quiet" icon="close" .label=${t('guide.leave')} @click=${this.leave}></lf-button>
        </footer>
      </section>`;
  }

  /** Some steps speak of the site. */
  private words({ name }: Step): { title: string; text: string } {
    if (name !== 'welcome' && name !== 'fire' && name !== 'auto') {
      return { title: t(`guide.${name}_title`), text: t(`guide.${name}`) };
    }
    const [site, scene] = [store.get('hub')?.site, store.get('scene')];
    return guideWords(name, {
      monitors: store.liveMonitors().length,
      tanks: site?.tanks ?? [],
      fires: scene?.fires ?? [],
      wind: scene?.wind ?? [0, 0],
    });
  }

  private burns(): boolean {
    return (store.get('scene')?.fires ?? []).some((fire) => fire.burns) || this.heat > 0;
  }

  /** Where the ring is; and on to the next step, a moment after this one is done. */
  private look(): void {
    const step = this.steps[this.at]!;
    const marked = (step.at ?? [])
      .map((s) => deepQuery(document, s))
      .find((one) => one && one.getBoundingClientRect().width > 0);
    // In another window it may lie elsewhere.
    const seen = `${this.at} ${innerWidth} ${innerHeight}`;
    if (marked && this.shown !== seen) {
      this.shown = seen;
      marked.scrollIntoView({ block: 'nearest' });
    }
    const box = laidOut(marked?.getBoundingClientRect() ?? null);
    if (box?.x !== this.ring?.x || box?.y !== this.ring?.y || box?.width !== this.ring?.width) this.ring = box;
    if (!step.done?.() || this.advancing) return;
    this.advancing = window.setTimeout(this.next, 1400);
  }

  private readonly next = (): void => {
    clearTimeout(this.advancing);
    this.advancing = 0;
    if (this.at === 0) router.go('operate', MONITOR);
    this.at = Math.min(this.at + 1, this.steps.length - 1);
    // Steps done before are skipped.
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

function deepQuery(root: Document | ShadowRoot, selector: string): Element | null {
  const found = root.querySelector(selector);
  if (found) return found;
  for (const element of root.querySelectorAll('*')) {
    const inner = element.shadowRoot && deepQuery(element.shadowRoot, selector);
    if (inner) return inner;
  }
  return null;
}
