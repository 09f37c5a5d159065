// A found fire spot becomes a sector to extinguish: which one, its distance, how the distance was
// computed and how reliable it is. No command uses a distance that the operator has not seen.
import { css, html, LitElement, nothing, type PropertyValues } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { SECOND, store, TopicController } from '../../hub/store';
import { age, num, t } from '../../i18n';
import { brightest, type HotbedBox, isDoubtful, type Reckoned, reckon, sameOf } from '../../parts/found';
import { DISTANCE_MAX_M, type QuenchSector, sectorOf } from '../../parts/geometry';
import { icon } from '../../parts/icons';
import { toast } from '../../shell/toasts';
import { base, fields } from '../../theme/shared';
import { fromWire, parse, show, unitText } from '../../units';
import { configured, limits, siteOf } from './state';

/** A fire spot looks smaller than the fire; the jet must also fall around it. */
const LEAST_ARCMIN = 60;
/** A list that is older says so, ms. */
const FRESH_MS = 10_000;
/** Permitted difference between the monitor's own height and the hub's, m. */
const SAME_HEIGHT_M = 0.25;
const CM = 100;

/** Height of the nozzle and its source; null: unknown. */
export interface Height {
  height_m: number;
  from: 'hub' | 'monitor';
}

@customElement('lf-found')
export class LfFound extends LitElement {
  static override styles = [
    base,
    fields,
    css`
      :host {
        display: grid;
        gap: var(--s2);
      }
      .which {
        display: grid;
        grid-auto-flow: column;
        grid-auto-columns: 1fr;
        gap: var(--s2);
      }
      .far {
        display: grid;
        grid-template-columns: 1fr auto;
        gap: var(--s2);
        align-items: end;
      }
      input:not([type='checkbox']) {
        font-size: var(--t-title);
        font-weight: 650;
      }
      p {
        font-weight: 500;
        line-height: 1.4;
      }
      .warn {
        display: flex;
        gap: var(--s2);
        padding: var(--s2) var(--s2);
        border-radius: var(--radius);
        background: var(--medium-soft);
        font-size: var(--t-note);
      }
      .warn svg {
        flex: none;
        color: var(--medium);
      }
    `,
  ];

  @property() monitor = '';
  /** Of the fire spots, in the monitor's order, as on the plan. */
  @state() private chosen = 0;
  /** What it is: the monitor lists its spots again each second, and may list them otherwise. */
  private followed: HotbedBox | null = null;
  /** What the operator has entered; null: the computed value counts. */
  @state() private typed: string | null = null;
  private told = '';

  constructor() {
    super();
    new TopicController(this, () => [SECOND, 'hub', `monitors/${this.monitor}/`]);
  }

  override willUpdate(changed: PropertyValues): void {
    if (changed.has('monitor')) this.followed = null;
    const all = hotbedsOf(this.monitor);
    const same = this.followed ? sameOf(all, this.followed) : -1;
    // A distance is of one fire: it is not that of another one.
    if (same < 0 && this.followed && this.typed !== null) {
      this.typed = null;
      toast({ kind: 'warning', text: t('operate.found_gone', { monitor: this.monitor }) });
    }
    this.chosen = same < 0 ? brightest(all) : same;
    this.followed = all[this.chosen] ?? null;
  }

  override render() {
    const hotbeds = hotbedsOf(this.monitor);
    const of = this.reckoned();
    if (!of) return nothing;
    const where = { h: show('angle', of.horizontal_arcmin), v: show('angle', of.foot_arcmin) };
    return html`<b>${t('operate.found_title')}</b>
      ${
        hotbeds.length > 1
          ? html`<div class="which" role="group" aria-label=${t('operate.found_title')}>
            ${hotbeds.map(
              (_, n) => html`<lf-button toggle .on=${n === this.chosen} @click=${() => this.choose(n)}
                >${t('operate.found_n', { n: n + 1 })}</lf-button
              >`,
            )}
          </div>`
          : nothing
      }
      <p class="dim small">${t('operate.found_at', where)} ${this.seen()}</p>
      <div class="far">
        <label class="field"
          >${t('operate.found_distance')}, ${unitText('length')}
          <input
            id="distance"
            inputmode="decimal"
            autocomplete="off"
            aria-describedby="how"
            aria-invalid=${this.wrong(of) ? 'true' : 'false'}
            .value=${this.typed ?? this.offered(of)}
            @input=${(e: Event) => (this.typed = (e.target as HTMLInputElement).value)}
          />
        </label>
        ${
          'distance_m' in of && of.how !== 'far' && (this.typed !== null || isDoubtful(of))
            ? html`<lf-button id="take-reckoned" @click=${() => this.take(of)}
              >${t('operate.found_take', { distance: wholeLength(of.distance_m) })}</lf-button
            >`
            : nothing
        }
      </div>
      ${this.wrong(of) && this.typed ? html`<p class="error small">${rangeText()}</p>` : nothing}
      <p class="small" id="how">${this.how(of)}</p>
      ${this.warning(of)}`;
  }

  override updated(): void {
    const sector = this.sector();
    const now = JSON.stringify(sector);
    if (now === this.told) return;
    this.told = now;
    this.dispatchEvent(new CustomEvent('found-sector', { detail: sector, bubbles: true, composed: true }));
  }

