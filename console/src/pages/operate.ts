// One monitor: its direction, pressure and flow, motion by hand, automatic programs.
import { css, html, LitElement, nothing } from 'lit';
import { customElement, property, query, state } from 'lit/decorators.js';
import { camerasOf } from '../hub/cameras';
import { commands } from '../hub/commands';
import { HubError } from '../hub/errors';
import { concerns, onHalt } from '../hub/halt';
import { has, inControl } from '../hub/session';
import { SECOND, store, TopicController } from '../hub/store';
import type { Readiness, Site } from '../hub/types';
import { age, type Key, lang, t, tt } from '../i18n';
import type { QuenchSector } from '../parts/geometry';
import { icon } from '../parts/icons';
import '../parts/lf-blank';
import '../parts/lf-dial';
import type { AimDetail, LfPlan, PlanMonitor } from '../parts/lf-plan';
import '../parts/lf-plan';
import { USUAL_PRESSURE_DATM } from '../parts/plan/model';
import { confirmDialog, dialog } from '../shell/dialog';
import { toast } from '../shell/toasts';
import { magnified } from '../theme/display';
import { base, card } from '../theme/shared';
import { show } from '../units';
import { type Aimed, aimAt, flows, SOLVED_MOST_MS, UNKNOWN } from './operate/aim';
import './operate/automatic';
import type { Tool } from './operate/automatic';
import './operate/camera';
import './operate/hand';
import { OnPlan } from './operate/on-plan';
import { exists, limits, position, posture, siteOf, whyNotAim, whyNotWork } from './operate/state';
import './operate/trends';
import { readingOf } from './operate/value';
import './operate/valves';

