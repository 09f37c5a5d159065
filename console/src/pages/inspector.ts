// The protocol as it passes: frames as text and bytes, decoded, and requests typed by the user.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { commands } from '../hub/commands';
import { dictionary, dictionaryNow } from '../hub/dictionary';
import { socket } from '../hub/socket';
import { store, TopicController } from '../hub/store';
import { num, t } from '../i18n';
import { icon } from '../parts/icons';
import '../parts/lf-blank';
import '../parts/lf-button';
import '../parts/lf-find';
import { base, card, fields, page } from '../theme/shared';
import { filters, notice, saveFile, stamp } from './alarms/common';
import './diagnosis/link';
import './inspector/decoded';
import { type FrameFilter, Frames, type Kept, lineOf, shownFrames } from './inspector/frames';
import './inspector/list';
import './inspector/sender';
import type { LfRequestSender } from './inspector/sender';
import { bytesOf, isPoll } from './inspector/wire';

@customElement('lf-page-inspector')
export class LfPageInspector extends LitElement {
  static override styles = [
    base,
    page,
    card,
    fields,
    filters,
    notice,
    css`
      :host {
        height: 100%;
      }
      .page {
        height: 100%;
        min-height: 640px;
      }
      .body {
        flex: 1;
        min-height: 0;
        display: grid;
        grid-template-columns: minmax(0, 1fr) minmax(340px, 400px);
        gap: var(--s3);
      }
      .left {
        display: flex;
        flex-direction: column;
        gap: var(--s2);
        min-height: 0;
        min-width: 0;
      }
      .left > lf-frame-list,
      .left > .blank {
        flex: 1;
      }
      .blank {
        display: grid;
        place-items: center;
      }
      .side {
        min-height: 0;
        overflow: auto;
        display: flex;
        flex-direction: column;
        gap: var(--s3);
      }
      .foot {
        display: flex;
        flex-wrap: wrap;
        gap: 0 var(--s3);
        min-height: 20px;
        font-size: var(--t-note);
        color: var(--dim);
      }
      .foot b {
        color: var(--medium);
      }
      .filters > label.field {
        min-width: 132px;
      }
      @media (max-width: 1080px) {
        :host,
        .page {
          height: auto;
        }
        .body {
          grid-template-columns: 1fr;
        }
        .left > lf-frame-list,
        .left > .blank {
          flex: none;
          height: 420px;
        }
        .side {
          overflow: visible;
        }
      }
    `,
  ];

  @property() monitor: string | null = null;
  @state() private filter: FrameFilter = { text: '', direction: 'both', polls: true };
  @state() private paused: { frames: Kept[]; passed: number } | null = null;
  @state() private chosen: Kept | null = null;
  @state() private missed = 0;
  private readonly frames = new Frames();
  private ends: (() => void)[] = [];
  private drawn = 0;
  private readonly polls = new WeakMap<Kept, boolean>();

  constructor() {
    super();
    new TopicController(this, () => []);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    dictionary().then(
      () => this.requestUpdate(),
      () => {},
    );
    const { monitor } = this;
    if (!monitor) return;
    this.ends = [
      commands.watchFrames(monitor, (frame) => {
        this.frames.add(frame);
        this.draw();
      }),
      socket.on('missed', ({ count }) => (this.missed += count)),
    ];
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.ends.forEach((end) => end());
    cancelAnimationFrame(this.drawn);
  }

  override render() {
    const monitor = this.monitor ?? '';
    const all = this.paused?.frames ?? this.frames.list;
    const shown = shownFrames(all, this.filter, (frame) => this.isPoll(frame));
    return html`<div class="page">
      <header class="head">
        <h1>${t('inspector.title')}</h1>
        ${this.renderActs(shown)}
      </header>
      <lf-request-sender .monitor=${monitor}></lf-request-sender>
      ${this.renderNotice()}
      <div class="body">
        <div class="left">
          <div class="filters">${this.renderFilters()}</div>
          ${
            shown.length > 0
              ? html`<lf-frame-list
                .frames=${shown}
                .selected=${this.chosen?.n ?? 0}
                .label=${t('inspector.frames', { monitor })}
                @choose=${(e: CustomEvent<number>) => (this.chosen = all.find((f) => f.n === e.detail) ?? null)}
              ></lf-frame-list>`
              : this.renderBlank(all.length)
          }
          <div class="foot">
            <span>${t('inspector.count', { shown: num(shown.length), all: num(all.length) })}</span>
            ${
              this.paused
                ? html`<b>${t('inspector.paused', { n: num(this.frames.passed - this.paused.passed) })}</b>`
                : nothing
            }
            ${this.missed > 0 ? html`<span>${t('inspector.missed', { n: num(this.missed) })}</span>` : nothing}
          </div>
        </div>
        <div class="side" tabindex="0">
          <section class="card">
            <header>
              <h2>${t('inspector.decoded')}</h2>
              ${
                this.chosen?.direction === 'out'
                  ? html`<lf-button kind="quiet" icon="edit" @click=${this.repeat}>${t('inspector.repeat')}</lf-button>`
                  : nothing
              }
            </header>
            <lf-frame-decoded .frame=${this.chosen}></lf-frame-decoded>
          </section>
          <section class="card">
            <header><h2>${t('inspector.link')}</h2></header>
            <lf-link-stats .monitor=${monitor}></lf-link-stats>
          </section>
        </div>
      </div>
    </div>`;
  }

