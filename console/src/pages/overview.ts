import { LitElement, html } from 'lit';
import { customElement } from 'lit/decorators.js';
import { store, TopicController } from '../hub/store';
import { base, page } from '../theme/shared';

@customElement('lf-page-overview')
export class PageOverview extends LitElement {
  static override styles = [base, page];
  constructor() {
    super();
    new TopicController(this, () => 'monitors/');
  }
  override render() {
    return html`<div class="page">${store.monitors().map((id) => html`<a href="#/m/${id}/operate">${id}</a>
      <lf-value quantity="pressure" label="p" .value=${store.get(`monitors/${id}/status`)?.subsystems.General?.pressure ?? null}></lf-value>`)}</div>`;
  }
}
