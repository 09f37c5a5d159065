// The images that the hub stores: the list, sending files to it, removing.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { HubError } from '../../hub/errors';
import { may } from '../../hub/session';
import type { StoredImage, Updates } from '../../hub/types';
import { removeImage, storeImage } from '../../hub/updates';
import { dateTime, lang, num, t } from '../../i18n';
import '../../parts/lf-blank';
import '../../parts/lf-button';
import { sizeText } from '../../parts/words';
import { confirmDialog } from '../../shell/dialog';
import { toast } from '../../shell/toasts';
import { base, card, table } from '../../theme/shared';
import { notice, whyNotHere } from '../alarms/common';
import { faultOf, IMAGES_MAX } from './model';
import { updateStyle } from './style';
import { shortDigest, slotWords } from './words';

/** A file that is not stored, and why. */
interface Refused {
  name: string;
  why: string;
}

/** What the hub has stored has changed; a hub that publishes it needs no question. */
export const CHANGED = 'changed';

@customElement('lf-update-images')
export class LfUpdateImages extends LitElement {
  static override styles = [
    base,
    card,
    table,
    notice,
    updateStyle,
    css`
      :host {
        container-type: inline-size;
      }
      .scroll {
        overflow-x: auto;
        margin-inline: calc(-1 * var(--s3));
      }
      th:first-child,
      td:first-child {
        padding-left: var(--s3);
      }
      td.acts {
        text-align: right;
        white-space: nowrap;
      }
      .drop {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--s2) var(--s3);
        padding: var(--s3);
        border: 2px dashed var(--line-strong);
        border-radius: var(--radius);
        color: var(--dim);
      }
      .drop.over {
        border-color: var(--accent);
        background: var(--accent-soft);
        color: var(--text);
      }
      input[type='file'] {
        display: none;
      }
      .refused {
        align-items: start;
      }
      .refused li {
        font-weight: 400;
        overflow-wrap: anywhere;
      }
      @container (max-width: 640px) {
        thead {
          display: none;
        }
        table,
        tbody {
          display: block;
        }
        tbody tr {
          display: grid;
          grid-template-columns: minmax(0, 1fr) auto;
          gap: var(--s05) var(--s2);
          padding: var(--s2) var(--s3);
          border-bottom: 1px solid var(--line);
        }
        tbody td {
          display: block;
          padding: 0 !important;
          border: 0;
          grid-column: 1;
        }
        td.num {
          text-align: left;
        }
        td[data-label]::before {
          content: attr(data-label) ': ';
          color: var(--dim);
        }
        td.acts {
          grid-area: 1 / 2 / span 4 / auto;
          align-self: center;
        }
      }
    `,
  ];

  @property({ attribute: false }) updates!: Updates;
  /** Of the file that is being sent. */
  @state() private sending = '';
  @state() private refused: readonly Refused[] = [];
  @state() private over = false;

  override connectedCallback(): void {
    super.connectedCallback();
    // A file that misses the field would be opened in place of this page, and of its STOP.
    for (const type of ['dragover', 'drop'] as const) window.addEventListener(type, keepPage);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    for (const type of ['dragover', 'drop'] as const) window.removeEventListener(type, keepPage);
  }

  override render() {
    const { images } = this.updates;
    return html`<section class="card" aria-labelledby="images">
      <header><h2 id="images">${t('updates.images')}</h2></header>
      ${
        images.length
          ? this.renderTable(images)
          : html`<lf-blank icon="updates" .head=${t('updates.images_none')} .text=${t('updates.images_none_text')}></lf-blank>`
      }
      ${this.renderRefused()} ${may('engineer') ? this.renderDrop() : nothing}
    </section>`;
  }

  private renderTable(images: readonly StoredImage[]) {
    return html`<div class="scroll" tabindex="0" role="region" aria-labelledby="images">
      <table>
        <thead>
          <tr>
            <th>${t('updates.version')}</th>
            <th>${t('updates.board')}</th>
            <th>${t('updates.slot')}</th>
            <th class="num">${t('updates.key')}</th>
            <th class="num">${t('updates.size')}</th>
            <th>${t('updates.stored_by')}</th>
            ${may('engineer') ? html`<th><span class="unseen">${t('updates.remove')}</span></th>` : nothing}
          </tr>
        </thead>
        <tbody>
          ${images.map((one) => this.renderImage(one))}
        </tbody>
      </table>
    </div>`;
  }

