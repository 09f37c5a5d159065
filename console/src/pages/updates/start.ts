// What is to be updated, what will happen, and its start.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { HubError } from '../../hub/errors';
import { SECOND, store, TopicController } from '../../hub/store';
import type { Updates } from '../../hub/types';
import { startUpdate } from '../../hub/updates';
import { dateTime, type Key, lang, plural, t } from '../../i18n';
import { icon } from '../../parts/icons';
import '../../parts/lf-button';
import '../../parts/lf-hold';
import { dialog } from '../../shell/dialog';
import { base, card, fields } from '../../theme/shared';
import { monitorName, notice, whyNotHere } from '../alarms/common';
import { factsOf, missingNow, zonesKnown } from './facts';
import { CHANGED } from './images';
import { type Choice, choicesOf, type Group, groupsOf, type Missing, slotsOf, versionOf, zonesOf } from './model';
import { updateStyle } from './style';
import { choiceSlots, missingWords, shortDigest } from './words';

/** What a run does, one sentence each. */
const HAPPENS: readonly Key[] = [
  'updates.happens_order',
  'updates.happens_lockout',
  'updates.happens_checks',
  'updates.happens_still',
  'updates.happens_trial',
  'updates.happens_failed',
];
const PACES = [10, 20, 50, 100] as const;
const HOLD_S = 2;

@customElement('lf-update-start')
export class LfUpdateStart extends LitElement {
  static override styles = [
    base,
    card,
    fields,
    notice,
    updateStyle,
    css`
      fieldset {
        min-width: 0;
        margin: 0;
        padding: 0;
        border: 0;
      }
      legend {
        padding: 0 0 var(--s1);
        font-size: var(--t-small);
        font-weight: 650;
        color: var(--dim);
      }
      .pick {
        display: flex;
        align-items: center;
        gap: var(--s25);
        min-height: var(--touch);
        padding: var(--s1) var(--s2);
        border-radius: var(--radius);
        cursor: pointer;
      }
      .pick:hover {
        background: var(--surface-2);
      }
      .pick input {
        flex: none;
        margin: 0;
      }
      .pick > span {
        min-width: 0;
        overflow-wrap: anywhere;
      }
      .pick .missing {
        color: var(--text);
      }
      .groups {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(260px, 100%), 1fr));
        gap: var(--s2) var(--s3);
        align-items: start;
      }
      label.field {
        max-width: 320px;
      }
    `,
  ];

  @property({ attribute: false }) updates!: Updates;
  @state() private key = '';
  @state() private ticked: ReadonlySet<string> = new Set();
  @state() private pace: number | null = null;
  @state() private busy = false;
  @state() private failed = '';

  constructor() {
    super();
    new TopicController(this, () => [SECOND, 'monitors/', 'zones']);
  }

  override render() {
    const choices = choicesOf(this.updates.images);
    const ids = store.liveMonitors();
    return html`<section class="card" aria-labelledby="update">
      <header><h2 id="update">${t('updates.update')}</h2></header>
      ${this.renderChoices(choices)} ${this.renderMonitors(ids)} ${this.renderPace()}
      <div>
        <h3>${t('updates.happens')}</h3>
        ${happens()}
      </div>
      ${this.renderEnd()}
      ${this.failed ? html`<div class="notice bad" role="alert">${this.failed}</div>` : nothing}
      <div class="row wrap">
        <lf-button id="update-start" kind="primary" icon="updates" .why=${this.whyNot()} @click=${this.ask}
          >${t('updates.start')}</lf-button
        >
        <span class="dim" role="status">${plural(this.chosenIds().length, 'updates.chosen')}</span>
      </div>
    </section>`;
  }

  private renderChoices(choices: readonly Choice[]) {
    const chosen = this.choice();
    return html`<fieldset id="versions">
      <legend>${t('updates.version')}</legend>
      ${choices.length ? nothing : html`<p class="dim">${t('updates.no_choice')}</p>`}
      ${choices.map(
        (one) => html`<label class="pick">
          <input
            type="radio"
            name="version"
            data-key=${one.key}
            .checked=${one.key === chosen?.key}
            @change=${() => (this.key = one.key)}
          />
          <span
            ><b>${one.images[0]!.version}</b> · ${one.images[0]!.board} · ${choiceSlots(one)}
            <span class="small dim mono">${one.images.map(({ digest }) => shortDigest(digest)).join(' ')}</span>
            ${
              slotsOf(one) === 'a' || slotsOf(one) === 'b'
                ? html`<div class="small dim">${t(`updates.only_${slotsOf(one) as 'a' | 'b'}`)}</div>`
                : nothing
            }
          </span>
        </label>`,
      )}
    </fieldset>`;
  }

  private renderMonitors(ids: readonly string[]) {
    const groups = groupsOf(ids, zonesKnown());
    const zoned = groups.some(({ zone }) => zone !== null);
    return html`<fieldset id="monitors">
      <legend>${t('updates.monitors')}</legend>
      ${this.renderAll(t('shell.all_monitors'), ids, '')}
      <div class="groups">${groups.map((group) => this.renderGroup(group, zoned))}</div>
    </fieldset>`;
  }

  private renderGroup({ zone, monitors }: Group, zoned: boolean) {
    const title = zone === null ? t('updates.no_zone') : t('updates.zone', { zone });
    if (!zoned) return html`${monitors.map((id) => this.renderMonitor(id, zone))}`;
    return html`<fieldset data-zone=${zone ?? ''}>
      <legend>${title}</legend>
      ${monitors.length > 1 ? this.renderAll(t('updates.all_of', { zone: title }), monitors, zone ?? '') : nothing}
      ${monitors.map((id) => this.renderMonitor(id, zone))}
    </fieldset>`;
  }

