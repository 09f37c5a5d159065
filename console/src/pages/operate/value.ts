// A value of a monitor as the pages show it: grey if it is stale, struck out if a flag marks it as bad.
import { html } from 'lit';
import { badText, reading } from '../../hub/readings';
import { store } from '../../hub/store';
import { type Key, t } from '../../i18n';
import '../../parts/lf-value';
import type { Quantity } from '../../units';

export function readingOf(monitor: string, quantity: Quantity, label: Key, subsystem: string, field = 'position') {
  const of = reading(monitor, subsystem, field);
  return html`<lf-value
    quantity=${quantity}
    .label=${t(label)}
    .value=${of.value}
    .bad=${badText(subsystem, of)}
    ?stale=${store.stale(monitor)}
  ></lf-value>`;
}
