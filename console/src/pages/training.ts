// Exercises on the simulated site: choose one, inject faults, see the result.
import { html, LitElement, nothing } from 'lit';
import { customElement, property, state } from 'lit/decorators.js';
import { HubError } from '../hub/errors';
import { http } from '../hub/http';
import { may } from '../hub/session';
import { store, TopicController } from '../hub/store';
import type { Site } from '../hub/types';
import { lang, num, plural, t, tt } from '../i18n';
import { icon } from '../parts/icons';
import '../parts/lf-button';
import '../parts/lf-chip';
import '../parts/lf-plan';
import { type AimDetail, planMonitor } from '../parts/lf-plan';
import { span } from '../parts/lf-timeline';
import { fireTitle } from '../parts/plan/model';
import { standAlone } from '../parts/stand-alone';
import { dialog } from '../shell/dialog';
import { hrefOf } from '../shell/router';
import { toast } from '../shell/toasts';
import { base, card, fields, page } from '../theme/shared';
import { jetOf } from './operate/on-plan';
import { type Check, ordered, type Scenario, type SimState, type Simulation } from './training/model';
import './training/faults';
import { styled } from '../parts/styled';
import { pageStyle } from './training/style';

const SPEEDS = [0.5, 1, 2, 5, 10];
const KINDS = ['pool', 'pile', 'spray'] as const;
const SIZES_M = [1, 2, 3, 5, 8];

@customElement('lf-page-training')
export class PageTraining extends LitElement {
  static override styles = [base, page, card, fields, pageStyle];

  /** Site pages get none. */
  @property() monitor: string | null = null;
  @state() private simulation: Simulation | null = null;
  @state() private off = false;
  @state() private error = '';
  @state() private placing = false;
  @state() private kind: (typeof KINDS)[number] = 'pool';
  @state() private fireSize = 2;
  /** The answer of a POST, until the topic has it too. */
  @state() private answered: SimState | null = null;

  constructor() {
    super();
    new TopicController(this, () => ['sim', 'scene', 'monitors/']);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    void this.load();
  }

  protected override willUpdate(): void {
    const told = store.get('sim') as SimState | undefined;
    if (this.answered && told && told.run >= this.answered.run) this.answered = null;
  }

  private get sim(): SimState | null {
    const told = (store.get('sim') as SimState | undefined) ?? this.simulation?.state ?? null;
    const { answered } = this;
    return answered && (!told || answered.run > told.run) ? answered : told;
  }

  /** Why nothing may be changed here. */
  private get why(): string {
    if (store.source === 'replay') return t('why.replay');
    if (!store.linked) return t('why.hub');
    return may('engineer') ? '' : t('why.role', { role: t('role.engineer') });
  }

  override render() {
    const { sim } = this;
    return html`<div class="page">
      <header class="head">
        <h1>${t('training.title')}</h1>
        ${sim ? this.head(sim) : nothing}
      </header>
      ${this.error ? html`<p class="error" role="alert">${this.error}</p>` : nothing}
      ${
        this.off
          ? html`<section class="card empty">${icon('simulation', 28)}<p>${t('training.off')}</p></section>`
          : sim && this.simulation
            ? this.body(sim)
            : this.error
              ? nothing
              : html`<p class="dim" aria-busy="true">${t('shell.loading')}</p>`
      }
    </div>`;
  }

  private head(sim: SimState) {
    return html`<lf-button icon="table" @click=${this.report}>${t('training.report')}</lf-button>
      <lf-button icon="refresh" .why=${this.why} @click=${() => this.ask(this.scenario(sim), sim)}
        >${t('training.start_again')}</lf-button
      >
      <lf-button
        kind="primary"
        id="pause"
        icon=${sim.paused ? 'play' : 'pause'}
        .why=${this.why}
        @click=${() => this.post(sim.paused ? 'resume' : 'pause')}
        >${sim.paused ? t('training.resume') : t('training.pause')}</lf-button
      >`;
  }

  private body(sim: SimState) {
    const site = this.site;
    return html`<div class="stage">
      <div class="left">
        ${this.progress(sim)}
        <section class="card view">${this.plan(site)}</section>
        ${this.score(sim)}
      </div>
      <div class="right">
        ${this.fires()}
        <lf-training-faults
          .sim=${sim}
          .faults=${this.simulation!.faults}
          .why=${this.why}
          @fault=${(event: CustomEvent) => this.post('faults', event.detail)}
          @link=${(event: CustomEvent) => this.post('link', event.detail)}
        ></lf-training-faults>
      </div>
      <section class="card exercises">
        <header><h2>${t('training.choose')}</h2></header>
        <div class="list">${this.simulation!.scenarios.map((one) => this.exercise(one, sim))}</div>
      </section>
    </div>`;
  }

