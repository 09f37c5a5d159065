// One monitor: where it points, what flows, moving it by hand, what it does by itself.
import { LitElement, css, html, nothing } from 'lit';
import { customElement, property, query, state } from 'lit/decorators.js';
import { commands } from '../hub/commands';
import { HubError } from '../hub/errors';
import { has } from '../hub/session';
import { SECOND, store, TopicController } from '../hub/store';
import type { Readiness, Site } from '../hub/types';
import { age, lang, t, tt, type Key } from '../i18n';
import type { QuenchSector } from '../parts/geometry';
import { icon } from '../parts/icons';
import '../parts/lf-blank';
import '../parts/lf-dial';
import type { AimDetail, LfPlan, PlanMonitor } from '../parts/lf-plan';
import '../parts/lf-plan';
import { standAlone } from '../parts/stand-alone';
import { dialog } from '../shell/dialog';
import { toast } from '../shell/toasts';
import { magnified } from '../theme/display';
import { base, card } from '../theme/shared';
import { aimAt, flows } from './operate/aim';
import './operate/automatic';
import type { Tool } from './operate/automatic';
import './operate/hand';
import { OnPlan } from './operate/on-plan';
import { exists, field, limits, position, posture, whyNotWork } from './operate/state';
import './operate/trends';
import './operate/valves';

const VIEW_KEY = 'lafet.view';
/** How far the buttons on the plan reach down. */
const TOOLS_PX = 60;

@customElement('lf-page-operate')
export class PageOperate extends LitElement {
  static override styles = [
    base,
    card,
    css`
      :host {
        container-type: inline-size;
      }
      .page {
        display: grid;
        gap: var(--s3);
        padding: var(--s3);
        min-height: 100%;
        grid-template-columns: minmax(0, 1fr) 372px;
        grid-template-rows: auto minmax(340px, 1fr) auto;
        grid-template-areas: 'strip side' 'view side' 'below side';
      }
      .strip {
        grid-area: strip;
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: 10px 20px;
        padding: 10px 16px;
        --lf-value-width: 5.5ch;
        --lf-value-size: 24px;
      }
      .strip .chips {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        justify-content: flex-end;
        gap: 0 var(--s2);
        margin-left: auto;
        min-height: 48px;
      }
      .ready {
        all: unset;
        cursor: pointer;
        border-radius: 14px;
        padding: 10px 0;
      }
      .ready:focus-visible {
        outline: 3px solid var(--focus);
      }
      .view {
        grid-area: view;
        position: relative;
        padding: 0;
        overflow: hidden;
        display: grid;
        min-height: 340px;
      }
      .view > * {
        min-height: 0;
        min-width: 0;
      }
      lf-plan {
        --lf-plan-hint: 72px;
      }
      lf-plan,
      lf-scene {
        position: absolute;
        inset: 0;
      }
      .tools {
        position: absolute;
        top: 12px;
        left: 12px;
        display: flex;
        gap: 0;
        z-index: 2;
        --lf-button-size: 14px;
        background: var(--surface);
        border-radius: var(--radius);
        box-shadow: var(--shadow);
      }
      .below {
        grid-area: below;
        display: grid;
        grid-template-columns: 204px minmax(0, 1fr);
        gap: var(--s3);
      }
      .dial {
        padding: 12px;
      }
      /* As high as what stands beside it, however much is in it: the plan keeps its size under a hand that draws. */
      .side {
        grid-area: side;
        display: flex;
        flex-direction: column;
        gap: var(--s3);
        min-width: 0;
        height: 0;
        min-height: 100%;
        overflow-y: auto;
        padding: 4px;
        margin: -4px;
      }
      @container (min-width: 1500px) {
        .page {
          grid-template-columns: minmax(0, 1fr) 420px;
        }
      }
      @container (max-width: 1100px) {
        .strip .chips {
          min-height: 0;
        }
        .below {
          grid-template-columns: minmax(0, 1fr);
        }
        .dial {
          order: 2;
          height: 250px;
          overflow: hidden;
        }
        .dial lf-dial {
          width: min(204px, 100%);
          height: 100%;
          margin: auto;
        }
      }
      @container (max-width: 860px) {
        .page {
          grid-template-columns: minmax(0, 1fr);
          grid-template-rows: auto auto auto auto;
          grid-template-areas: 'strip' 'view' 'side' 'below';
        }
        .view {
          height: 56vh;
        }
        .side {
          height: auto;
          min-height: 0;
          overflow: visible;
          display: grid;
          grid-template-columns: repeat(auto-fit, minmax(min(330px, 100%), 1fr));
        }
      }
      @container (max-width: 520px) {
        .page {
          padding: var(--s2);
          gap: var(--s2);
        }
        .tools .word {
          position: absolute;
          width: 1px;
          height: 1px;
          overflow: hidden;
          clip-path: inset(50%);
        }
        .strip {
          gap: 10px 20px;
          --lf-value-size: 20px;
          --lf-value-width: 5ch;
        }
      }
    `,
  ];

