// Faults of one monitor, by group, each with a switch.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { lang, plural, t, tt } from '../../i18n';
import { icon } from '../../parts/icons';
import '../../parts/lf-button';
import '../../parts/lf-chip';
import { emit } from '../../parts/part-style';
import { hrefOf } from '../../shell/router';
import { base, card, fields } from '../../theme/shared';
import { type Fault, grouped, type SimState } from './model';

@customElement('lf-training-faults')
export class LfTrainingFaults extends LitElement {
  static override styles = [
    base,
    card,
    fields,
    css`
      .go {
        display: inline-flex;
        align-items: center;
        min-height: 48px;
      }
      .tabs {
        display: flex;
        flex-wrap: wrap;
        gap: var(--s1);
        margin-bottom: var(--s3);
      }
      .tabs button {
        font: inherit;
        font-weight: 600;
        min-height: var(--touch);
        min-width: 72px;
        padding: 0 var(--s25);
        border: 1px solid var(--line);
        border-radius: var(--radius);
        background: transparent;
        color: var(--text);
        cursor: pointer;
        display: inline-flex;
        align-items: center;
        justify-content: center;
        gap: var(--s2);
      }
      .tabs button:hover {
        background: var(--surface-2);
      }
      .tabs button[aria-selected='true'] {
        background: var(--accent-soft);
        border-color: var(--accent);
      }
      .badge {
        min-width: 22px;
        padding: 1px var(--s15);
        border-radius: var(--radius-round);
        background: var(--medium);
        color: var(--surface);
        font-size: var(--t-small);
        font-weight: 700;
      }
      .link {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--s25);
        padding-bottom: var(--s3);
        margin-bottom: var(--s3);
        border-bottom: 1px solid var(--line);
      }
      .link .cut .icon {
        color: var(--medium);
      }
      .state {
        flex: 1;
        display: inline-flex;
        align-items: center;
        gap: var(--s2);
        font-weight: 600;
      }
      .scroll {
        max-height: 560px;
        overflow: auto;
        margin: var(--s25) calc(-1 * var(--s3)) calc(-1 * var(--s3));
        border-top: 1px solid var(--line);
      }
      h3 {
        position: sticky;
        top: 0;
        padding: var(--s2) var(--s3) var(--s15);
        background: var(--surface);
        z-index: 1;
      }
      .fault {
        display: flex;
        align-items: center;
        gap: var(--s25);
        width: 100%;
        min-height: var(--touch);
        padding: var(--s15) var(--s3);
        border: 0;
        background: transparent;
        color: var(--text);
        font: inherit;
        text-align: left;
        line-height: 1.3;
        cursor: pointer;
      }
      .fault:hover {
        background: var(--surface-2);
      }
      .fault:focus-visible {
        outline-offset: -3px;
      }
      .fault[aria-checked='true'] {
        background: var(--medium-soft);
        font-weight: 600;
      }
      .fault[aria-disabled='true'] {
        cursor: not-allowed;
        color: var(--dim);
      }
      .switch {
        flex: none;
        position: relative;
        width: 40px;
        height: 24px;
        border-radius: var(--radius-round);
        border: 2px solid var(--line-strong);
        background: var(--surface);
      }
      .switch::after {
        content: '';
        position: absolute;
        top: 4px;
        left: 4px;
        width: 12px;
        height: 12px;
        border-radius: 50%;
        background: var(--line-strong);
      }
      [aria-checked='true'] .switch {
        background: var(--medium);
        border-color: var(--medium);
      }
      [aria-checked='true'] .switch::after {
        left: 20px;
        background: var(--surface);
      }
      .faulty {
        flex: 1 0 auto;
      }
      .none {
        padding: var(--s3);
        color: var(--dim);
      }
      .foot {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--s2);
        margin-bottom: var(--s2);
        min-height: var(--touch);
      }
    `,
  ];

  @property({ attribute: false }) sim: SimState | null = null;
  @property({ attribute: false }) faults: Fault[] = [];
  @property() why = '';
  @state() private chosen = '';
  @state() private words = '';

  override render() {
    const { sim } = this;
    if (!sim) return nothing;
    const ids = Object.keys(sim.monitors);
    const id = ids.includes(this.chosen) ? this.chosen : ids[0];
    if (!id) return nothing;
    const { faults: active, link } = sim.monitors[id]!;
    const groups = grouped(this.faults, this.words, lang());
    return html`<section class="card" aria-label=${t('training.faults')}>
      <header>
        <h2>${t('training.faults')}</h2>
        <a class="go" href=${hrefOf('operate', id)}>${t('training.operate', { monitor: id })}</a>
      </header>
      <div class="tabs" role="tablist" aria-label=${t('nav.monitor')}>
        ${ids.map((one) => this.tab(one, one === id, sim))}
      </div>
      <div class="link">
        <span class="state ${link === 'up' ? '' : 'cut'}"
          >${icon(link === 'up' ? 'link' : 'unlinked')} ${t(`training.link_${link}`)}</span
        >
        <lf-button .why=${this.why} @click=${() => emit(this, 'link', { monitor: id, up: link !== 'up' })}
          >${link === 'up' ? t('training.cut') : t('training.mend')}</lf-button
        >
      </div>
      <div class="foot">
        <span class="faulty"
          >${
            active.length
              ? html`<lf-chip kind="medium" icon="warning">${plural(active.length, 'training.active')}</lf-chip>`
              : html`<lf-chip>${plural(0, 'training.active')}</lf-chip>`
          }</span
        >
        <lf-button
          .why=${this.why}
          @click=${() => emit(this, 'fault', { monitor: id, fault: 'all', on: false })}
          >${t('training.repair')}</lf-button
        >
      </div>
      <input
        type="search"
        placeholder=${t('training.faults_find')}
        aria-label=${t('training.faults_find')}
        @input=${(event: Event) => (this.words = (event.target as HTMLInputElement).value)}
      />
      <div class="scroll" tabindex="-1">
        ${groups.map(
          ([title, faults]) => html`<h3>${title}</h3>
            ${faults.map((fault) => this.fault(id, fault, active.includes(fault.name)))}`,
        )}
        ${groups.length ? nothing : html`<p class="none">${t('training.faults_none')}</p>`}
      </div>
    </section>`;
  }

  private tab(id: string, on: boolean, sim: SimState) {
    const { faults, link } = sim.monitors[id]!;
    const count = faults.length + Number(link !== 'up');
    return html`<button
      type="button"
      role="tab"
      aria-selected=${on}
      @click=${() => (this.chosen = id)}
    >
      ${id} ${count ? html`<span class="badge">${count}</span>` : nothing}
    </button>`;
  }

  private fault(monitor: string, fault: Fault, on: boolean) {
    return html`<button
      type="button"
      class="fault"
      role="switch"
      aria-checked=${on}
      aria-disabled=${Boolean(this.why)}
      title=${this.why || fault.name}
      @click=${() => !this.why && emit(this, 'fault', { monitor, fault: fault.name, on: !on })}
    >
      <span class="switch"></span><span>${tt(fault.text)}</span>
    </button>`;
  }
}
