// Verification of the audit log, and a copy of it.
import { html, LitElement, nothing } from 'lit';
import { customElement, state } from 'lit/decorators.js';
import { HubError } from '../../hub/errors';
import { http } from '../../hub/http';
import { lang, num, t, time } from '../../i18n';
import { icon } from '../../parts/icons';
import '../../parts/lf-button';
import { toast } from '../../shell/toasts';
import { base, card } from '../../theme/shared';
import { whyNotHere } from '../alarms/common';
import { eventStyle } from './style';

interface Verified {
  ok: boolean;
  entries: number;
  head: string;
  bad: number | null;
}

@customElement('lf-audit-chain')
export class LfAuditChain extends LitElement {
  static override styles = [base, card, eventStyle];

  @state() private found: Verified | null = null;
  @state() private error = '';
  @state() private checking = false;
  @state() private at_ms = 0;
  @state() private told = false;

  override connectedCallback(): void {
    super.connectedCallback();
    void this.check();
  }

  override render() {
    const { found } = this;
    const bad = found !== null && !found.ok;
    return html`<section class="card chain ${bad ? 'bad' : ''}" aria-label=${t('events.chain_title')}>
      <div>
        <div class="row wrap" role="status">${this.renderState()}</div>
        ${
          found
            ? html`<div class="small dim">
              ${t('events.chain_head')}: <span class="hash" title=${found.head}>${short(found.head)}</span> ·
              ${t('events.chain_at', { time: time(this.at_ms) })}
            </div>`
            : nothing
        }
      </div>
      <div class="acts">
        <lf-button
          kind="quiet"
          icon="help"
          toggle
          ?on=${this.told}
          .label=${t('events.chain_title')}
          @click=${() => (this.told = !this.told)}
        ></lf-button>
        <lf-button
          kind="quiet"
          icon="refresh"
          .why=${this.checking ? t('events.chain_checking') : whyNotHere('operator')}
          @click=${this.check}
          >${t('events.check')}</lf-button
        >
        <lf-button kind="quiet" .why=${found ? '' : t('events.chain_checking')} @click=${this.copy}
          >${t('events.copy')}</lf-button
        >
        <lf-button icon="download" id="export" .why=${whyNotHere('engineer')} @click=${this.save}
          >${t('events.export')}</lf-button
        >
      </div>
      ${
        bad
          ? html`<p class="about">${t('events.chain_bad_text')}</p>`
          : this.told
            ? html`<p class="about small dim">${t('events.chain_text')}</p>`
            : nothing
      }
    </section>`;
  }

  private renderState() {
    const { found } = this;
    if (this.error) return html`${icon('warning')} <span class="ok">${t('events.chain_failed')}: ${this.error}</span>`;
    if (!found) return html`${icon('clock')} ${t('events.chain_checking')}`;
    return found.ok
      ? html`${icon('check')} <span class="ok">${t('events.chain_ok', { n: num(found.entries) })}</span>`
      : html`${icon('alarm')} <span class="ok">${t('events.chain_bad', { n: num(found.bad ?? 0) })}</span>`;
  }

  private readonly check = async (): Promise<void> => {
    this.checking = true;
    try {
      this.found = await http.get<Verified>('/api/audit/verify');
      this.error = '';
    } catch (cause) {
      this.error = HubError.of(cause).text(lang());
    }
    this.at_ms = Date.now();
    this.checking = false;
  };

  private readonly copy = async (): Promise<void> => {
    await navigator.clipboard?.writeText(this.found?.head ?? '');
    toast({ kind: 'ok', text: t('events.copied') });
  };

  /** The browser receives it in pieces: a long log need not fit into the page. */
  private readonly save = (): void => {
    const link = document.createElement('a');
    link.href = '/api/audit/export';
    link.download = 'lafet-audit.jsonl';
    link.click();
    toast({ kind: 'info', text: t('events.export_text') });
  };
}

function short(hash: string): string {
  return `${hash.slice(0, 12)}…${hash.slice(-8)}`;
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-audit-chain': LfAuditChain;
  }
}
