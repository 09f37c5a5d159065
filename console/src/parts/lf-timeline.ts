import { css, html, LitElement, nothing, type TemplateResult } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { t, time } from '../i18n';
import { magnified, placeIn } from '../theme/display';
import { emit, partStyle } from './part-style';
import { styled } from './styled';
import { Words } from './words';

export interface Mark {
  at_ms: number;
  kind: 'alarm' | 'command' | 'event';
  text: string;
}

const SKIP_MS = 10_000;
const KEY_MS = 1000;
const NEAR_PX = 10;

/**
 * The position in a recording. Events: `play`, `pause`, `speed` {speed}, `seek` {at_ms}.
 */
@customElement('lf-timeline')
export class LfTimeline extends LitElement {
  @property({ type: Number }) from: number = 0;
  @property({ type: Number }) to: number = 0;
  @property({ type: Number }) at: number = 0;
  @property({ type: Boolean }) playing: boolean = false;
  @property({ type: Number }) speed: number = 1;
  @property({ attribute: false }) speeds: readonly number[] = [0.5, 1, 2, 5, 10];
  @property({ attribute: false }) marks: readonly Mark[] = [];
  /** In one row. */
  @property({ type: Boolean, reflect: true }) compact: boolean = false;
  @state() over: { x: number; at_ms: number; text: string } | null = null;

  constructor() {
    super();
    new Words(this);
  }

  static override styles = [
    partStyle,
    css`
      :host {
        display: grid;
        gap: var(--s2);
      }
      .track {
        position: relative;
        height: 48px;
        touch-action: none;
        cursor: pointer;
        outline-offset: 2px;
        border-radius: var(--radius);
      }
      .track:focus-visible,
      button:focus-visible,
      select:focus-visible {
        outline: 3px solid var(--focus);
      }
      .rail {
        position: absolute;
        inset: 20px 0;
        border-radius: var(--radius-small);
        background: var(--line);
        overflow: hidden;
      }
      .done {
        position: absolute;
        inset: 0 auto 0 0;
        background: var(--accent);
      }
      .mark {
        position: absolute;
        bottom: 30px;
        width: 2px;
        height: 10px;
        margin-left: -1px;
        background: var(--dim);
      }
      .mark.command {
        background: var(--accent);
      }
      .mark.alarm {
        width: 8px;
        height: 8px;
        margin-left: calc(-1 * var(--s1));
        bottom: 31px;
        background: var(--high);
        clip-path: polygon(50% 100%, 0 0, 100% 0);
      }
      .mark.event {
        top: 32px;
        bottom: auto;
        height: 7px;
      }
      .knob {
        position: absolute;
        top: 14px;
        width: 20px;
        height: 20px;
        margin-left: calc(-1 * var(--s2));
        border-radius: 50%;
        background: var(--surface);
        border: 3px solid var(--accent);
        box-shadow: var(--shadow-knob);
      }
      .over {
        position: absolute;
        bottom: 46px;
        transform: translateX(-50%);
        padding: var(--s1) var(--s2);
        border-radius: var(--radius-small);
        border: 1px solid var(--line);
        background: var(--surface);
        font-size: var(--t-small);
        white-space: nowrap;
        pointer-events: none;
        max-width: 360px;
        overflow: hidden;
        text-overflow: ellipsis;
        z-index: 1;
      }
      .bar {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--s2);
      }
      button,
      select {
        min-height: 48px;
        min-width: 48px;
        padding: 0 var(--s25);
        border: 1px solid var(--line);
        border-radius: var(--radius);
        background: var(--surface);
        color: var(--text);
        font: inherit;
        cursor: pointer;
        display: inline-grid;
        place-items: center;
        outline-offset: 2px;
      }
      button:hover {
        background: var(--surface-2);
      }
      button.play {
        min-width: 64px;
        background: var(--accent);
        border-color: var(--accent);
        color: var(--on-accent);
      }
      svg {
        width: 22px;
        height: 22px;
        fill: currentcolor;
        stroke: currentcolor;
        stroke-width: 1.5;
        stroke-linejoin: round;
        stroke-linecap: round;
      }
      svg.line {
        fill: none;
        stroke-width: 2;
      }
      .clock {
        font-weight: 650;
        font-size: var(--t-large);
        min-width: 9ch;
        margin-left: var(--s2);
      }
      .of {
        color: var(--dim);
        font-size: var(--t-note);
        margin-right: auto;
      }
      :host([compact]) {
        grid-template-columns: auto minmax(160px, 1fr) auto;
        align-items: center;
        gap: var(--s2) var(--s3);
      }
      :host([compact]) .bar {
        display: contents;
      }
      .group {
        display: flex;
        gap: var(--s2);
      }
      :host([compact]) .group {
        grid-area: 1 / 1;
      }
      :host([compact]) .track {
        grid-area: 1 / 2;
      }
      .end {
        display: flex;
        flex: 1;
        align-items: center;
        gap: var(--s2);
      }
      :host([compact]) .end {
        grid-area: 1 / 3;
      }
      :host([compact]) .skip,
      :host([compact]) label span {
        display: none;
      }
      label {
        display: inline-flex;
        align-items: center;
        gap: var(--s2);
        color: var(--dim);
        font-size: var(--t-note);
      }
      @container (max-width: 760px) {
        :host([compact]) .of {
          display: none;
        }
      }
      @container (max-width: 520px) {
        :host([compact]) {
          grid-template-columns: auto 1fr;
        }
        :host([compact]) .track {
          grid-area: 2 / 1 / 3 / 3;
        }
        :host([compact]) .end {
          grid-area: 1 / 2;
          justify-content: flex-end;
        }
        .clock {
          font-size: var(--t-normal);
          min-width: 0;
          margin: 0;
        }
        .end {
          gap: var(--s1);
        }
      }
    `,
  ];