  @property() monitor = '';
  private readonly onPlan = new OnPlan();
  @state() private tool: Tool = 'look';
  @state() private sector: QuenchSector | null = null;
  /** The sector is a hotbed that the search has found. */
  @state() private taking = false;
  @state() private view: 'plan' | 'scene' = localStorage.getItem(VIEW_KEY) === 'scene' ? 'scene' : 'plan';
  @state() private sceneLoaded = false;
  @state() private target: { Horizontal?: number; Vertical?: number } = {};
  @query('lf-plan') private plan?: LfPlan;
  @query('lf-automatic') private automatic?: LitElement;
  @query('.side') private side?: HTMLElement;

  constructor() {
    super();
    new TopicController(this, () => [SECOND, 'scene', 'monitors/']);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    if (this.view === 'scene') void this.loadScene();
    window.addEventListener('keydown', this.keyed);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    window.removeEventListener('keydown', this.keyed);
  }

  override render() {
    const { monitor } = this;
    if (!store.get(`monitors/${monitor}/info`) && store.get(`monitors/${monitor}/status`) === undefined) {
      const replayed = store.source === 'replay';
      return html`<lf-blank icon="search" .head=${t(replayed ? 'replay.without' : 'why.unknown', { monitor })}
        ><a href="#/overview">${t('nav.overview')}</a></lf-blank
      >`;
    }
    return html`<div class="page">
      <h1 class="unseen">${t('nav.operate')} ${monitor}</h1>
      ${this.strip()}
      <section class="card view" aria-label=${t('operate.plan')}>${this.picture()}</section>
      <div class="side">
        <lf-hand .monitor=${monitor}></lf-hand>
        <lf-valves .monitor=${monitor}></lf-valves>
        <lf-automatic
          .monitor=${monitor}
          .tool=${this.tool}
          .sector=${this.sector}
          .found=${store.get(`monitors/${monitor}/hotbeds`)?.list.length ?? 0}
          .taking=${this.taking}
          @found=${this.takeFound}
          @found-sector=${(e: CustomEvent<QuenchSector | null>) => this.takenFound(e.detail)}
          @tool=${(e: CustomEvent<Tool>) => this.choose(e.detail)}
        ></lf-automatic>
      </div>
      <div class="below">${this.dial()}<lf-trends .monitor=${monitor}></lf-trends></div>
    </div>`;
  }

  private strip() {
    const { monitor } = this;
    const status = store.get(`monitors/${monitor}/status`);
    const stale = store.stale(monitor);
    const age_ms = stale && status?.at_ms ? store.now() - status.at_ms : null;
    const value = (quantity: string, label: Key, wire: number | null) =>
      html`<lf-value
        quantity=${quantity}
        .label=${t(label)}
        .value=${wire}
        ?stale=${stale}
      ></lf-value>`;
    return html`<section class="card strip">
      ${value('angle', 'operate.horizontal', position(monitor, 'Horizontal'))}
      ${value('angle', 'operate.vertical', position(monitor, 'Vertical'))}
      ${exists(monitor, 'Nozzle') ? value('nozzle', 'operate.nozzle', position(monitor, 'Nozzle')) : nothing}
      ${value('pressure', 'operate.pressure', field(monitor, 'General', 'pressure'))}
      ${value('flow', 'operate.flow', field(monitor, 'General', 'flowrate'))}
      <div class="chips">
        ${age_ms !== null || stale
          ? html`<lf-chip id="stale" kind="medium" icon="clock"
              >${age_ms === null ? t('operate.no_data') : t('operate.old', { age: age(age_ms) })}</lf-chip
            >`
          : nothing}
        ${stale ? nothing : html`${this.postureChip(stale)} ${this.readiness()}`}
      </div>
    </section>`;
  }

