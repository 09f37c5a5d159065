// The cameras that look at a monitor, on the picture of Operate: one at a time, small over the plan or in its place.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, query, state } from 'lit/decorators.js';
import type { CameraView } from '../../hub/api';
import { CameraStream, camerasOf } from '../../hub/cameras';
import { store, TopicController } from '../../hub/store';
import { t, tt } from '../../i18n';
import '../../parts/lf-button';
import '../../parts/lf-picture';
import type { LfPicture } from '../../parts/lf-picture';
import { base } from '../../theme/shared';

const LARGE_KEY = 'lafet.camera.large';

@customElement('lf-camera')
export class LfCamera extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-rows: auto minmax(0, 1fr);
        background: var(--surface);
        border: 1px solid var(--line);
        border-radius: var(--radius);
        box-shadow: var(--shadow);
        overflow: hidden;
        --lf-button-size: var(--t-note);
      }
      header {
        display: flex;
        align-items: center;
        gap: var(--s1);
        padding-left: var(--s2);
        min-width: 0;
      }
      .name {
        flex: 1;
        min-width: 0;
        overflow: hidden;
        text-overflow: ellipsis;
        white-space: nowrap;
        font-size: var(--t-note);
        font-weight: 600;
      }
      select {
        flex: 1;
        min-width: 0;
        min-height: var(--touch);
        font: inherit;
        font-size: var(--t-field);
        color: var(--text);
        background: var(--surface);
        border: 1px solid var(--line-strong);
        border-radius: var(--radius);
      }
      lf-picture {
        width: 100%;
        height: 100%;
        min-height: 0;
      }
    `,
  ];

  @property() monitor = '';
  @property({ type: Boolean, reflect: true }) large = localStorage.getItem(LARGE_KEY) === 'true';
  @state() private chosen = '';
  @state() private hiddenPage = document.hidden;
  @query('lf-picture') private picture?: LfPicture;
  private stream: CameraStream | null = null;
  /** The camera whose pictures come. */
  private streamed = '';

  constructor() {
    super();
    new TopicController(this, () => 'cameras/');
  }

  override connectedCallback(): void {
    super.connectedCallback();
    document.addEventListener('visibilitychange', this.seen);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    document.removeEventListener('visibilitychange', this.seen);
    this.end();
  }

  private get camera(): CameraView | undefined {
    const all = camerasOf(this.monitor);
    return all.find((camera) => camera.id === this.chosen) ?? all[0];
  }

  override render() {
    const { camera } = this;
    if (!camera) return nothing;
    const all = camerasOf(this.monitor);
    const replayed = store.source === 'replay';
    const choose = (event: Event) => (this.chosen = (event.target as HTMLSelectElement).value);
    return html`<header>
        ${
          all.length > 1
            ? html`<select aria-label=${t('operate.camera')} @change=${choose}>
                ${all.map(({ id, name }) => html`<option value=${id} ?selected=${id === camera.id}>${tt(name)}</option>`)}
              </select>`
            : html`<span class="name">${tt(camera.name)}</span>`
        }
        <lf-button kind="quiet" @click=${this.turn}>${t(this.large ? 'operate.camera_small' : 'operate.camera_large')}</lf-button>
        <lf-button kind="quiet" icon="close" label=${t('operate.camera_hide')} @click=${this.hide}></lf-button>
      </header>
      <lf-picture
        .label=${t('operate.camera_of', { name: tt(camera.name) })}
        .why=${replayed ? t('operate.camera_replay') : tt(camera.why)}
        .now=${() => store.hubNow()}
        @taken=${(event: CustomEvent<number>) => this.stream?.hasTaken(event.detail)}
      ></lf-picture>`;
  }

  override updated(): void {
    // A page that is not seen, and one that shows what was, need no picture of now.
    const live = !this.hiddenPage && store.source === 'live';
    const wanted = live ? (this.camera?.id ?? '') : '';
    if (wanted === this.streamed) return;
    this.end();
    this.streamed = wanted;
    if (wanted) this.stream = new CameraStream(wanted, (unit) => this.picture?.push(unit));
  }

  private end(): void {
    this.stream?.close();
    this.stream = null;
    this.streamed = '';
    this.picture?.clear();
  }

  private readonly seen = (): void => {
    this.hiddenPage = document.hidden;
  };

  private readonly turn = (): void => {
    this.large = !this.large;
    localStorage.setItem(LARGE_KEY, String(this.large));
  };

  private readonly hide = (): void => {
    this.dispatchEvent(new CustomEvent('hide'));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-camera': LfCamera;
  }
}