  private progress(sim: SimState) {
    const part = sim.duration_s ? Math.min(sim.t_s / sim.duration_s, 1) * 100 : 0;
    const title = tt(this.scenario(sim)?.title) || t('training.none');
    return html`<section class="card run">
      <div class="what">
        <h2>${title}</h2>
        <span class="chips">
          ${sim.over ? html`<lf-chip icon="check">${t('training.over')}</lf-chip>` : nothing}
          ${sim.paused ? html`<lf-chip kind="medium" icon="pause">${t('training.paused')}</lf-chip>` : nothing}
          <lf-chip>${t('training.run', { n: sim.run })}</lf-chip>
        </span>
      </div>
      <div
        class="bar"
        role="progressbar"
        aria-label=${title}
        aria-valuenow=${Math.round(part)}
        aria-valuemin="0"
        aria-valuemax="100"
      >
        <i ${styled({ width: `${part}%` })}></i>
      </div>
      <div class="row wrap">
        <b class="clock">${span(sim.t_s * 1000)}</b>
        <span class="dim grow">${t('training.time', { d: span(sim.duration_s * 1000) })}</span>
        <label class="inline"
          ><span class="unseen">${t('training.automatic_switch')}</span>
          <select ?disabled=${Boolean(this.why)} @change=${this.setAutomatic}>
            <option value="" ?selected=${!sim.automatic}>${t('training.automatic_off')}</option>
            <option value="on" ?selected=${sim.automatic}>${t('training.automatic_on')}</option>
          </select></label
        >
        <label class="inline"
          ><span class="unseen">${t('training.speed')}</span>
          <select ?disabled=${Boolean(this.why)} @change=${this.setSpeed}>
            ${SPEEDS.map((n) => html`<option value=${n} ?selected=${n === sim.speed}>${num(n, n % 1 ? 1 : 0)}×</option>`)}
          </select></label
        >
      </div>
    </section>`;
  }

  private plan(site: Site) {
    const scene = store.get('scene') ?? null;
    const ids = store.monitors();
    const monitors = ids.flatMap(
      (id) =>
        planMonitor(id, site, {
          status: store.get(`monitors/${id}/status`),
          limits: store.get(`monitors/${id}/limits`) as never,
          hotbeds: store.get(`monitors/${id}/hotbeds`),
          scene,
          down: store.stale(id),
          jet: jetOf(id, site),
        }) ?? [],
    );
    return html`<lf-plan
      .site=${site}
      .monitors=${monitors}
      .scene=${scene}
      .selected=${this.placing ? (ids[0] ?? '') : ''}
      .tool=${this.placing ? 'aim' : 'look'}
      .note=${this.placing ? t('training.placing') : ''}
      @aim=${(event: CustomEvent<AimDetail>) => this.lightAt(event.detail.at)}
      @select=${(event: CustomEvent) => (location.hash = hrefOf('operate', event.detail.id))}
    ></lf-plan>`;
  }

  private score(sim: SimState) {
    const { passed, failed, open, checks } = sim.score;
    const count = (n: number, kind: 'passed' | 'failed' | 'open') => html`<div class="count ${n ? kind : ''}">
      <b>${n}</b><span>${t(`training.${kind}`)}</span>
    </div>`;
    return html`<section class="card score">
      <header><h2>${t('training.score')}</h2></header>
      <div class="counts">${count(passed, 'passed')} ${count(failed, 'failed')} ${count(open, 'open')}</div>
      ${
        checks.length
          ? html`<ul>
            ${ordered(checks).map((check) => this.check(check))}
          </ul>`
          : html`<p class="dim">${t('training.no_checks')}</p>`
      }
    </section>`;
  }

  private check(check: Check) {
    const sign = check.state === 'passed' ? 'check' : check.state === 'failed' ? 'close' : 'clock';
    return html`<li class=${check.state}>
      ${icon(sign, 18)}
      <div class="grow">
        ${tt(check.text)} ${check.came ? html`<div class="small dim">${tt(check.came)}</div>` : nothing}
      </div>
      <span class="unseen">${t(`training.${check.state}`)}</span>
      ${check.at_s === null ? nothing : html`<span class="small dim">${t('training.at', { t: span(check.at_s * 1000) })}</span>`}
    </li>`;
  }

  private fires() {
    const fires = store.get('scene')?.fires ?? [];
    const waiting = fires.filter(({ burns }) => !burns);
    const tanks = (store.get('hub') ?? store.hello?.hub)?.site?.tanks ?? [];
    const choose = (event: Event) => (event.target as HTMLSelectElement).value;
    return html`<section class="card fires">
      <header><h2>${t('training.fire')}</h2></header>
      <div class="row wrap">
        ${waiting.map(
          ({ name }) => html`<lf-button icon="fire" .why=${this.why} @click=${() => this.post('fire', { name })}
            >${t('training.light', { name: fireTitle(name, fires, tanks) })}</lf-button
          >`,
        )}
      </div>
      <div class="place">
        <label class="field"
          >${t('training.kind')}
          <select @change=${(event: Event) => (this.kind = choose(event) as 'pool')}>
            ${KINDS.map((kind) => html`<option value=${kind} ?selected=${kind === this.kind}>${t(`training.kind_${kind}`)}</option>`)}
          </select></label
        >
        <label class="field"
          >${t('training.size')}
          <select @change=${(event: Event) => (this.fireSize = Number(choose(event)))}>
            ${SIZES_M.map((n) => html`<option ?selected=${n === this.fireSize}>${n}</option>`)}
          </select></label
        >
        <lf-button
          icon="target"
          toggle
          .on=${this.placing}
          .why=${this.why}
          @click=${() => (this.placing = !this.placing)}
          >${t('training.place')}</lf-button
        >
      </div>
    </section>`;
  }