  private renderActs(shown: Kept[]) {
    const nothingYet = shown.length ? '' : t('inspector.save_why');
    return html`<lf-button
        id="pause"
        icon=${this.paused ? 'play' : 'pause'}
        toggle
        ?on=${this.paused !== null}
        @click=${this.pause}
        >${t(this.paused ? 'inspector.resume' : 'inspector.pause')}</lf-button
      >
      <lf-button icon="trash" .why=${nothingYet} @click=${this.clear}>${t('inspector.clear')}</lf-button>
      <lf-button icon="download" .why=${nothingYet} @click=${() => this.save(shown)}>${t('inspector.save')}</lf-button>`;
  }

  private renderNotice() {
    if (store.source === 'replay') {
      return html`<div class="notice" role="status">${icon('replay')} ${t('inspector.replay')}</div>`;
    }
    return store.linked
      ? nothing
      : html`<div class="notice" role="status">${icon('unlinked')} ${t('inspector.unlinked')}</div>`;
  }

  private renderFilters() {
    const set = (change: Partial<FrameFilter>) => (this.filter = { ...this.filter, ...change });
    const value = (event: Event) => (event.target as HTMLSelectElement).value;
    const { direction, polls } = this.filter;
    return html`<lf-find
        class="wide"
        .label=${t('inspector.find')}
        .clear=${t('inspector.find_clear')}
        .value=${this.filter.text}
        @find=${(e: CustomEvent<string>) => set({ text: e.detail })}
      ></lf-find>
      <label class="field"
        >${t('inspector.direction')}
        <select name="direction" @change=${(e: Event) => set({ direction: value(e) as FrameFilter['direction'] })}>
          ${(['both', 'out', 'in'] as const).map(
            (way) => html`<option value=${way} ?selected=${way === direction}>${t(`inspector.${way}`)}</option>`,
          )}
        </select>
      </label>
      <label class="field"
        >${t('inspector.polls')}
        <select name="polls" @change=${(e: Event) => set({ polls: value(e) === 'on' })}>
          <option value="on" ?selected=${polls}>${t('inspector.polls_on')}</option>
          <option value="off" ?selected=${!polls}>${t('inspector.polls_off')}</option>
        </select>
      </label>`;
  }

  private renderBlank(hidden: number) {
    return html`<section class="card blank">
      ${
        hidden > 0
          ? html`<lf-blank
            icon="search"
            .head=${t('inspector.none_match')}
            .text=${t('inspector.none_match_text', { n: num(hidden) })}
            ><lf-button @click=${() => (this.filter = { text: '', direction: 'both', polls: true })}
              >${t('inspector.show_all')}</lf-button
            ></lf-blank
          >`
          : html`<lf-blank icon="inspector" .head=${t('inspector.none')} .text=${t('inspector.none_text')}></lf-blank>`
      }
    </section>`;
  }

  private isPoll(frame: Kept): boolean {
    const known = this.polls.get(frame);
    const dict = dictionaryNow();
    if (known !== undefined || !dict) return known ?? false;
    const poll = isPoll(bytesOf(frame.bytes), dict);
    this.polls.set(frame, poll);
    return poll;
  }

  private readonly pause = (): void => {
    this.paused = this.paused ? null : { frames: [...this.frames.list], passed: this.frames.passed };
  };

  private readonly clear = (): void => {
    this.frames.clear();
    this.paused = null;
    this.chosen = null;
    this.missed = 0;
  };

  private readonly repeat = (): void => {
    const first = this.chosen?.text.split(' ; ')[0];
    if (first) this.renderRoot.querySelector<LfRequestSender>('lf-request-sender')?.put(first);
  };

  private save(shown: Kept[]): void {
    const text = `${shown.map(lineOf).join('\n')}\n`;
    saveFile(`lafet-${this.monitor}-${stamp(store.now())}.txt`, 'text/plain;charset=utf-8', text);
  }

  /** Once per frame of the screen, however many frames of the line arrive. */
  private draw(): void {
    if (this.drawn) return;
    this.drawn = requestAnimationFrame(() => {
      this.drawn = 0;
      this.requestUpdate();
    });
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-page-inspector': LfPageInspector;
  }
}
