// A decoded frame: records, headers, fields, each with its bytes.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { dictionaryNow } from '../../hub/dictionary';
import { lang, num, t, tt } from '../../i18n';
import { inUnit, unitText } from '../../units';
import '../../parts/lf-blank';
import '../../parts/lf-button';
import { base } from '../../theme/shared';
import type { Kept } from './frames';
import { clock } from './list';
import { bytesOf, decode, HEADER, hexOf, type WireField, type WireRecord } from './wire';

@customElement('lf-frame-decoded')
export class LfFrameDecoded extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
      }
      .head {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--s1) var(--s3);
        font-size: var(--t-note);
        color: var(--dim);
        margin-bottom: var(--s2);
      }
      .bytes {
        display: flex;
        flex-wrap: wrap;
        gap: var(--s05) 0;
        font-family: var(--mono);
        font-size: var(--t-note);
        padding: var(--s2);
        margin-bottom: var(--s3);
        background: var(--sunken);
        border-radius: var(--radius);
        max-height: 148px;
        overflow: auto;
      }
      .bytes span {
        padding: 1px var(--s1);
        border-radius: var(--radius-small);
      }
      .bytes .record {
        border-left: 2px solid var(--line-strong);
      }
      .bytes .lit {
        background: var(--accent);
        color: var(--on-accent);
      }
      details {
        border-top: 1px solid var(--line);
      }
      summary {
        display: flex;
        align-items: center;
        gap: var(--s2);
        min-height: 48px;
        cursor: pointer;
        list-style: none;
        font-weight: 600;
      }
      summary::-webkit-details-marker {
        display: none;
      }
      summary::before {
        content: '›';
        font-size: var(--t-title);
        width: 14px;
        text-align: center;
        color: var(--dim);
      }
      details[open] > summary::before {
        transform: rotate(90deg);
      }
      summary .grow {
        overflow-wrap: anywhere;
      }
      .status {
        font-size: var(--t-note);
        font-weight: 600;
        color: var(--dim);
      }
      .bad {
        color: var(--medium);
      }
      .fields {
        display: grid;
        grid-template-columns: minmax(96px, max-content) minmax(0, 1fr) max-content;
        gap: 0 var(--s3);
        margin: 0 0 var(--s2) var(--s4);
      }
      .field {
        display: grid;
        grid-column: 1 / -1;
        grid-template-columns: subgrid;
        align-items: baseline;
        padding: var(--s1) var(--s15);
        border-radius: var(--radius-small);
      }
      .field:hover,
      .field:focus-visible {
        background: var(--surface-2);
      }
      .name {
        color: var(--dim);
        font-size: var(--t-note);
      }
      .value {
        font-weight: 600;
        overflow-wrap: anywhere;
      }
      .about {
        display: block;
        font-size: var(--t-small);
        font-weight: 400;
        color: var(--dim);
      }
      .raw {
        font-family: var(--mono);
        font-size: var(--t-small);
        color: var(--dim);
        max-width: 96px;
        overflow-wrap: anywhere;
        text-align: right;
      }
      .note {
        margin: 0 0 var(--s2) var(--s5);
        font-size: var(--t-note);
        color: var(--medium);
        font-weight: 600;
      }
    `,
  ];

  @property({ attribute: false }) frame: Kept | null = null;
  @state() private lit: [number, number] | null = null;

  override willUpdate(changed: Map<PropertyKey, unknown>): void {
    if (changed.has('frame')) this.lit = null;
  }

  override render() {
    const { frame } = this;
    const dict = dictionaryNow();
    if (!frame || !dict) {
      return html`<lf-blank icon="inspector" .head=${t('inspector.choose')} .text=${t('inspector.choose_text')}></lf-blank>`;
    }
    const bytes = bytesOf(frame.bytes);
    const records = decode(bytes, frame.direction === 'out', dict);
    return html`<div class="head">
        <span>${t('inspector.frame_at', { time: clock(frame.at_ms), src: frame.src, dst: frame.dst })}</span>
        <span>${t('inspector.bytes', { n: num(bytes.length) })}</span>
        ${frame.took_ms === null ? nothing : html`<span>${t('inspector.took', { took: `${num(frame.took_ms)} ${unitText('duration_ms')}` })}</span>`}
      </div>
      <div class="bytes" tabindex="0" role="region" aria-label=${t('inspector.bytes', { n: num(bytes.length) })}>
        ${bytes.map(
          (
            byte,
            at,
          ) => html`<span class="${this.isLit(at) ? 'lit' : ''} ${records.some((r) => r.from === at) && at > 0 ? 'record' : ''}"
            >${byte.toString(16).padStart(2, '0')}</span
          >`,
        )}
      </div>
      ${records.map((record, index) => this.renderRecord(record, index, records.length, frame, bytes))}`;
  }

  private renderRecord(record: WireRecord, index: number, of: number, frame: Kept, bytes: number[]) {
    const out = frame.direction === 'out';
    const { from } = record;
    const sub = dictionaryNow()?.subsystems.find((s) => s.id === record.device)?.[lang()] ?? '';
    const status = dictionaryNow()?.statuses.find((s) => s.value === record.status);
    const request = dictionaryNow()?.requests.find((r) => r.id === record.request);
    return html`<details ?open=${of <= 3 || record.fields.some((f) => f.names.length > 0)}>
      <summary @pointerenter=${() => (this.lit = [from, record.to])} @pointerleave=${() => (this.lit = null)}>
        <span class="grow">${record.requestName} · ${record.deviceName}</span>
        ${out ? nothing : html`<span class="status ${status?.success === false ? 'bad' : ''}">${record.statusName}</span>`}
      </summary>
      <div class="fields" aria-label=${t('inspector.record', { n: index + 1, of })}>
        ${this.row(t('inspector.request'), record.requestName, tt(request?.title), from, from + 1, bytes)}
        ${this.row(t(out ? 'inspector.device_to' : 'inspector.device_from'), record.deviceName, sub, from + 1, from + 2, bytes)}
        ${
          out
            ? nothing
            : this.row(
                t('inspector.status'),
                record.statusName,
                status?.success ? '' : tt(status?.meaning),
                from + 2,
                from + 3,
                bytes,
              )
        }
        ${this.row(
          t('inspector.size'),
          t('inspector.bytes', { n: record.size }),
          record.layout ? t('inspector.layout', { name: record.layout }) : '',
          from + 3,
          from + HEADER,
          bytes,
        )}
        ${record.fields.map((field) => this.row(field.name, wireValue(field), tt(field.text), field.from, field.to, bytes))}
      </div>
      ${record.broken ? html`<p class="note">${t('inspector.broken', { size: record.size })}</p>` : nothing}
      ${record.rest ? html`<p class="note">${t('inspector.rest')}</p>` : nothing}
    </details>`;
  }

  private row(name: string, value: string, about: string, from: number, to: number, bytes: number[]) {
    const raw = bytes.slice(from, to).map((byte) => byte.toString(16).padStart(2, '0'));
    return html`<div
      class="field"
      @pointerenter=${() => (this.lit = [from, to])}
      @pointerleave=${() => (this.lit = null)}
    >
      <span class="name">${name}</span>
      <span class="value">${value}${about ? html`<span class="about">${about}</span>` : nothing}</span>
      <span class="raw">${raw.join(' ')}</span>
    </div>`;
  }

  private isLit(at: number): boolean {
    return this.lit !== null && at >= this.lit[0] && at < this.lit[1];
  }
}

function wireValue(field: WireField): string {
  if (field.type === 'Flags') {
    const names = field.names.join(', ') || t('inspector.no_flags');
    return field.value ? `${names} (${hexOf(field.value, 8)})` : names;
  }
  if (field.names.length > 0) return field.names.join(', ');
  const unit = tt(field.unit);
  const scaled = /^×0[.,]1 (.+)$/.exec(unit);
  if (scaled) return `${num(field.value / 10, 1)} ${scaled[1]}`;
  return inUnit(num(field.value), unit === "'" ? '′' : unit);
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-frame-decoded': LfFrameDecoded;
  }
}