  private postureChip(stale: boolean) {
    const now = posture(this.monitor);
    if (now === 'none' || now === 'unknown') return nothing;
    const goes = now === 'deploying' || now === 'wrapping';
    return html`<lf-chip ?stale=${stale} kind=${goes ? 'accent' : 'normal'} icon=${now === 'wrapped' ? 'wrap' : 'deploy'}
      >${t(`operate.posture_${now}` as Key)}</lf-chip
    >`;
  }

  private readiness() {
    const told = store.get(`monitors/${this.monitor}/readiness`);
    if (!told) return nothing;
    const faults = told.reasons.filter((reason) => reason.code !== 'wrapped');
    const alarm = faults.some((reason) => reason.severity === 'alarm');
    const kind = faults.length === 0 ? 'normal' : alarm ? 'high' : 'medium';
    return html`<button class="ready" id="readiness" @click=${() => showReadiness(this.monitor, told)}>
      <lf-chip kind=${kind} icon=${faults.length ? (alarm ? 'alarm' : 'warning') : 'check'}
        >${told.ready ? t('operate.ready') : t('operate.not_ready')}${faults.length
          ? html`&nbsp;· ${faults.length}`
          : nothing}</lf-chip
      >
    </button>`;
  }

  private picture() {
    const { monitor } = this;
    const site = siteOf();
    const scene = store.get('scene') ?? null;
    const monitors = this.monitors(site);
    const three = this.view === 'scene' && this.sceneLoaded;
    const choice = (tool: Tool, name: 'map' | 'target', text: string, why = '') =>
      html`<lf-button icon=${name} kind="quiet" toggle .on=${this.tool === tool} .why=${why} @click=${() => this.choose(tool)}
        ><span class="word">${text}</span></lf-button
      >`;
    return html`${three
        ? html`<lf-scene
            .site=${site}
            .monitors=${monitors}
            .scene=${scene}
            .selected=${monitor}
            @no-webgl=${this.noScene}
          ></lf-scene>`
        : html`<lf-plan
            .site=${site}
            .monitors=${monitors}
            .scene=${scene}
            .selected=${monitor}
            .tool=${this.tool}
            .above=${TOOLS_PX}
            .running=${this.onPlan.running(site, store.monitors())}
            .note=${this.tool === 'aim' ? t(flows(monitor) ? 'operate.aim_jet' : 'operate.aim_sight') : ''}
            @sector=${(e: CustomEvent<QuenchSector | null>) => this.drawn(e.detail)}
            @sector-change=${(e: CustomEvent<QuenchSector | null>) => this.drawn(e.detail)}
            @aim=${(e: CustomEvent<AimDetail>) => this.aim(e.detail)}
            @select=${(e: CustomEvent<{ id: string }>) => (location.hash = `#/m/${e.detail.id}/operate`)}
          ></lf-plan>`}
      <div class="tools">
        ${three
          ? nothing
          : html`${choice('look', 'map', t('operate.look'))}
            ${choice('aim', 'target', t('operate.aim'), whyNotWork(monitor, 'Horizontal'))}`}
        <lf-button icon=${three ? 'map' : 'cube'} kind="quiet" @click=${this.turnView}
          >${three ? t('operate.plan_view') : '3D'}</lf-button
        >
      </div>`;
  }

  private dial() {
    const { monitor } = this;
    return html`<section class="card dial">
        <lf-dial
          kind="vertical"
          .value=${position(monitor, 'Vertical')}
          .target=${has(monitor, 'Vertical', 'Move') ? (this.target.Vertical ?? null) : null}
          .limits=${limits(monitor, 'Vertical')}
          .stale=${store.stale(monitor)}
          .moving=${has(monitor, 'Vertical', 'Move')}
          .offlimits=${has(monitor, 'Vertical', 'Limitless')}
          .label=${t('operate.vertical')}
        ></lf-dial>
    </section>`;
  }

  private monitors(site: Site): PlanMonitor[] {
    const { Horizontal } = this.target;
    return this.onPlan.of(site, store.monitors()).map((made) => {
      const aimed = made.id === this.monitor && Horizontal !== undefined && has(made.id, 'Horizontal', 'Move');
      return aimed ? { ...made, target_arcmin: Horizontal } : made;
    });
  }