  private renderImage(one: StoredImage) {
    const { run } = this.updates;
    const used = run?.state === 'running' && run.images.includes(one.digest);
    return html`<tr data-digest=${one.digest}>
      <td>
        <span class="who">${one.version}</span>
        <div class="small dim mono" title=${one.digest}>${shortDigest(one.digest)}…</div>
      </td>
      <td data-label=${t('updates.board')}>${one.board}</td>
      <td data-label=${t('updates.slot')}>${slotWords(one)}</td>
      <td class="num" data-label=${t('updates.key')}>${num(one.key)}</td>
      <td class="num" data-label=${t('updates.size')}>${sizeText(one.size)}</td>
      <td>${one.by}<div class="small dim">${dateTime(one.at_ms)}</div></td>
      ${
        may('engineer')
          ? html`<td class="acts">
            <lf-button
              kind="quiet"
              icon="trash"
              data-act="remove"
              .label=${t('updates.remove_one', { version: one.version, board: one.board, slot: slotWords(one) })}
              .why=${whyNotHere('engineer') || (used ? t('updates.in_use') : '')}
              @click=${() => this.discard(one)}
            ></lf-button>
          </td>`
          : nothing
      }
    </tr>`;
  }

  private renderDrop() {
    return html`<div
      class="drop ${this.over ? 'over' : ''}"
      @dragover=${this.dragged}
      @dragleave=${() => (this.over = false)}
      @drop=${this.dropped}
    >
      <lf-button id="choose" icon="upload" .why=${this.whyNotStore()} @click=${this.choose}
        >${t('updates.choose')}</lf-button
      >
      <span role="status">${this.sending ? t('updates.sending', { name: this.sending }) : t('updates.drop')}</span>
      <input type="file" multiple aria-label=${t('updates.choose')} tabindex="-1" @change=${this.chosen} />
    </div>`;
  }

  /** It stays until the next files, or until it is dismissed. */
  private renderRefused() {
    if (this.refused.length === 0) return nothing;
    return html`<div class="notice bad refused" role="alert">
      <div class="grow">
        ${t('updates.not_stored')}
        <ul>
          ${this.refused.map(({ name, why }) => html`<li><b>${name}</b>: ${why}</li>`)}
        </ul>
      </div>
      <lf-button kind="quiet" icon="close" .label=${t('shell.close')} @click=${() => (this.refused = [])}></lf-button>
    </div>`;
  }

  private whyNotStore(): string {
    if (this.sending) return t('updates.sending', { name: this.sending });
    const full = this.updates.images.length >= IMAGES_MAX;
    return whyNotHere('engineer') || (full ? t('updates.full', { n: num(IMAGES_MAX) }) : '');
  }

  private choose(): void {
    this.renderRoot.querySelector<HTMLInputElement>('input[type=file]')?.click();
  }

  private chosen(event: Event): void {
    const input = event.target as HTMLInputElement;
    const files = [...(input.files ?? [])];
    input.value = '';
    void this.store(files);
  }

  private dragged(event: DragEvent): void {
    event.preventDefault();
    event.stopPropagation();
    this.over = this.whyNotStore() === '';
    if (event.dataTransfer) event.dataTransfer.dropEffect = this.over ? 'copy' : 'none';
  }

  private dropped(event: DragEvent): void {
    event.preventDefault();
    event.stopPropagation();
    this.over = false;
    void this.store([...(event.dataTransfer?.files ?? [])]);
  }

  /** One after the other: the hub takes one at a time. */
  private async store(files: readonly File[]): Promise<void> {
    if (files.length === 0) return;
    const refused: Refused[] = [];
    for (const file of files) {
      const why = await this.storeOne(file);
      if (why) refused.push({ name: file.name, why });
    }
    this.refused = refused;
    this.dispatchEvent(new CustomEvent(CHANGED));
  }

  /** Why it is not stored; empty: it is. */
  private async storeOne(file: File): Promise<string> {
    const why = this.whyNotStore();
    if (why) return why;
    const fault = await faultOf(file);
    if (fault) return t(`updates.file_${fault}`, { most: num(16) });
    this.sending = file.name;
    try {
      const known = this.updates.images.map(({ digest }) => digest);
      const { version, board, digest } = await storeImage(file);
      const key = known.includes(digest) ? 'updates.stored_before' : 'updates.stored';
      toast({ kind: 'ok', text: t(key, { name: file.name, version, board }) });
      return '';
    } catch (cause) {
      return HubError.of(cause).text(lang());
    } finally {
      this.sending = '';
    }
  }

  private async discard({ digest, version, board }: StoredImage): Promise<void> {
    const sure = await confirmDialog({
      title: t('updates.remove_title'),
      text: t('updates.remove_text', { version, board }),
      yes: t('updates.remove'),
      danger: true,
      why: () => whyNotHere('engineer'),
    });
    if (!sure) return;
    try {
      await removeImage(digest);
    } catch (cause) {
      toast({ kind: 'error', text: HubError.of(cause).text(lang()) });
    }
    this.dispatchEvent(new CustomEvent(CHANGED));
  }
}

function keepPage(event: DragEvent): void {
  event.preventDefault();
  if (event.dataTransfer) event.dataTransfer.dropEffect = 'none';
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-update-images': LfUpdateImages;
  }
}
