// The position in a recording while it plays, on every page.
import { css, html, LitElement, nothing } from 'lit';
import { customElement } from 'lit/decorators.js';
import { type ReplayMark, replay } from '../hub/replay';
import type { Alarm } from '../hub/types';
import { lang, t, tt } from '../i18n';
import { icon } from '../parts/icons';
import '../parts/lf-button';
import '../parts/lf-timeline';
import { partsOf } from '../pages/alarms/model';
import { titleOf } from '../pages/alarms/names';
import type { Mark } from '../parts/lf-timeline';
import { base } from '../theme/shared';

@customElement('lf-replay-bar')
export class LfReplayBar extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
        container-type: inline-size;
        --lf-button-height: 48px;
      }
      .bar {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--s1) var(--s3);
        padding: var(--s1) var(--s3) var(--s2);
        background: var(--surface);
        border-top: 3px solid var(--accent);
        box-shadow: var(--shadow-large);
      }
      header {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        justify-content: space-between;
        gap: var(--s1) var(--s3);
        min-height: 48px;
      }
      .title {
        display: inline-flex;
        align-items: center;
        gap: var(--s2);
        font-weight: 650;
        min-width: 0;
        overflow: hidden;
        text-overflow: ellipsis;
        white-space: nowrap;
      }
      .title .icon {
        color: var(--accent);
      }
      .note {
        flex: 1;
        color: var(--dim);
        font-size: var(--t-note);
        min-width: 220px;
      }
      .error {
        color: var(--high);
        font-weight: 600;
      }
      @media (max-width: 720px) {
        .note {
          display: none;
        }
      }
    `,
  ];

  private known: { of: readonly ReplayMark[]; lang: string; marks: Mark[] } | null = null;
  private frame = 0;

  override connectedCallback(): void {
    super.connectedCallback();
    replay.addEventListener('change', this.again);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    replay.removeEventListener('change', this.again);
    cancelAnimationFrame(this.frame);
    this.frame = 0;
  }

  override render() {
    const { source } = replay;
    if (replay.phase !== 'on' || !source) return nothing;
    return html`<section class="bar" aria-label=${t('replay.bar')}>
      <header>
        <span class="title">${icon('replay')} ${source.title}</span>
        <span class="note">
          ${
            replay.error
              ? html`<span class="error">${replay.error.text(lang())}</span>`
              : replay.waiting
                ? t('replay.waiting')
                : t('replay.note')
          }
        </span>
        <lf-button kind="primary" id="live" @click=${() => replay.close()}>${t('replay.live')}</lf-button>
      </header>
      <lf-timeline
        compact
        .from=${source.from_ms}
        .to=${source.to_ms}
        .at=${replay.at_ms}
        .playing=${replay.playing}
        .speed=${replay.speed}
        .marks=${this.marks()}
        @play=${() => replay.play()}
        @pause=${() => replay.pause()}
        @speed=${(event: CustomEvent) => replay.setSpeed(event.detail.speed)}
        @seek=${(event: CustomEvent) => replay.seek(event.detail.at_ms)}
      ></lf-timeline>
    </section>`;
  }

  private marks(): Mark[] {
    if (this.known?.of !== replay.marks || this.known.lang !== lang()) {
      const marks = replay.marks.map(({ at_ms, kind, alarm, text }) => ({
        at_ms,
        kind,
        text: kind === 'alarm' ? alarmText(alarm, text) : text,
      }));
      this.known = { of: replay.marks, lang: lang(), marks };
    }
    return this.known.marks;
  }

  private readonly again = (): void => {
    this.frame ||= requestAnimationFrame(() => {
      this.frame = 0;
      this.requestUpdate();
    });
  };
}

/** A series that the history has only by its id gets its name from the dictionary. */
function alarmText(alarm: Alarm | undefined, id: string): string {
  const monitor = alarm?.monitor ?? partsOf(id).monitor;
  return [monitor, alarm ? tt(alarm.what) : titleOf(id)].filter(Boolean).join(': ');
}