  private choose(tool: Tool): void {
    this.tool = tool;
    if (tool !== 'look' && this.view === 'scene') this.turnView();
    this.taking = false;
    if (tool !== 'sector') {
      this.sector = null;
      if (this.plan) this.plan.sector = null;
    }
    if (tool !== 'look') void this.showTool();
  }

  /** The plan, to draw on; and what goes with the drawing, as far as the column beside it scrolls. */
  private async showTool(): Promise<void> {
    await this.updateComplete;
    this.renderRoot.querySelector('.view')?.scrollIntoView({ block: 'nearest' });
    await this.showPanel();
  }

  /** Once, not while somebody types in it. */
  private async showPanel(): Promise<void> {
    await this.updateComplete;
    await this.automatic?.updateComplete;
    const { side, automatic } = this;
    await (automatic?.renderRoot.querySelector('lf-found') as LitElement | null)?.updateComplete;
    if (!side || !automatic) return;
    const below = automatic.getBoundingClientRect().bottom - side.getBoundingClientRect().bottom;
    if (below > 0) side.scrollTop += below / magnified();
  }

  private drawn(sector: QuenchSector | null): void {
    this.taking = false;
    this.sector = sector;
  }

  private readonly takeFound = (): void => {
    this.taking = true;
    void this.showPanel();
  };

  /** A hotbed becomes the sector, once its distance is known. */
  private takenFound(sector: QuenchSector | null): void {
    this.sector = sector;
    if (this.plan) this.plan.sector = sector?.sector ?? null;
  }

  /** Both drives go where the operator has pointed. */
  private aim(at: AimDetail): void {
    const { monitor } = this;
    const why = whyNotWork(monitor, 'Horizontal');
    if (why) return toast({ kind: 'info', text: why });
    const { Horizontal, Vertical, kind, text } = aimAt(monitor, at);
    this.target = { Horizontal, Vertical };
    const sent = (['Horizontal', 'Vertical'] as const).map((drive) =>
      commands.request(monitor, `Move ${drive} ${this.target[drive]}`, { quiet: true }),
    );
    Promise.all(sent).then(
      () => toast({ kind, text: `${monitor} · ${text}` }),
      (cause: unknown) => toast({ kind: 'error', text: `${monitor} · ${t('operate.aim')}: ${HubError.of(cause).text(lang())}` }),
    );
  }

  private readonly turnView = (): void => {
    this.view = this.view === 'plan' ? 'scene' : 'plan';
    localStorage.setItem(VIEW_KEY, this.view);
    if (this.view === 'scene') {
      this.choose('look');
      void this.loadScene();
    }
  };

  private async loadScene(): Promise<void> {
    try {
      await SCENES['../parts/lf-scene.ts']?.();
      this.sceneLoaded = '../parts/lf-scene.ts' in SCENES;
    } catch {
      this.sceneLoaded = false;
    }
    if (!this.sceneLoaded) this.noScene();
  }

  private readonly noScene = (): void => {
    this.view = 'plan';
    localStorage.setItem(VIEW_KEY, 'plan');
    toast({ kind: 'info', text: t('operate.no_3d') });
  };

  private readonly keyed = (event: KeyboardEvent): void => {
    if (event.key === 'Escape' && !event.shiftKey && dialog.stack.length === 0) this.choose('look');
  };
}

const SCENES = import.meta.glob('../parts/lf-scene.ts');

/** The site as it is configured; a monitor whose place is not known stands alone in it. */
function siteOf(): Site {
  const site = (store.get('hub') ?? store.hello?.hub)?.site ?? null;
  return standAlone(site, store.monitors());
}

function showReadiness(monitor: string, told: Readiness): void {
  void dialog.open({
    title: t(told.ready ? 'operate.ready_title' : 'operate.not_ready_title', { monitor }),
    content: () =>
      told.reasons.length === 0
        ? html`<p>${t('operate.ready_text')}</p>`
        : html`${told.reasons.map(
            (reason) => html`<div class="row" style="align-items:flex-start;gap:12px">
              ${icon(reason.severity === 'alarm' ? 'alarm' : reason.severity === 'warning' ? 'warning' : 'info', 22)}
              <div>
                <b>${reason.subsystem ? `${reason.subsystem}: ` : ''}${tt(reason.what)}</b>
                <p class="dim">${tt(reason.remedy)}</p>
              </div>
            </div>`,
          )}`,
  });
}

