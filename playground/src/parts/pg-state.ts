// The state of every subsystem, as GetStatus shows it.
import { css, html, LitElement, nothing, type TemplateResult } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { t, tt } from '../i18n';
import { shared } from '../style';
import type { State } from '../wire';
import { flagList } from './flags';

@customElement('pg-state')
export class StateView extends LitElement {
  static override styles = [
    shared,
    css`
      details {
        border-top: 1px solid var(--line);
        padding: var(--s15) 0;
      }
      summary {
        cursor: pointer;
      }
      summary .chip {
        margin-left: var(--s1);
      }
      .values {
        margin: var(--s1) 0;
        font-size: var(--t-note);
      }
      .bad {
        text-decoration: line-through;
      }
    `,
  ];

  @property({ attribute: false }) states: State[] = [];

  protected override render(): TemplateResult {
    return html`<section class="card" aria-labelledby="state">
      <h2 id="state">${t('state.title')}</h2>
      <p class="dim">${t('state.about')}</p>
      <div>${this.states.map(one)}</div>
    </section>`;
  }
}

function one(state: State): TemplateResult {
  return html`<details>
    <summary>
      <b>${state.name}</b> <span class="dim">${tt(state.title)}</span>
      ${state.flags.map((flag) => html`<span class="chip ${flag.severity}">${flag.name}</span>`)}
    </summary>
    ${state.values.map(
      (value) => html`<p class="values">
        <code>${value.name}</code> <b class=${value.invalid ? 'bad' : ''}>${tt(value.value)}</b>
        ${value.invalid ? html`<span class="chip warning">${t('state.invalid')}</span>` : nothing}
        <span class="dim">${tt(value.meaning)}</span>
      </p>`,
    )}
    ${state.flags.length > 0 ? flagList(state.flags) : html`<p class="dim">${t('state.noflags')}</p>`}
  </details>`;
}