  private how(of: Reckoned): string {
    const { monitor } = this;
    const angle = show('angle', of.foot_arcmin);
    if (of.how === 'no_height') return t('operate.found_no_height', { monitor });
    if (of.how === 'level') return t('operate.found_level', { angle });
    const distance = wholeLength(of.distance_m);
    if (of.how === 'tank') return t('operate.found_tank', { tank: of.tank, distance, give: wholeLength(of.give_m) });
    const height = show('length', of.height_m);
    if (of.how === 'far') return t('operate.found_far', { height, angle, distance, most: wholeLength(DISTANCE_MAX_M) });
    const [least, most] = [Math.max(of.distance_m - of.give_m, 0), of.distance_m + of.give_m];
    return t('operate.found_height', { height, angle, distance, near: wholeLength(least), far: wholeLength(most) });
  }

  private warning(of: Reckoned) {
    const texts: string[] = [];
    if (isDoubtful(of)) texts.push(t('operate.found_doubtful'));
    const own = ownHeight_m(this.monitor);
    const differs = own !== null && of.how === 'height' && Math.abs(own - of.height_m) > SAME_HEIGHT_M;
    if (differs) texts.push(t('operate.found_own', { height: show('length', own) }));
    return texts.map((text) => html`<p class="warn" role="note">${icon('warning', 18)}<span>${text}</span></p>`);
  }

  /** The list stays after the search has ended. */
  private seen(): string {
    const at_ms = store.get(`monitors/${this.monitor}/hotbeds`)?.at_ms;
    const old_ms = at_ms === undefined ? 0 : store.now() - at_ms;
    return old_ms > FRESH_MS ? t('operate.found_seen', { age: age(old_ms) }) : '';
  }

  private reckoned(): Reckoned | null {
    const box = hotbedsOf(this.monitor)[this.chosen] ?? hotbedsOf(this.monitor)[0];
    return box ? reckonFor(this.monitor, box) : null;
  }

  /** Initial content of the field: empty if the distance is only an estimate. */
  private offered(of: Reckoned): string {
    if (!('distance_m' in of) || of.how === 'far' || isDoubtful(of)) return '';
    return fromWire('length', Math.round(of.distance_m)).toFixed(0);
  }

  private distance_m(of: Reckoned): number | null {
    const m = parse('length', this.typed ?? this.offered(of));
    return m !== null && m >= 1 && m <= DISTANCE_MAX_M ? m : null;
  }

  private wrong(of: Reckoned): boolean {
    return this.distance_m(of) === null;
  }

  private sector(): QuenchSector | null {
    const of = this.reckoned();
    const box = hotbedsOf(this.monitor)[this.chosen];
    const distance_m = of && this.distance_m(of);
    if (!of || !box || !distance_m) return null;
    const width_arcmin = Math.max(Math.abs(box.x2 - box.x1), LEAST_ARCMIN);
    const range = limits(this.monitor, 'Horizontal');
    const [right, left] = [of.horizontal_arcmin - width_arcmin / 2, of.horizontal_arcmin + width_arcmin / 2];
    const numbers: Omit<QuenchSector, 'clipped' | 'sector'> = {
      centre_arcmin: [of.horizontal_arcmin, of.foot_arcmin],
      width_arcmin,
      height_arcmin: LEAST_ARCMIN,
      distance_m,
    };
    const stand = siteOf(this.monitor).monitors[this.monitor]!;
    return {
      ...numbers,
      clipped: range ? right < range.min || left > range.max : false,
      sector: sectorOf(stand, numbers),
    };
  }

  private choose(n: number): void {
    this.followed = hotbedsOf(this.monitor)[n] ?? null;
    this.chosen = n;
    this.typed = null;
  }

  private take(of: Reckoned & { distance_m: number }): void {
    this.typed = isDoubtful(of) ? fromWire('length', Math.round(of.distance_m)).toFixed(0) : null;
  }
}

/** The wire has whole metres, and nothing here is more precise. */
export function wholeLength(distance_m: number): string {
  return `${num(fromWire('length', distance_m))}\u202f${unitText('length')}`;
}

function rangeText(): string {
  return t('operate.found_range', { least: wholeLength(1), most: wholeLength(DISTANCE_MAX_M) });
}

export function hotbedsOf(monitor: string): HotbedBox[] {
  return store.get(`monitors/${monitor}/hotbeds`)?.list ?? [];
}

/** The monitor's parameter Height, which its own ballistics use, if it has been read. */
function ownHeight_m(monitor: string): number | null {
  const cm = store.get(`monitors/${monitor}/params`)?.values.Control?.Height?.values?.[0];
  return cm === undefined ? null : cm / CM;
}

export function heightOf(monitor: string): Height | null {
  const told = configured()?.monitors[monitor]?.height;
  if (told !== undefined) return { height_m: told, from: 'hub' };
  const own = ownHeight_m(monitor);
  return own === null ? null : { height_m: own, from: 'monitor' };
}

function reckonFor(monitor: string, box: HotbedBox): Reckoned {
  const site = siteOf(monitor);
  const stand = site.monitors[monitor]!;
  return reckon({ ...stand, height_m: heightOf(monitor)?.height_m ?? null }, box, site.tanks);
}

declare global {
  interface HTMLElementTagNameMap {
    'lf-found': LfFound;
  }
}
