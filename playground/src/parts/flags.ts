import { html, nothing, type TemplateResult } from 'lit';
import { tt } from '../i18n';
import type { Flag } from '../wire';

/** Flags, each with its meaning. */
export function flagList(flags: readonly Flag[]): TemplateResult | typeof nothing {
  if (flags.length === 0) return nothing;
  return html`<ul class="flags">
    ${flags.map(
      (flag) => html`<li><span class="chip ${flag.severity}">${flag.name}</span> <span>${tt(flag.meaning)}</span></li>`,
    )}
  </ul>`;
}