  private exercise(one: Scenario, sim: SimState) {
    const on = one.id === sim.scenario;
    return html`<article class=${on ? 'on' : ''}>
      <h3>${tt(one.title)}</h3>
      <p>${tt(one.about)}</p>
      <footer>
        <span class="small dim"
          >${icon('clock', 16)} ${span(one.duration_s * 1000)} ·
          ${plural(one.monitors.length, 'training.monitors')}</span
        >
        <lf-button kind=${on ? 'normal' : 'primary'} .why=${this.why} @click=${() => this.ask(one, sim)}
          >${on ? t('training.start_again') : t('training.start')}</lf-button
        >
      </footer>
    </article>`;
  }

  private get site(): Site {
    return standAlone((store.get('hub') ?? store.hello?.hub)?.site ?? null, store.monitors());
  }

  private scenario(sim: SimState): Scenario | undefined {
    return this.simulation?.scenarios.find(({ id }) => id === sim.scenario);
  }

  private async load(): Promise<void> {
    try {
      const told = await http.get<Simulation>('/api/sim');
      if (told && Array.isArray(told.scenarios)) this.simulation = told;
      else this.off = true;
    } catch (cause) {
      const error = HubError.of(cause);
      if (['not_found', 'HTTP 404', 'page'].includes(error.code)) this.off = true;
      else this.error = error.text(lang());
    }
  }

  private async ask(one: Scenario | undefined, sim: SimState): Promise<void> {
    if (!one) return;
    const wish = { id: one.id, seed: sim.seed, automatic: sim.automatic };
    const sure = await dialog.open<boolean>({
      title: t('training.choose_title'),
      content: () => html`<h3>${tt(one.title)}</h3>
        <p>${tt(one.about)}</p>
        <p class="dim">${t('training.start_text')}</p>
        <label class="field"
          >${t('training.seed')}
          <input
            type="number"
            min="0"
            step="1"
            .value=${String(wish.seed)}
            @input=${(event: Event) => (wish.seed = Math.max(0, Math.trunc(Number((event.target as HTMLInputElement).value) || 0)))}
          />
        </label>
        <label class="row touch">
          <input
            type="checkbox"
            ?checked=${wish.automatic}
            @change=${(event: Event) => (wish.automatic = (event.target as HTMLInputElement).checked)}
          />
          ${t('training.automatic')}
        </label>`,
      actions: (close) => html`<lf-button @click=${() => close()}>${t('shell.cancel')}</lf-button>
        <lf-button kind="primary" @click=${() => close(true)}>${t('training.start')}</lf-button>`,
    });
    if (!sure) return;
    await this.post('scenario', wish);
    this.renderRoot.querySelector('.head')?.scrollIntoView({ block: 'center' });
  }

  private async lightAt(at: readonly [number, number]): Promise<void> {
    this.placing = false;
    const place = at.map((metres) => Math.round(metres * 10) / 10);
    await this.post('fire', { at: place, size: this.fireSize, kind: this.kind });
  }

  private readonly setSpeed = (event: Event): void => {
    void this.post('speed', { speed: Number((event.target as HTMLSelectElement).value) });
  };

  private readonly setAutomatic = (event: Event): void => {
    void this.post('automatic', { on: (event.target as HTMLSelectElement).value === 'on' });
  };

  private async post(what: string, body: unknown = {}): Promise<void> {
    try {
      this.answered = await http.post<SimState>(`/api/sim/${what}`, body);
    } catch (cause) {
      toast({ kind: 'error', text: HubError.of(cause).text(lang()) });
    }
    this.requestUpdate();
  }

  private readonly report = (): void => {
    const picture = `/api/sim/report.svg?lang=${lang()}&now=${Date.now()}`;
    void dialog.open({
      title: t('training.report_title'),
      wide: true,
      content: () => html`<img src=${picture} alt=${t('training.report_title')} class="paper" />`,
      actions: (close) => html`<lf-button icon="download" @click=${() => save('/api/sim/report', 'report.json')}
          >${t('training.report_json')}</lf-button
        >
        <lf-button icon="download" @click=${() => save(picture, 'report.svg')}>${t('training.report_svg')}</lf-button>
        <lf-button kind="primary" @click=${() => close()}>${t('shell.close')}</lf-button>`,
    });
  };
}

function save(path: string, name: string): void {
  const link = document.createElement('a');
  link.href = path;
  link.download = name;
  link.click();
}