  private renderAll(text: string, ids: readonly string[], zone: string) {
    const count = ids.filter((id) => this.ticked.has(id)).length;
    const all = count > 0 && count === ids.length;
    return html`<label class="pick">
      <input
        type="checkbox"
        data-all=${zone}
        .checked=${all}
        .indeterminate=${count > 0 && !all}
        @change=${() => this.tick(ids, !all)}
      />
      <span>${text}</span>
    </label>`;
  }

  private renderMonitor(id: string, zone: string | null) {
    const others = zonesOf(id, zonesKnown()).filter((one) => one !== zone);
    const missing = missingNow(id);
    const on = this.ticked.has(id);
    return html`<label class="pick">
      <input type="checkbox" data-monitor=${id} .checked=${on} @change=${() => this.tick([id], !on)} />
      <span
        ><b>${id}</b> ${monitorName(id)}
        ${others.length ? html`<span class="dim">${t('updates.also', { zones: others.join(', ') })}</span>` : nothing}
        <div class="small dim">${this.runs(id)}</div>
        ${factsOf(id).locked && store.source === 'live' ? html`<div class="small">${t('updates.locked')}</div>` : nothing}
        ${
          missing.length
            ? html`<div class="small missing">${icon('warning', 16)} ${t('updates.missing', { what: missing.map(missingWords).join('; ') })}</div>`
            : nothing
        }
      </span>
    </label>`;
  }

  private runs(id: string): string {
    const { run } = this.updates;
    const version = versionOf(run, id);
    if (version === null || !run) return t('updates.runs_unknown');
    return t('updates.runs', { version, time: dateTime(run.ended_ms ?? run.began_ms) });
  }

  private renderPace() {
    const change = (event: Event) => {
      const { value } = event.target as HTMLSelectElement;
      this.pace = value ? Number(value) : null;
    };
    return html`<label class="field"
        >${t('updates.pace')}
        <select id="pace" @change=${change}>
          <option value="" ?selected=${this.pace === null}>${t('updates.pace_own')}</option>
          ${PACES.map((n) => html`<option value=${n} ?selected=${n === this.pace}>${t('updates.percent', { n })}</option>`)}
        </select>
      </label>
      <p class="small dim">${t('updates.pace_text')}</p>`;
  }

  /** At which of the chosen monitors the run would end as things are. */
  private renderEnd() {
    const first = this.wouldEnd();
    if (!first) return nothing;
    return html`<div class="notice warn" role="status">${icon('warning')}<span class="grow">${endWords(first)}</span></div>`;
  }

  private wouldEnd(): { id: string; missing: Missing[] } | null {
    const found = this.chosenIds().map((id) => ({ id, missing: missingNow(id) }));
    return found.find(({ missing }) => missing.length > 0) ?? null;
  }

  /** The chosen one; the only one, if there is one. */
  private choice(): Choice | null {
    const choices = choicesOf(this.updates.images);
    return choices.find(({ key }) => key === this.key) ?? (choices.length === 1 ? choices[0]! : null);
  }

  /** Those that the hub still has, in the order in which they are shown. */
  private chosenIds(): string[] {
    const groups = groupsOf(store.liveMonitors(), zonesKnown());
    return groups.flatMap(({ monitors }) => monitors.filter((id) => this.ticked.has(id)));
  }

  private tick(ids: readonly string[], on: boolean): void {
    const ticked = new Set(this.ticked);
    for (const id of ids) {
      if (on) ticked.add(id);
      else ticked.delete(id);
    }
    this.ticked = ticked;
  }

  private whyNot(): string {
    const why = whyNotHere('engineer');
    if (why) return why;
    if (this.busy || this.updates.run?.state === 'running') return t('updates.why_runs');
    if (!this.choice()) return t('updates.why_version');
    return this.chosenIds().length === 0 ? t('updates.why_monitors') : '';
  }

  /** What is confirmed is what is sent: the hub is given these images and monitors, in this order. */
  private async ask(): Promise<void> {
    const choice = this.choice();
    const monitors = this.chosenIds();
    if (!choice || monitors.length === 0) return;
    const { version, board } = choice.images[0]!;
    const pace = this.pace;
    const sure = await dialog.open<boolean>({
      title: t('updates.start_title', { version }),
      content: () => {
        const end = this.wouldEnd();
        return html`<p>${t('updates.start_text', { version, board, monitors: monitors.join(', ') })}</p>
          ${happens()} ${end ? html`<p><b>${endWords(end)}</b></p>` : nothing}`;
      },
      actions: (close) => html`<lf-button @click=${() => close(false)}>${t('shell.cancel')}</lf-button>
        <lf-hold id="update-yes" kind="danger" .seconds=${HOLD_S} .why=${this.whyNot()} @held=${() => close(true)}
          >${t('updates.start_yes')}</lf-hold
        >`,
    });
    if (sure) await this.start({ images: choice.images.map(({ digest }) => digest), monitors, pace });
  }

  private async start(wanted: Parameters<typeof startUpdate>[0]): Promise<void> {
    this.busy = true;
    this.failed = '';
    try {
      await startUpdate(wanted);
      this.ticked = new Set();
    } catch (cause) {
      this.failed = HubError.of(cause).text(lang());
    } finally {
      this.busy = false;
      this.dispatchEvent(new CustomEvent(CHANGED));
    }
  }
}

function happens() {
  return html`<ul class="says">
    ${HAPPENS.map((key) => html`<li>${t(key)}</li>`)}
  </ul>`;
}

function endWords({ id, missing }: { id: string; missing: Missing[] }): string {
  return t('updates.would_end', { monitor: id, what: missing.map(missingWords).join('; ') });
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-update-start': LfUpdateStart;
  }
}
