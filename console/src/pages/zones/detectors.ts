// The detectors of a zone: what each sees, whether it votes, how old its report is.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import type { DetectorState, ZoneState } from '../../hub/api';
import { may } from '../../hub/session';
import { SECOND, store, TopicController } from '../../hub/store';
import { whyNotOrder, zones } from '../../hub/zones';
import { age, t } from '../../i18n';
import '../../parts/lf-button';
import '../../parts/lf-chip';
import { signalWords, unableWords } from '../../shell/zone-words';
import { base, table } from '../../theme/shared';
import { askBypass } from './dialogs';
import { tableStyle } from './style';

@customElement('lf-zone-detectors')
export class LfZoneDetectors extends LitElement {
  static override styles = [
    base,
    table,
    tableStyle,
    css`
      .seen {
        display: flex;
        flex-wrap: wrap;
        gap: var(--s15);
      }
    `,
  ];

  @property() zone = '';

  constructor() {
    super();
    new TopicController(this, () => [SECOND, 'zones']);
  }

  override render() {
    const view = zones.view();
    if (!view) return nothing;
    const ids = zones.configured(this.zone)?.detectors ?? named(zones.zone(this.zone));
    const state = (id: string) => view.state.detectors.find(({ detector }) => detector === id);
    return html`<h3 id="heading">${t('zones.detectors')}</h3>
      <div class="scroll" tabindex="0" role="group" aria-labelledby="heading">
        <table>
          <thead>
            <tr>
              <th>${t('zones.detector')}</th>
              <th>${t('zones.kind')}</th>
              <th>${t('zones.sees')}</th>
              <th>${t('zones.vote')}</th>
              <th>${t('zones.heard')}</th>
              ${may('engineer') ? html`<th><span class="unseen">${t('zones.bypass')}</span></th>` : nothing}
            </tr>
          </thead>
          <tbody>
            ${ids.flatMap((id) => {
              const known = state(id);
              return known ? [this.row(known)] : [];
            })}
          </tbody>
        </table>
      </div>`;
  }

  private row(detector: DetectorState) {
    const id = detector.detector;
    const kind = store.getLive('zones/configured')?.detectors[id];
    const reported = zones.view()?.reported[id];
    const old = zones.unknownFor() !== null;
    const alarm = detector.signal === 'alarm' ? 'high' : detector.signal === 'pre_alarm' ? 'medium' : 'normal';
    return html`<tr>
      <td class="id">${id}</td>
      <td>${kind ? t(`zones.kind_${kind}`) : '—'}</td>
      <td>
        <lf-chip kind=${alarm} icon=${alarm === 'normal' ? '' : 'fire'} ?stale=${old || detector.unable != null}>${signalWords(detector)}</lf-chip>
      </td>
      <td><div class="seen">${this.vote(detector)}</div></td>
      <td title=${reported?.by ?? nothing}>${reported ? t('zones.ago', { age: age(store.hubNow() - reported.at_ms) }) : '—'}</td>
      ${
        may('engineer')
          ? html`<td>
            <lf-button class="bypass" .why=${whyNotOrder('engineer')} @click=${() => void askBypass(detector)}>${t('zones.bypass')}</lf-button>
          </td>`
          : nothing
      }
    </tr>`;
  }

  private vote(detector: DetectorState) {
    const why = unableWords(detector.unable);
    const old = zones.unknownFor() !== null;
    if (why) return html`<lf-chip kind="medium" icon="warning" ?stale=${old}>${why}</lf-chip>`;
    if (detector.stale) return html`<lf-chip kind="medium" icon="clock" ?stale=${old}>${t('zones.no_vote')}</lf-chip>`;
    const votes = zones.zone(this.zone)?.votes.includes(detector.detector);
    return votes
      ? html`<lf-chip kind="high" icon="check" ?stale=${old}>${t('zones.votes')}</lf-chip>`
      : html`<span class="dim">${t('zones.can_vote')}</span>`;
  }
}

/** Of a zone whose configuration has not arrived: those that its state names. */
function named(zone: ZoneState | null): string[] {
  if (!zone) return [];
  return [...new Set([...zone.votes, ...zone.alarms, ...zone.unable.map(({ detector }) => detector)])];
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-zone-detectors': LfZoneDetectors;
  }
}
