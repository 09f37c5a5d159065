// The bytes of a frame beside its fields: pointing at one shows the other.
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { t, tt } from '../i18n';
import { shared } from '../style';
import type { Anatomy, Part } from '../wire';
import { flagList } from './flags';

const hex = (byte: number): string => byte.toString(16).padStart(2, '0');

@customElement('pg-bytes')
export class Bytes extends LitElement {
  static override styles = [
    shared,
    css`
      .bytes {
        display: flex;
        flex-wrap: wrap;
        gap: 2px;
        font-family: var(--mono);
        font-size: var(--t-normal);
      }
      .bytes span {
        padding: 1px 3px;
        border-radius: var(--radius-small);
        border-bottom: 2px solid var(--line-strong);
        cursor: default;
      }
      .bytes .link {
        color: var(--dim);
        border-bottom-color: transparent;
      }
      .bytes .odd {
        background: var(--surface-2);
      }
      .bytes .first {
        margin-left: var(--s1);
      }
      .bytes .here,
      [role='option'].here {
        background: var(--accent);
        color: var(--on-accent);
      }
      [role='listbox'] {
        max-height: 340px;
        overflow: auto;
        border: 1px solid var(--line);
        border-radius: var(--radius);
        position: relative;
      }
      [role='group'] > .text {
        padding: var(--s1) var(--s2);
        background: var(--surface-2);
        font-size: var(--t-note);
        overflow-wrap: anywhere;
      }
      [role='option'] {
        display: grid;
        grid-template-columns: minmax(0, 92px) minmax(0, 104px) minmax(0, 1fr);
        gap: var(--s2);
        padding: 2px var(--s2);
        font-size: var(--t-note);
        cursor: default;
      }
      [role='option'] > * {
        overflow-wrap: anywhere;
      }
      [role='option'] .value {
        font-family: var(--mono);
      }
      .detail {
        min-height: 20px;
      }
    `,
  ];

  @property({ attribute: false }) anatomy: Anatomy | null = null;
  @property() heading = '';
  /** Number of the part that is pointed at. */
  @state() private here = -1;

  protected override willUpdate(changed: PropertyValues<this>): void {
    if (changed.has('anatomy')) this.here = -1;
  }

  protected override render(): TemplateResult | typeof nothing {
    const { anatomy } = this;
    if (!anatomy) return nothing;
    const part = anatomy.parts[this.here];
    return html`
      <div class="card">
        <div class="row">
          <h3>${this.heading}</h3>
          <span class="dim">${t('bytes.count', { n: anatomy.bytes.length })}</span>
        </div>
        <div class="bytes" aria-hidden="true" @pointerleave=${() => (this.here = -1)}>
          ${anatomy.parts.map((one, index) => this.byteSpans(one, index, anatomy))}
        </div>
        <div
          role="listbox"
          tabindex="0"
          aria-label="${this.heading}: ${t('bytes.fields')}"
          aria-activedescendant=${part ? `part${this.here}` : nothing}
          @keydown=${this.key}
          @pointerleave=${() => (this.here = -1)}
        >
          ${groups(anatomy).map((group) => this.group(group, anatomy))}
        </div>
        ${part && part.flags.length > 0 ? html`<div class="detail">${flagList(part.flags)}</div>` : nothing}
      </div>
    `;
  }

  private byteSpans(part: Part, index: number, anatomy: Anatomy): TemplateResult[] {
    const kind = part.record === null ? 'link' : part.record % 2 === 1 ? 'odd' : '';
    const bytes = anatomy.bytes.slice(part.at, part.at + part.len);
    return bytes.map(
      (byte, place) =>
        html`<span
          class="${kind} ${place === 0 ? 'first' : ''} ${index === this.here ? 'here' : ''}"
          @pointerenter=${() => this.point(index, true)}
          >${hex(byte)}</span
        >`,
    );
  }

  private group({ record, parts }: Group, anatomy: Anatomy): TemplateResult {
    const name = record === null ? t('bytes.link') : t('bytes.record', { n: record + 1 });
    const text = record === null ? '' : (anatomy.text[record] ?? '');
    return html`<div role="group" aria-label=${name}>
      <div class="text" aria-hidden="true"><b>${name}</b> <code>${text}</code></div>
      ${parts.map(
        ([index, part]) => html`<div
          role="option"
          id="part${index}"
          aria-selected=${index === this.here}
          class=${index === this.here ? 'here' : ''}
          @pointerenter=${() => this.point(index, false)}
          @click=${() => this.point(index, false)}
        >
          <code>${part.name}</code>
          <span class="value">${tt(part.value)}</span>
          <span>${tt(part.meaning)}${part.flags.length > 0 ? `: ${part.flags.map((it) => it.name).join(', ')}` : ''}</span>
        </div>`,
      )}
    </div>`;
  }

  private point(index: number, scrolls: boolean): void {
    this.here = index;
    if (scrolls) void this.reveal();
  }

  /** The field comes into view within its list; the page stays where it is. */
  private async reveal(): Promise<void> {
    await this.updateComplete;
    const list = this.renderRoot.querySelector<HTMLElement>('[role=listbox]');
    const option = this.renderRoot.querySelector<HTMLElement>(`#part${this.here}`);
    if (!list || !option) return;
    const top = option.offsetTop;
    if (top < list.scrollTop) list.scrollTop = top;
    const below = top + option.offsetHeight - list.clientHeight;
    if (below > list.scrollTop) list.scrollTop = below;
  }

  private key(event: KeyboardEvent): void {
    const count = this.anatomy?.parts.length ?? 0;
    const to = { ArrowDown: this.here + 1, ArrowUp: this.here - 1, Home: 0, End: count - 1 }[event.key];
    if (to === undefined || count === 0) return;
    event.preventDefault();
    this.point(Math.min(Math.max(to, 0), count - 1), true);
  }
}

interface Group {
  record: number | null;
  parts: [number, Part][];
}

/** Parts that follow each other and belong to the same record. */
function groups({ parts }: Anatomy): Group[] {
  const all: Group[] = [];
  parts.forEach((part, index) => {
    const last = all.at(-1);
    if (last && last.record === part.record) last.parts.push([index, part]);
    else all.push({ record: part.record, parts: [[index, part]] });
  });
  return all;
}