  private percent(at_ms: number): number {
    return Math.min(Math.max((at_ms - this.from) / Math.max(this.to - this.from, 1), 0), 1) * 100;
  }

  protected override render(): TemplateResult {
    const part = this.percent(this.at);
    const passed = within(this.at, this.from, this.to) - this.from;
    const run = span(passed);
    const whole = span(this.to - this.from);
    return html`
      <div
        class="track"
        role="slider"
        tabindex="0"
        aria-label=${t('parts.timeline')}
        aria-valuemin="0"
        aria-valuemax=${Math.round((this.to - this.from) / 1000)}
        aria-valuenow=${Math.round(passed / 1000)}
        aria-valuetext="${time(this.at)}, ${t('parts.timeline.at', { t: run, d: whole })}"
        @pointerdown=${this.down}
        @pointermove=${this.move}
        @pointerleave=${() => (this.over = null)}
        @keydown=${this.key}
      >
        ${this.marks.map(
          (mark) => html`<i class="mark ${mark.kind}" ${styled({ left: `${this.percent(mark.at_ms)}%` })}></i>`,
        )}
        <div class="rail"><div class="done" ${styled({ width: `${part}%` })}></div></div>
        <div class="knob" ${styled({ left: `${part}%` })}></div>
        ${
          this.over
            ? html`<div class="over" ${styled({ left: `clamp(90px, ${this.over.x}px, calc(100% - 90px))` })}>
                ${time(this.over.at_ms)}${this.over.text ? ` · ${this.over.text}` : nothing}
              </div>`
            : nothing
        }
      </div>
      <div class="bar">
        <div class="group">${this.button('previous', 'M18 5v14L8 12ZM6 5v14', () => this.jump(-1))}
        ${this.button('back', 'M12 6v12L3 12ZM21 6v12l-9-6Z', () => this.seek(this.at - SKIP_MS))}
        <button
          type="button"
          class="play"
          aria-label=${t(this.playing ? 'parts.timeline.pause' : 'parts.timeline.play')}
          title=${t(this.playing ? 'parts.timeline.pause' : 'parts.timeline.play')}
          @click=${() => emit(this, this.playing ? 'pause' : 'play')}
        >
          <svg viewBox="0 0 24 24" aria-hidden="true">
            <path d=${this.playing ? 'M7 5h3v14H7ZM14 5h3v14h-3Z' : 'M7 4v16l13-8Z'}></path>
          </svg>
        </button>
        ${this.button('forward', 'M12 6v12l9-6ZM3 6v12l9-6Z', () => this.seek(this.at + SKIP_MS))}
        ${this.button('next', 'M6 5v14l10-7ZM18 5v14', () => this.jump(1))}</div>
        <div class="end">
        <span class="clock">${time(this.at)}</span>
        <span class="of">${t('parts.timeline.at', { t: run, d: whole })}</span>
        <label
          ><span>${t('parts.timeline.speed')}</span>
          <select aria-label=${t('parts.timeline.speed')} @change=${this.speedChosen}>
            ${this.speeds.map(
              (speed) => html`<option value=${speed} ?selected=${speed === this.speed}>${speed}×</option>`,
            )}
          </select></label
        >
        </div>
      </div>
    `;
  }

