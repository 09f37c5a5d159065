// Who of the chain let a request pass, who refused it, who answered.
import { css, html, LitElement, nothing, type TemplateResult } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { type Key, t, tt } from '../i18n';
import { shared } from '../style';
import type { Entry, Mark, Station, Walk } from '../wire';
import { flagList } from './flags';

const SIGNS: Record<Mark, string> = { refused: '✕', answered: '✓', passed: '·', unasked: '–', absent: '∅' };

@customElement('pg-walk')
export class WalkView extends LitElement {
  static override styles = [
    shared,
    css`
      ol {
        display: flex;
        flex-wrap: wrap;
        gap: var(--s1);
        margin: 0;
        padding: 0;
        list-style: none;
      }
      li.station {
        display: grid;
        grid-template-columns: auto 1fr;
        gap: 0 var(--s15);
        padding: var(--s1) var(--s2);
        border: 1px solid var(--line);
        border-radius: var(--radius);
        font-size: var(--t-note);
      }
      li.station small {
        grid-column: 2;
        color: var(--dim);
      }
      li.refused {
        border-color: var(--high);
        background: var(--high-soft);
      }
      li.refused small,
      li.answered small {
        color: var(--text);
      }
      li.answered {
        border-color: var(--accent);
        background: var(--accent-soft);
      }
      li.absent {
        border-style: dashed;
      }
      li.absent b,
      li.unasked b {
        font-weight: 400;
        color: var(--dim);
      }
      details > summary {
        cursor: pointer;
        overflow-wrap: anywhere;
      }
      details[open] > summary {
        margin-bottom: var(--s2);
      }
      .body {
        display: grid;
        gap: var(--s2);
      }
    `,
  ];

  @property({ attribute: false }) entry: Entry | null = null;

  protected override render(): TemplateResult {
    const { entry } = this;
    const walks = entry?.walks ?? [];
    return html`<section class="card" aria-labelledby="walk">
      <h2 id="walk">${t('walk.title')}</h2>
      ${entry?.silence ? html`<p class="error">${tt(entry.silence)}</p>` : nothing}
      ${walks.length === 0 && !entry?.silence ? html`<p class="dim">${t('walk.none')}</p>` : nothing}
      ${walks.map(
        (walk, index) => html`<details ?open=${index === 0}>
          <summary><code>${walk.request}</code> ${walk.verdicts.length === 1 ? verdict(walk) : nothing}</summary>
          ${body(walk)}
        </details>`,
      )}
    </section>`;
  }
}

function verdict(walk: Walk): TemplateResult {
  const one = walk.verdicts[0]!;
  return html`→ <span class="chip ${one.success ? '' : 'warning'}">${one.status}</span> (${one.from})`;
}

function body(walk: Walk): TemplateResult {
  const one = walk.verdicts.find((it) => !it.success) ?? walk.verdicts[0];
  return html`<div class="body">
    <p>${tt(walk.end)}</p>
    ${walk.because.length > 0 ? html`<h3>${t('walk.because')}</h3>${flagList(walk.because)}` : nothing}
    ${
      one
        ? html`<p><b>${one.status}</b>: ${tt(one.meaning)}${
            one.success ? nothing : html` <span class="dim">${t('walk.todo')}: ${tt(one.remedy)}</span>`
          }</p>`
        : nothing
    }
    <ol>
      ${walk.stations.map(station)}
    </ol>
  </div>`;
}

function station({ name, title, mark, addressed }: Station): TemplateResult {
  const role = addressed ? `, ${t('walk.addressee')}` : '';
  return html`<li class="station ${mark}" title=${tt(title)}>
    <span aria-hidden="true">${SIGNS[mark]}</span><b>${name}</b><small>${t(`walk.${mark}` as Key)}${role}</small>
  </li>`;
}
