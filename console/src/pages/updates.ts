// Updating the software of monitors: stored images, what is to be updated, the run.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { HubError } from '../hub/errors';
import { may } from '../hub/session';
import { SECOND, store, TopicController } from '../hub/store';
import type { Updates } from '../hub/types';
import { readUpdates, updatesNow } from '../hub/updates';
import { lang, t } from '../i18n';
import { icon } from '../parts/icons';
import '../parts/lf-blank';
import { base, page } from '../theme/shared';
import { failedNotice, notice } from './alarms/common';
import './updates/images';
import './updates/run';
import './updates/start';

/** A hub that does not publish its images is read again after this time, ms. */
const EVERY_MS = 2000;

@customElement('lf-page-updates')
export class PageUpdates extends LitElement {
  static override styles = [
    base,
    page,
    notice,
    css`
      :host {
        container-type: inline-size;
      }
      .lead {
        color: var(--dim);
        max-width: 80ch;
        line-height: 1.5;
      }
      .columns {
        display: grid;
        grid-template-columns: minmax(0, 1fr) minmax(0, 1fr);
        gap: var(--s3);
        align-items: start;
      }
      .columns.one {
        grid-template-columns: minmax(0, 1fr);
      }
      @container (max-width: 1080px) {
        .columns {
          grid-template-columns: minmax(0, 1fr);
        }
      }
    `,
  ];

  /** Where the hub has not published it. */
  @state() private read: Updates | null = null;
  @state() private off = false;
  @state() private error = '';
  private timer = 0;

  constructor() {
    super();
    new TopicController(this, () => [SECOND, 'updates', 'hub']);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    void this.refresh();
    this.timer = window.setInterval(() => void this.refresh(), EVERY_MS);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
  }

  override render() {
    const updates = updatesNow() ?? this.read;
    return html`<div class="page">
      <header class="head"><h1>${t('updates.title')}</h1></header>
      <p class="lead">${t('updates.lead')}</p>
      ${store.source === 'replay' ? html`<div class="notice" role="status">${icon('info')}<span>${t('updates.live')}</span></div>` : nothing}
      ${updates ? this.content(updates) : this.without()}
    </div>`;
  }

  private content(updates: Updates) {
    const engineer = may('engineer');
    const again = () => void this.refresh();
    return html`${updates.run ? html`<lf-update-run .run=${updates.run}></lf-update-run>` : nothing}
      <div class="columns ${engineer ? '' : 'one'}">
        <lf-update-images .updates=${updates} @changed=${again}></lf-update-images>
        ${engineer ? html`<lf-update-start .updates=${updates} @changed=${again}></lf-update-start>` : nothing}
      </div>`;
  }

  private without() {
    if (this.error) return failedNotice(this.error, () => this.refresh());
    if (this.off) return html`<lf-blank icon="updates" .head=${t('updates.off')}></lf-blank>`;
    return html`<p aria-busy="true">${t('shell.loading')}</p>`;
  }

  private async refresh(): Promise<void> {
    if (updatesNow() || document.hidden || this.off) return;
    try {
      const read = await readUpdates();
      this.error = '';
      // A hub of another version answers with something else, or not at all.
      if (Array.isArray(read?.images)) this.read = read;
      else this.off = true;
    } catch (cause) {
      const error = HubError.of(cause);
      if (error.code === 'not_found' || error.code === 'HTTP 404') this.off = true;
      else this.error = error.text(lang());
    }
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-page-updates': PageUpdates;
  }
}