  private button(name: 'previous' | 'back' | 'forward' | 'next', d: string, act: () => void): TemplateResult {
    const label = t(`parts.timeline.${name}`);
    const skip = name === 'back' || name === 'forward' ? 'skip' : '';
    return html`<button type="button" class=${skip} aria-label=${label} title=${label} @click=${act}>
      <svg viewBox="0 0 24 24" aria-hidden="true"><path d=${d}></path></svg>
    </button>`;
  }

  private seek(at_ms: number): void {
    emit(this, 'seek', { at_ms: within(at_ms, this.from, this.to) });
  }

  private jump(way: 1 | -1): void {
    const next = nextMark(this.marks, this.at, way);
    this.seek(next ?? (way > 0 ? this.to : this.from));
  }

  private timeAt(event: PointerEvent): { x: number; at_ms: number } {
    const box = (event.currentTarget as Element).getBoundingClientRect();
    const width = box.width / magnified();
    const x = Math.min(Math.max(placeIn(box, event)[0], 0), width);
    return { x, at_ms: this.from + (x / Math.max(width, 1)) * (this.to - this.from) };
  }

  private down(event: PointerEvent): void {
    if (event.button !== 0) return;
    (event.currentTarget as Element).setPointerCapture(event.pointerId);
    this.seek(this.timeAt(event).at_ms);
  }

  private move(event: PointerEvent): void {
    const { x, at_ms } = this.timeAt(event);
    if (event.buttons & 1 && (event.currentTarget as Element).hasPointerCapture(event.pointerId)) {
      this.seek(at_ms);
    }
    const width = (event.currentTarget as Element).clientWidth;
    const near = (NEAR_PX / Math.max(width, 1)) * (this.to - this.from);
    const mark = nearest(this.marks, at_ms, near);
    this.over = { x, at_ms: mark?.at_ms ?? at_ms, text: mark?.text ?? '' };
  }

  private key(event: KeyboardEvent): void {
    const far = event.shiftKey ? SKIP_MS : KEY_MS;
    const steps: Record<string, number> = {
      ArrowRight: this.at + far,
      ArrowUp: this.at + far,
      ArrowLeft: this.at - far,
      ArrowDown: this.at - far,
      PageUp: this.at + SKIP_MS,
      PageDown: this.at - SKIP_MS,
      Home: this.from,
      End: this.to,
    };
    const to = steps[event.key];
    if (to === undefined) return;
    event.preventDefault();
    this.seek(to);
  }

  private speedChosen(event: Event): void {
    emit(this, 'speed', { speed: Number((event.target as HTMLSelectElement).value) });
  }
}

/** The mark after (or before) a time, with half a second of grace. */
export function nextMark(marks: readonly { at_ms: number }[], at_ms: number, way: 1 | -1): number | null {
  const times = marks.map((mark) => mark.at_ms);
  const on = times.filter((time) => (way > 0 ? time > at_ms + 500 : time < at_ms - 500));
  if (!on.length) return null;
  return way > 0 ? Math.min(...on) : Math.max(...on);
}

function nearest(marks: readonly Mark[], at_ms: number, within_ms: number): Mark | null {
  let best: Mark | null = null;
  for (const mark of marks) {
    const off = Math.abs(mark.at_ms - at_ms);
    if (off <= within_ms && (!best || off < Math.abs(best.at_ms - at_ms))) best = mark;
  }
  return best;
}

/** A time, or the end that it is beyond: nothing is shown to be at 4:40 of 3:00. */
export function within(at: number, from: number, to: number): number {
  return Math.max(Math.min(at, to), from);
}

/** 3:07, 1:02:09 */
export function span(ms: number): string {
  const seconds = Math.max(Math.round(ms / 1000), 0);
  const [h, m, s] = [Math.floor(seconds / 3600), Math.floor(seconds / 60) % 60, seconds % 60];
  const two = (value: number): string => String(value).padStart(2, '0');
  return h ? `${h}:${two(m)}:${two(s)}` : `${m}:${two(s)}`;
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-timeline': LfTimeline;
  }
}
