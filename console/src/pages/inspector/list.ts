// The frames as they pass, each in two lines. Only visible rows are in the page.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { repeat } from 'lit/directives/repeat.js';
import { type Key, num, t } from '../../i18n';
import { icon } from '../../parts/icons';
import { unitText } from '../../units';
import '../../parts/lf-button';
import { styled } from '../../parts/styled';
import { base } from '../../theme/shared';
import { type Kept, slice } from './frames';

const ROW = 52;
/** A longer text is cut off anyway, and expensive to lay out. */
const LINE_MOST = 400;

@customElement('lf-frame-list')
export class LfFrameList extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
        position: relative;
        min-height: 0;
        background: var(--surface);
        border: 1px solid var(--line);
        border-radius: var(--radius-large);
        overflow: hidden;
      }
      .scroll {
        height: 100%;
        overflow: auto;
        overscroll-behavior: contain;
      }
      .scroll:focus-visible {
        outline-offset: -3px;
      }
      .space {
        position: relative;
      }
      .frame {
        position: absolute;
        inset: 0 0 auto 0;
        height: 52px;
        display: grid;
        grid-template-columns: 104px 92px minmax(0, 1fr) auto;
        align-items: center;
        gap: 0 var(--s25);
        padding: 0 var(--s25) 0 var(--s25);
        border-bottom: 1px solid var(--line);
        border-left: 4px solid var(--line-strong);
        cursor: pointer;
        contain: strict;
      }
      .frame:hover {
        background: var(--surface-2);
      }
      .frame.out {
        border-left-color: var(--accent);
      }
      .frame.odd {
        border-left-color: var(--medium);
        background: var(--medium-soft);
      }
      .frame.foreign {
        border-left-style: dashed;
        background: var(--info-soft);
      }
      .frame[aria-selected='true'] {
        background: var(--accent-soft);
      }
      .time {
        font-size: var(--t-note);
        color: var(--dim);
        line-height: 1.3;
        white-space: nowrap;
      }
      .took {
        font-size: var(--t-small);
      }
      .way {
        display: flex;
        align-items: center;
        gap: var(--s15);
        font-weight: 650;
        font-size: var(--t-note);
        white-space: nowrap;
      }
      .out .way .icon {
        color: var(--accent);
      }
      .both {
        min-width: 0;
      }
      .text,
      .bytes {
        overflow: hidden;
        text-overflow: ellipsis;
        white-space: nowrap;
      }
      .text {
        font-weight: 550;
      }
      .bytes {
        font-family: var(--mono);
        font-size: var(--t-small);
        color: var(--dim);
      }
      .verdict {
        font-size: var(--t-note);
        font-weight: 600;
        color: var(--medium);
      }
      .foreign .verdict {
        color: var(--info);
      }
      .newer {
        position: absolute;
        right: 20px;
        bottom: 12px;
        box-shadow: var(--shadow-large);
        border-radius: var(--radius);
      }
      @media (max-width: 720px) {
        .frame {
          grid-template-columns: 84px minmax(0, 1fr);
          padding-right: var(--s15);
        }
        .way {
          display: none;
        }
        .time {
          font-size: var(--t-small);
        }
        .verdict {
          display: none;
        }
      }
    `,
  ];

  @property({ attribute: false }) frames: Kept[] = [];
  @property({ type: Number }) selected = 0;
  @property() label = '';
  private top = 0;
  @state() private height = 400;
  /** The list follows new frames until the user scrolls back. */
  @state() private following = true;
  private seen = 0;
  private resize = new ResizeObserver(([entry]) => {
    if (entry) this.height = entry.contentRect.height;
  });

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.resize.disconnect();
  }

  override firstUpdated(): void {
    this.resize.observe(this.scroller);
  }

  override updated(): void {
    if (!this.following) return;
    this.seen = this.frames.at(-1)?.n ?? 0;
    const bottom = this.frames.length * ROW - this.height;
    if (Math.abs(this.scroller.scrollTop - bottom) > 1) this.scroller.scrollTop = Math.max(0, bottom);
  }

  override render() {
    const { frames } = this;
    const top = this.following ? Math.max(0, frames.length * ROW - this.height) : this.top;
    const [first, last] = slice(top, this.height, ROW, frames.length);
    const shown = frames.slice(first, last);
    const newer = this.following ? 0 : frames.filter((frame) => frame.n > this.seen).length;
    return html`<div
        class="scroll"
        role="listbox"
        tabindex="0"
        aria-label=${this.label}
        aria-activedescendant=${shown.some(({ n }) => n === this.selected) ? `f${this.selected}` : nothing}
        @scroll=${this.scrolled}
        @keydown=${this.keyed}
      >
        <div class="space" ${styled({ height: `${frames.length * ROW}px` })}>
          ${repeat(
            shown,
            (frame) => frame.n,
            (frame, index) => this.renderFrame(frame, first + index),
          )}
        </div>
      </div>
      ${
        this.following
          ? nothing
          : html`<lf-button class="newer" kind="primary" icon="down" @click=${this.follow}
            >${t('inspector.newer', { n: num(newer) })}</lf-button
          >`
      }`;
  }

  private renderFrame(frame: Kept, index: number) {
    const { verdict, direction } = frame;
    const usual = verdict === 'sent' || verdict === 'believed' || verdict === 'heard';
    const kind = verdict === 'foreign' ? 'foreign' : usual ? '' : 'odd';
    const away = direction === 'out';
    return html`<div
      class="frame ${direction} ${kind}"
      id="f${frame.n}"
      role="option"
      aria-selected=${frame.n === this.selected ? 'true' : 'false'}
      aria-setsize=${this.frames.length}
      aria-posinset=${index + 1}
      ${styled({ transform: `translateY(${index * ROW}px)` })}
      @click=${() => this.choose(frame.n)}
    >
      <div class="time">
        ${clock(frame.at_ms)}
        ${frame.took_ms === null ? nothing : html`<div class="took">${frame.took_ms < 1 ? '<1' : `+${num(frame.took_ms)}`} ${unitText('duration_ms')}</div>`}
      </div>
      <div class="way" title=${t(away ? 'inspector.out' : 'inspector.in')}>
        ${icon(away ? 'right' : 'left', 18)} ${frame.src} → ${frame.dst}
      </div>
      <div class="both">
        <div class="text">${frame.text.slice(0, LINE_MOST) || '—'}</div>
        <div class="bytes">${frame.bytes.slice(0, LINE_MOST)}</div>
      </div>
      ${
        usual
          ? nothing
          : html`<span class="verdict" title=${t(`inspector.about_${verdict}` as Key)}
            >${t(`inspector.verdict_${verdict}` as Key)}</span
          >`
      }
    </div>`;
  }

  /** Continues following; also after a filter has changed. */
  readonly follow = (): void => {
    this.following = true;
  };

  private get scroller(): HTMLElement {
    return this.renderRoot.querySelector('.scroll')!;
  }

  private readonly scrolled = (): void => {
    const { scrollTop } = this.scroller;
    const bottom = this.frames.length * ROW - this.height;
    const moved = scrollTop < this.top - 2;
    this.top = scrollTop;
    if (this.following && moved && scrollTop < bottom - ROW) this.following = false;
    else if (!this.following && scrollTop >= bottom - 2) this.following = true;
    else if (!this.following) this.requestUpdate();
  };

  private choose(n: number): void {
    this.dispatchEvent(new CustomEvent('choose', { detail: n }));
  }

  private keyed(event: KeyboardEvent): void {
    const step = { ArrowDown: 1, ArrowUp: -1, PageDown: 10, PageUp: -10 }[event.key];
    if (event.key === 'End') this.follow();
    if (step === undefined || this.frames.length === 0) return;
    event.preventDefault();
    const at = this.frames.findIndex((frame) => frame.n === this.selected);
    const from = at < 0 ? this.frames.length : at;
    const to = Math.max(0, Math.min(this.frames.length - 1, from + step));
    this.choose(this.frames[to]!.n);
    this.following = false;
    const top = to * ROW;
    const scroller = this.scroller;
    if (top < scroller.scrollTop) scroller.scrollTop = top;
    else if (top + ROW > scroller.scrollTop + this.height) scroller.scrollTop = top + ROW - this.height;
  }
}

/** 14:03:27.123: the same in every language. */
export function clock(at_ms: number): string {
  const at = new Date(at_ms);
  const two = (n: number) => String(n).padStart(2, '0');
  const ms = String(at.getMilliseconds()).padStart(3, '0');
  return `${two(at.getHours())}:${two(at.getMinutes())}:${two(at.getSeconds())}.${ms}`;
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-frame-list': LfFrameList;
  }
}
