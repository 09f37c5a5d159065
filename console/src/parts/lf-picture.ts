// The picture of a camera. What is old is never shown as if it were new: without a new picture for more than a second it is
// dimmed, and says how old it is.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, query, state } from 'lit/decorators.js';
import { age, num, t } from '../i18n';
import { base } from '../theme/shared';
import { icon } from './icons';
import { type Decoded, Decoding, type NoDecoder, type Unit } from './picture/decoding';
import { Words } from './words';

/** Without a new picture for so long, ms, it is said that it is old: with the time between two looks less than 2 s. */
const OLD_MS = 1200;
const LOOK_MS = 250;
/** With more units before the decoder, no more are asked for. */
const QUEUE_MAX = 8;

@customElement('lf-picture')
export class LfPicture extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
        position: relative;
        overflow: hidden;
        background: var(--chrome);
        color: var(--on-chrome);
      }
      canvas {
        display: block;
        width: 100%;
        height: 100%;
        object-fit: contain;
      }
      canvas.old {
        opacity: 0.35;
        filter: grayscale(1);
      }
      .age {
        position: absolute;
        left: var(--s1);
        bottom: var(--s1);
        padding: 0 var(--s1);
        border-radius: var(--radius-small);
        background: var(--chrome);
        font-size: var(--t-small);
      }
      .says {
        position: absolute;
        inset: 0;
        display: flex;
        flex-direction: column;
        align-items: center;
        justify-content: center;
        gap: var(--s1);
        padding: var(--s2);
        text-align: center;
        font-size: var(--t-note);
      }
      .says b {
        display: inline-flex;
        align-items: center;
        gap: var(--s1);
        padding: var(--s1) var(--s2);
        border-radius: var(--radius);
        background: var(--chrome-high);
        color: var(--on-chrome-high);
        font-size: var(--t-normal);
      }
      .says span {
        padding: var(--s05) var(--s2);
        border-radius: var(--radius);
        background: var(--chrome);
      }
    `,
  ];

  /** What it is a picture of. */
  @property() label = '';
  /** Why there is no picture, as the hub says it; empty: there is one. */
  @property() why = '';
  /** The date of the hub. */
  @property({ attribute: false }) now: () => number = Date.now;

  @state() private old = true;
  @state() private age_ms: number | null = null;
  @state() private none: NoDecoder | null = null;
  @query('canvas') private canvas?: HTMLCanvasElement;
  private decoding: Decoding | null = null;
  private waiting: Decoded | null = null;
  private frame = 0;
  private timer = 0;
  /** When the last picture was drawn, by a clock that is never set. */
  private drawn_ms: number | null = null;
  /** The last unit that came. */
  private last: number | null = null;
  /** When the picture that is shown reached the hub. */
  private at_ms: number | null = null;

  constructor() {
    super();
    new Words(this);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.timer = window.setInterval(() => this.look(), LOOK_MS);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
    this.clear();
  }

  /** Another stream: nothing of the one before is shown any more. */
  clear(): void {
    this.decoding?.close();
    this.decoding = null;
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    this.waiting?.frame.close();
    this.waiting = null;
    this.drawn_ms = null;
    this.at_ms = null;
    this.last = null;
    this.canvas?.getContext('2d')?.clearRect(0, 0, this.canvas.width, this.canvas.height);
    this.look();
  }

  push(unit: Unit): void {
    this.decoding ??= new Decoding((picture) => this.draw(picture));
    this.decoding.push(unit);
    this.last = unit.number;
    this.confirm();
  }

  /** Not when it is shown: a decoder holds the last ones back until more come, and with B-frames none would come. */
  private confirm(): void {
    if (this.last === null || (this.decoding?.queue ?? 0) > QUEUE_MAX) return;
    this.dispatchEvent(new CustomEvent('taken', { detail: this.last }));
    this.last = null;
  }

  override render() {
    const { old, age_ms, drawn_ms } = this;
    const head = drawn_ms === null ? t('parts.no_picture') : t('parts.old_picture', { age: age(age_ms ?? 0) });
    const why = this.none ? t(`parts.picture_${this.none}`) : this.why;
    return html`<canvas class=${old ? 'old' : ''} role="img" aria-label=${this.label} width="16" height="9"></canvas>
      ${
        old
          ? html`<div class="says" role="status"><b>${icon('warning', 16)} ${head}</b>${why ? html`<span>${why}</span>` : nothing}</div>`
          : html`<div class="age">${age_ms === null ? nothing : t('parts.picture_age', { age: num(age_ms / 1000, 1) })}</div>`
      }`;
  }

  /** Drawn with the next frame of the screen: of several only the last one. */
  private draw(picture: Decoded): void {
    this.confirm();
    this.waiting?.frame.close();
    this.waiting = picture;
    this.frame ||= requestAnimationFrame(() => {
      this.frame = 0;
      this.paint();
    });
  }

  private paint(): void {
    const { waiting, canvas } = this;
    this.waiting = null;
    if (!waiting) return;
    const { frame, at_ms } = waiting;
    const { displayWidth: width, displayHeight: height } = frame;
    if (canvas) {
      if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
      canvas.getContext('2d')?.drawImage(frame, 0, 0, width, height);
    }
    frame.close();
    this.drawn_ms = performance.now();
    this.at_ms = at_ms;
    if (this.old) this.look();
  }

  private look(): void {
    const since = this.drawn_ms === null ? null : performance.now() - this.drawn_ms;
    this.old = since === null || since > OLD_MS;
    this.none = this.decoding?.none ?? null;
    // Tenths of a second: more often nothing is rendered.
    const age_ms = this.at_ms === null ? null : Math.max(0, this.now() - this.at_ms, since ?? 0);
    this.age_ms = age_ms === null ? null : Math.round(age_ms / 100) * 100;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-picture': LfPicture;
  }
}