const VIEW_KEY = 'lafet.view';
const CAMERA_KEY = 'lafet.camera';
/** Height that the buttons on the plan take, px. */
const TOOLS_PX = 60;
/** Height that notes about the water take below them where they have no place beside them: narrower than this, px. */
const NOTES_PX = 72;
const NOTES_BELOW_PX = 1250;
/** Narrower than this, px, everything is in one column. */
const STACKED_PX = 860;

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
        gap: var(--s2);
        padding: var(--s2);
        grid-template-columns: minmax(0, 1fr) 352px;
        /* The picture fills the visible page; the trends are below. */
        grid-template-rows: minmax(340px, calc(100dvh / var(--zoom, 1) - var(--topbar) - 57px - var(--guide-height, 0px) - var(--notes-height, 0px) - 2 * var(--s2))) auto;
        grid-template-areas: 'view side' 'below below';
      }
      .strip {
        grid-area: view;
        z-index: 3;
        align-self: start;
        margin: var(--s2);
        box-shadow: var(--shadow);
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: 0 var(--s3);
        padding: var(--s1) var(--s25);
        --lf-value-width: 5.5ch;
        --lf-value-size: 22px;
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
        border-radius: var(--radius-round);
        padding: var(--s2) 0;
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
      .view {
        --lf-plan-hint: calc(var(--strip, 72px) + 76px);
      }
      lf-plan,
      lf-scene {
        position: absolute;
        inset: 0;
      }
      .tools {
        position: absolute;
        top: calc(var(--strip, 72px) + 16px);
        left: 8px;
        display: flex;
        gap: 0;
        z-index: 2;
        --lf-button-size: 14px;
        background: var(--surface);
        border-radius: var(--radius);
        box-shadow: var(--shadow);
      }
      lf-camera {
        position: absolute;
        z-index: 1;
        right: 8px;
        bottom: 8px;
        width: min(42%, 480px);
        aspect-ratio: 16 / 11;
      }
      /* In the place of the plan, below the values and the buttons. */
      lf-camera[large] {
        inset: calc(var(--strip, 72px) + 76px) 0 0 0;
        width: auto;
        aspect-ratio: auto;
      }
      .below {
        grid-area: below;
        display: grid;
        min-width: 0;
      }
      /* As high as its neighbour, whatever its content: the plan keeps its size while the operator draws. */
      .side {
        grid-area: side;
        display: flex;
        flex-direction: column;
        gap: var(--s2);
        min-width: 0;
        height: 0;
        min-height: 100%;
        overflow-y: auto;
        padding: var(--s1);
        margin: calc(-1 * var(--s1));
        /* Its parts are lower where it is, as beside the bar of the first steps. */
        container-type: size;
      }
      @container (min-width: 1500px) {
        .page {
          grid-template-columns: minmax(0, 1fr) 420px;
        }
      }
      /* Beside the buttons: it covers nothing of the site. */
      @container (min-width: 1250px) {
        .view {
          --lf-plan-hint: calc(var(--strip, 72px) + 16px);
          --lf-plan-hint-left: 356px;
        }
      }
      @container (max-width: 1100px) {
        .strip .chips {
          min-height: 0;
        }
      }
      @container (max-width: 860px) {
        .page {
          grid-template-columns: minmax(0, 1fr);
          grid-template-rows: auto auto auto auto;
          grid-template-areas: 'strip' 'view' 'side' 'below';
          --strip: 0px;
        }
        .strip {
          grid-area: strip;
          margin: 0;
          box-shadow: none;
        }
        .view {
          height: 56vh;
        }
        .side {
          container-type: normal;
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
          gap: var(--s2) var(--s3);
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
  /** The sector is a found fire spot. */
  @state() private taking = false;
  @state() private view: 'plan' | 'scene' = localStorage.getItem(VIEW_KEY) === 'scene' ? 'scene' : 'plan';
  @state() private sceneLoaded = false;
  @state() private camera = localStorage.getItem(CAMERA_KEY) !== 'hidden';
  /** Only the last press counts, and none from before a STOP, Escape or another tool. */
  private aims = 0;
  @state() private stripHeight = 0;
  private endStop = () => {};
  @state() private target: { Horizontal?: number; Vertical?: number } = {};
  @query('lf-plan') private plan?: LfPlan;
  @query('lf-automatic') private automatic?: LitElement;
  @query('.side') private side?: HTMLElement;

  constructor() {
    super();
    new TopicController(this, () => [SECOND, 'scene', 'monitors/', 'zones', 'cameras/']);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    if (this.view === 'scene') void this.loadScene();
    window.addEventListener('keydown', this.keyed);
    this.endStop = onHalt((halt) => {
      if (!concerns(halt, this.monitor)) return;
      this.forget();
      // A press on the plan that is not over yet aims at nothing any more.
      if (this.plan) this.plan.drag = null;
    });
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    window.removeEventListener('keydown', this.keyed);
    this.endStop();
    this.aims++;
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
        <lf-hand .monitor=${monitor} @moved-by-hand=${this.forget}>${this.dial()}</lf-hand>
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
      <div class="below"><lf-trends .monitor=${monitor}></lf-trends></div>
    </div>`;
  }

  /** Whether the values are on the picture; on a phone they are above it. */
  private beside(): boolean {
    return this.offsetWidth > STACKED_PX;
  }

  override willUpdate(): void {
    // A target is shown to whom it belongs: the one who commands is no longer the one who gave it.
    const aims = this.target.Horizontal !== undefined || this.target.Vertical !== undefined;
    if (aims && !inControl(this.monitor)) this.forget();
  }

  override updated(): void {
    const strip = this.renderRoot.querySelector<HTMLElement>('.strip');
    const height = strip && this.beside() ? strip.offsetHeight + 8 : 0;
    if (!strip || height === this.stripHeight) return;
    this.stripHeight = height;
    this.style.setProperty('--strip', `${height}px`);
  }

  private strip() {
    const { monitor } = this;
    const status = store.get(`monitors/${monitor}/status`);
    const stale = store.stale(monitor);
    const age_ms = stale && status?.at_ms ? store.now() - status.at_ms : null;
    return html`<section class="card strip">
      ${readingOf(monitor, 'angle', 'operate.horizontal', 'Horizontal')}
      ${readingOf(monitor, 'angle', 'operate.vertical', 'Vertical')}
      ${exists(monitor, 'Nozzle') ? readingOf(monitor, 'nozzle', 'operate.nozzle', 'Nozzle') : nothing}
      ${readingOf(monitor, 'pressure', 'operate.pressure', 'General', 'pressure')}
      ${readingOf(monitor, 'flow', 'operate.flow', 'General', 'flowrate')}
      <div class="chips">
        ${
          age_ms !== null || stale
            ? html`<lf-chip id="stale" kind="medium" icon="clock"
              >${age_ms === null ? t('operate.no_data') : t('operate.old', { age: age(age_ms) })}</lf-chip
            >`
            : nothing
        }
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
        >${told.ready ? t('operate.ready') : t('operate.not_ready')}${
          faults.length ? html`&nbsp;· ${faults.length}` : nothing
        }</lf-chip
      >
    </button>`;
  }

  private picture() {
    const { monitor } = this;
    const site = siteOf(monitor);
    const scene = store.get('scene') ?? null;
    const monitors = this.monitors(site);
    const three = this.view === 'scene' && this.sceneLoaded;
    const watched = camerasOf(monitor).length > 0;
    const choice = (tool: Tool, name: 'map' | 'target', text: string, why = '') =>
      html`<lf-button id=${tool} icon=${name} kind="quiet" toggle .on=${this.tool === tool} .why=${why} @click=${() => this.choose(tool)}
        ><span class="word">${text}</span></lf-button
      >`;
    return html`${
      three
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
            .located=${site.schematic ? [] : (store.get('zones')?.fires ?? [])}
            .scene=${scene}
            .selected=${monitor}
            .tool=${this.tool}
            .above=${this.beside() ? TOOLS_PX + this.stripHeight : TOOLS_PX}
            .notes=${this.offsetWidth < NOTES_BELOW_PX ? NOTES_PX : 0}
            .running=${this.onPlan.running(site, store.monitors())}
            .note=${this.tool === 'aim' ? t(flows(monitor, site) ? 'operate.aim_jet' : 'operate.aim_sight') : ''}
            @sector=${(e: CustomEvent<QuenchSector | null>) => this.drawn(e.detail)}
            @sector-change=${(e: CustomEvent<QuenchSector | null>) => this.drawn(e.detail)}
            @aim=${(e: CustomEvent<AimDetail>) => void this.aim(e.detail)}
            @select=${(e: CustomEvent<{ id: string }>) => (location.hash = `#/m/${e.detail.id}/operate`)}
          ></lf-plan>`
    }
      <div class="tools">
        ${
          three
            ? nothing
            : html`${choice('look', 'map', t('operate.look'))}
            ${choice('aim', 'target', t('operate.aim'), whyNotAim(monitor))}`
        }
        <lf-button icon=${three ? 'map' : 'cube'} kind="quiet" @click=${this.turnView}
          >${three ? t('operate.plan_view') : '3D'}</lf-button
        >
        ${
          watched
            ? html`<lf-button id="camera" icon="camera" kind="quiet" toggle .on=${this.camera} @click=${() => this.showCamera(!this.camera)}
                ><span class="word">${t('operate.camera')}</span></lf-button
              >`
            : nothing
        }
      </div>
      ${
        watched && this.camera
          ? html`<lf-camera .monitor=${monitor} @hide=${() => this.showCamera(false)}></lf-camera>`
          : nothing
      }`;
  }

  private showCamera(shown: boolean): void {
    this.camera = shown;
    localStorage.setItem(CAMERA_KEY, shown ? 'shown' : 'hidden');
  }

  private dial() {
    const { monitor } = this;
    return html`<lf-dial
          kind="vertical"
          bare
          .value=${position(monitor, 'Vertical')}
          .target=${has(monitor, 'Vertical', 'Move') && !store.stale(monitor) ? (this.target.Vertical ?? null) : null}
          .limits=${limits(monitor, 'Vertical')}
          .stale=${store.stale(monitor)}
          .moving=${has(monitor, 'Vertical', 'Move') && !store.stale(monitor)}
          .offlimits=${has(monitor, 'Vertical', 'Limitless')}
          .label=${t('operate.vertical')}
        ></lf-dial>`;
  }

  private monitors(site: Site): PlanMonitor[] {
    const { Horizontal } = this.target;
    return this.onPlan.of(site, store.monitors()).map((made) => {
      const moves = has(made.id, 'Horizontal', 'Move') && !store.stale(made.id);
      const aimed = made.id === this.monitor && Horizontal !== undefined && moves;
      return aimed ? { ...made, target_arcmin: Horizontal } : made;
    });
  }

  /** What was pointed at is no longer wanted: a STOP, a motion by hand, another operator. */
  private readonly forget = (): void => {
    this.aims++;
    this.target = {};
  };

  private choose(tool: Tool): void {
    this.aims++;
    this.tool = tool;
    if (tool !== 'look' && this.view === 'scene') this.turnView();
    this.taking = false;
    if (tool !== 'sector') {
      this.sector = null;
      if (this.plan) this.plan.sector = null;
    }
    if (tool !== 'look') void this.showTool();
  }

  /** Shows the plan to draw on, and the part of the scrolling column that belongs to the drawing. */
  private async showTool(): Promise<void> {
    await this.updateComplete;
    this.renderRoot.querySelector('.view')?.scrollIntoView({ block: 'nearest' });
    await this.showPanel();
  }

  /** Once, not while the user types in it. */
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

  /** A fire spot becomes the sector, once its distance is known. */
  private takenFound(sector: QuenchSector | null): void {
    this.sector = sector;
    if (this.plan) this.plan.sector = sector?.sector ?? null;
  }

  /** Both drives move to where the operator pointed last. */
  private async aim(at: AimDetail): Promise<void> {
    const { monitor } = this;
    const turn = ++this.aims;
    const why = whyNotAim(monitor);
    if (why) return toast({ kind: 'info', text: why });
    const over = () => turn !== this.aims || monitor !== this.monitor;
    try {
      let solved = await timely(aimAt(monitor, at));
      if (over()) return;
      if (solved === UNKNOWN) {
        if (!(await this.assumed(monitor)) || over()) return;
        solved = await timely(aimAt(monitor, at, USUAL_PRESSURE_DATM));
      }
      if (over() || solved === UNKNOWN) return;
      if (!solved) return toast({ kind: 'warning', text: `${monitor} · ${t('operate.aim_late')}` });
      await this.go(monitor, solved);
    } catch (cause) {
      toast({ kind: 'error', text: `${monitor} · ${t('operate.aim')}: ${HubError.of(cause).text(lang())}` });
    }
  }

  private async go(monitor: string, { Horizontal, Vertical, kind, text }: Aimed): Promise<void> {
    const why = whyNotWork(monitor, 'Horizontal');
    if (why) return toast({ kind: 'info', text: why });
    this.target = { Horizontal, Vertical };
    const sent = (['Horizontal', 'Vertical'] as const).map((drive) =>
      commands.request(monitor, `Move ${drive} ${this.target[drive]}`, { quiet: true }),
    );
    await Promise.all(sent);
    toast({ kind, text: `${monitor} · ${text}` });
  }

  /** Without a valid pressure nothing is aimed by the jet, unless the operator gives one to assume. */
  private assumed(monitor: string): Promise<boolean> {
    const pressure = show('pressure', USUAL_PRESSURE_DATM);
    return confirmDialog({
      title: `${monitor} · ${t('operate.aim')}`,
      text: t('operate.pressure_unknown'),
      yes: t('operate.pressure_assume', { pressure }),
    });
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

/** An answer that comes while the operator still expects it; null, once it is too late. */
function timely<T>(asked: Promise<T>): Promise<T | null> {
  const began = performance.now();
  const late = new Promise<null>((done) => window.setTimeout(() => done(null), SOLVED_MOST_MS));
  const answer = asked.then((value) => (performance.now() - began > SOLVED_MOST_MS ? null : value));
  return Promise.race([answer, late]);
}

const SCENES = import.meta.glob('../parts/lf-scene.ts');

function showReadiness(monitor: string, told: Readiness): void {
  void dialog.open({
    title: t(told.ready ? 'operate.ready_title' : 'operate.not_ready_title', { monitor }),
    content: () =>
      told.reasons.length === 0
        ? html`<p>${t('operate.ready_text')}</p>`
        : html`${told.reasons.map(
            (reason) => html`<div class="row top">
              ${icon(reason.severity === 'alarm' ? 'alarm' : reason.severity === 'warning' ? 'warning' : 'info', 22)}
              <div>
                <b>${reason.subsystem ? `${reason.subsystem}: ` : ''}${tt(reason.what)}</b>
                <p class="dim">${tt(reason.remedy)}</p>
              </div>
            </div>`,
          )}`,
  });
}
