// The programs and trajectories stored in a monitor: view, draw, store, run.
import { html, LitElement, nothing } from 'lit';
import { customElement, property, query, state } from 'lit/decorators.js';
import { type Dictionary, dictionary, param } from '../hub/dictionary';
import { linkFigures, whyNot } from '../hub/session';
import { SECOND, store, TopicController } from '../hub/store';
import { age, num, plural, t } from '../i18n';
import { bearingOf, type Place, placeAt, type QuenchSector, type Sector, sectorOf } from '../parts/geometry';
import { icon } from '../parts/icons';
import '../parts/lf-aim-chart';
import type { LfAimChart, PointDetail, SectorDetail } from '../parts/lf-aim-chart';
import '../parts/lf-button';
import '../parts/lf-chip';
import { type AimDetail, type PlanMonitor, type PlanPointDetail, planMonitor } from '../parts/lf-plan';
import type { Direction } from '../parts/raster';
import { standAlone } from '../parts/stand-alone';
import { dialog } from '../shell/dialog';
import { toast } from '../shell/toasts';
import { base, card, fields, page } from '../theme/shared';
import { show } from '../units';
import { jetOf } from './operate/on-plan';
import { position } from './operate/state';
import { FileError, fileName } from './params/backup';
import { download, opened } from './params/files';
import { outcomeLine, problemText } from './params/row';
import type { Outcome } from './params/save';
import { editing } from './params/state';
import { outcomeStyle } from './params/style';
import { isFull, nozzleNote, pointTable, programForm } from './programs/forms';
import {
  factsOfPoints,
  factsOfProgram,
  fromFile,
  isEmpty,
  type Kind,
  type Point,
  pointsOf,
  problemOf,
  programOf,
  same,
  titleFor,
  toFile,
  valuesOfPoints,
  valuesOfProgram,
  type Which,
} from './programs/model';
import './programs/run';
import { type Drafts, drafts, every, limitsOf, titleText } from './programs/state';
import { programsStyle } from './programs/style';
import { thumb } from './programs/thumb';

const SELECTED_KEY = 'lafet.programs.selected';
/** Distance, m, where none was given. */
const DISTANCE_M = 25;

@customElement('lf-page-programs')
export class PagePrograms extends LitElement {
  static override styles = [base, card, fields, page, outcomeStyle, programsStyle];

  @property() monitor = '';
  @state() private dictionary: Dictionary | null = null;
  @state() private which: Which = remembered();
  @state() private point = 0;
  @state() private view: 'chart' | 'plan' = 'chart';
  @state() private turn = 0;
  @state() private adding = false;
  @query('lf-aim-chart') private chart?: LfAimChart;
  private drafts!: Drafts;
  /** As drawn on the plan: a program does not store its near and far edges. */
  private onPlan: { values: string; sector: Sector } | null = null;
  private outcomes = new Map<string, Outcome>();

  constructor() {
    super();
    new TopicController(this, () => [`monitors/${this.monitor}/`, SECOND]);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    void dictionary().then((found) => (this.dictionary = found));
  }

  override willUpdate(changed: Map<string, unknown>): void {
    if (changed.has('monitor')) this.drafts = drafts(this.monitor);
  }

  override render() {
    const { monitor } = this;
    const why = whyNot(monitor, { role: 'engineer', lockedOut: true });
    const known = every().some((which) => this.drafts.stored(which));
    return html`<div class="page">
      <header class="head">
        <h1>${t('programs.title')}</h1>
        ${this.headActs(why)}
      </header>
      ${why ? html`<p class="look">${icon('info', 18)}<span>${t('programs.look', { monitor })} ${why}.</span></p>` : nothing}
      ${
        !this.dictionary
          ? nothing
          : known
            ? html`<div class="columns">${this.list()} ${this.editor(why)} ${this.side()}</div>`
            : this.unread()
      }
      <input hidden type="file" accept=".toml,.json,.txt" @change=${this.opened} />
    </div>`;
  }

  private unread() {
    const now = editing(this.monitor);
    const why = whyNot(this.monitor, { role: 'observer', authority: false, lockedOut: true });
    return html`<div class="empty">
      ${icon('programs', 40)}
      <p>${t('programs.not_read', { monitor: this.monitor })}</p>
      <lf-button icon="refresh" .why=${now.busy ? t('params.busy') : why} @click=${() => now.readAll()}
        >${t('programs.read')}</lf-button
      >
    </div>`;
  }

  private headActs(why: string) {
    const none = every().some((which) => !isEmpty(which.kind, this.drafts.values(which)));
    const nothingYet = none ? '' : t('programs.why_nothing');
    const unsaved = this.drafts.unsaved();
    const busy = editing(this.monitor).busy ? t('params.busy') : '';
    return html`<div class="acts">
      ${
        unsaved.length > 1
          ? html`<lf-button kind="primary" .why=${why || busy} @click=${() => this.store(unsaved)}
            >${plural(unsaved.length, 'programs.store_all')}</lf-button
          >`
          : nothing
      }
      <lf-button icon="upload" @click=${this.choose}>${t('programs.import')}</lf-button>
      <lf-button icon="download" title=${t('programs.export_hint')} .why=${nothingYet} @click=${() => this.save('toml')}
        >${t('programs.export')}</lf-button
      >
      <lf-button .why=${nothingYet} @click=${() => this.save('json')}>${t('programs.export_json')}</lf-button>
    </div>`;
  }

  private list() {
    const group = (kind: Kind, title: string) => html`<h2>${title}</h2>
      <div class="cards">
        ${every()
          .filter((which) => which.kind === kind)
          .map((which) => this.entry(which))}
      </div>`;
    return html`<nav class="list card" aria-label=${t('programs.title')}>
      ${group('Program', t('programs.programs'))} ${group('Trajectory', t('programs.trajectories'))}
    </nav>`;
  }

  private entry(which: Which) {
    const values = this.drafts.values(which);
    const on = same(which, this.which);
    const unsaved = this.drafts.isUnsaved(which);
    const empty = isEmpty(which.kind, values);
    return html`<button class="entry ${on ? 'on' : ''} ${empty ? 'none' : ''}" aria-current=${on ? 'true' : 'false'} @click=${() => this.select(which)}>
      ${thumb(which, values)}
      <span class="text">
        <b>${which.number}</b>
        <span class="sum">${this.summary(which, values)}</span>
        ${unsaved ? html`<span class="unsaved">${icon('edit', 14)}${t('programs.unsaved')}</span>` : nothing}
      </span>
    </button>`;
  }

  private summary(which: Which, values: readonly number[]): string {
    if (!this.drafts.stored(which) && !this.drafts.isUnsaved(which)) return t('programs.unread');
    if (isEmpty(which.kind, values)) return t('programs.empty');
    if (which.kind === 'Trajectory') return plural(values.length / 4, 'programs.points');
    const { centre, width, height, step } = programOf(values);
    if (step === 0) return t('programs.aim_only', { at: `${show('angle', centre.h)}, ${show('angle', centre.v)}` });
    return t('programs.sector_of', { w: show('angle', width), h: show('angle', height), step: `${step}°` });
  }

  private editor(why: string) {
    const { which } = this;
    const values = this.drafts.values(which);
    return html`<section class="editor card" aria-label=${titleText(which)}>
      <header>
        <h2>${titleText(which)}</h2>
        <div class="views" role="group">
          <lf-button toggle icon="sector" .on=${this.view === 'chart'} @click=${() => (this.view = 'chart')}
            >${t('programs.view_chart')}</lf-button
          ><lf-button toggle icon="map" .on=${this.view === 'plan'} @click=${() => (this.view = 'plan')}
            >${t('programs.view_plan')}</lf-button
          >
        </div>
      </header>
      <div class="picture">${this.view === 'chart' ? this.chartOf(values) : this.planOf(values)}</div>
      ${this.facts(values)}
      ${which.kind === 'Program' ? this.programPart(values) : this.trajectoryPart(values)}
      ${this.foot(why, values)}
    </section>`;
  }

  private chartOf(values: readonly number[]) {
    const { which, monitor } = this;
    const trajectory = which.kind === 'Trajectory';
    return html`<lf-aim-chart
      .subject="${monitor} ${which.kind} ${which.number}"
      .limits=${limitsOf(monitor)}
      .barrel=${this.barrel()}
      ?stale=${store.stale(monitor)}
      .sector=${trajectory ? null : programOf(values)}
      .points=${trajectory ? pointsOf(values) : []}
      .selected=${trajectory ? this.point : -1}
      ?adding=${trajectory && this.adding}
      @sector=${this.drawn}
      @sector-change=${this.drawn}
      @point=${this.dragged}
      @point-change=${this.dragged}
      @point-select=${(e: CustomEvent<PointDetail>) => (this.point = e.detail.index)}
      @point-remove=${(e: CustomEvent<PointDetail>) => this.removePoint(e.detail.index)}
      @point-add=${(e: CustomEvent<Direction>) => this.addPoint({ ...e.detail })}
    ></lf-aim-chart>`;
  }

  private planOf(values: readonly number[]) {
    const { monitor, which } = this;
    const site = standAlone(store.hello?.hub.site ?? null, store.monitors(), monitor);
    const monitors = store
      .monitors()
      .map((id) =>
        planMonitor(id, site, {
          status: store.get(`monitors/${id}/status`),
          limits: (store.get(`monitors/${id}/limits`) ?? null) as never,
          down: store.stale(id),
          jet: jetOf(id, site),
        }),
      )
      .filter((m): m is PlanMonitor => m !== null);
    const stand = site.monitors[monitor]!;
    const program = programOf(values);
    const trajectory = which.kind === 'Trajectory';
    const request = {
      centre_arcmin: [program.centre.h, program.centre.v] as [number, number],
      width_arcmin: Math.max(program.width, 60),
      height_arcmin: program.height,
      distance_m: program.distance || DISTANCE_M,
    };
    const empty = isEmpty(which.kind, values);
    const kept = this.onPlan?.values === String(values) ? this.onPlan.sector : null;
    const drawn = kept ?? sectorOf(stand, request);
    const places: Place[] = trajectory
      ? pointsOf(values).map((at) => placeAt(stand.at, bearingOf(stand.heading, at.h), at.distance || DISTANCE_M))
      : [];
    return html`<lf-plan
      .site=${site}
      .monitors=${monitors}
      .scene=${store.get('scene') ?? null}
      .selected=${monitor}
      .tool=${trajectory ? 'aim' : 'sector'}
      .sector=${trajectory || empty ? null : drawn}
      .points=${places}
      .pointSelected=${trajectory ? this.point : -1}
      @sector=${this.planned}
      @sector-change=${this.planned}
      @aim=${(e: CustomEvent<AimDetail>) => this.aimed(e.detail)}
      @point-select=${(e: CustomEvent<{ index: number }>) => (this.point = e.detail.index)}
      @point-change=${(e: CustomEvent<PlanPointDetail>) => this.placed(e.detail)}
    ></lf-plan>`;
  }

  private facts(values: readonly number[]) {
    const { which, monitor } = this;
    if (isEmpty(which.kind, values)) return html`<p class="facts"><span class="dim">${t('programs.empty')}</span></p>`;
    const limits = limitsOf(monitor);
    const found = param('Control', titleFor(which).split('.')[1]!);
    const problem = found ? problemOf(found, values) : null;
    const warn: unknown[] = [];
    const told: string[] = [];
    if (which.kind === 'Program') {
      const program = programOf(values);
      const facts = factsOfProgram(program, limits, this.barrel() ?? { h: 0, v: 0 });
      if (program.step === 0) told.push(t('programs.fact_stays'));
      else {
        told.push(plural(facts.lines, 'programs.fact_lines'));
        told.push(t('programs.fact_pass', { s: age(facts.seconds * 1000) }));
      }
      if (facts.lies !== 'inside') warn.push(t(facts.lies === 'partly' ? 'programs.partly' : 'programs.outside'));
      const nozzle = nozzleNote(program, limits?.Nozzle);
      if (nozzle !== nothing) warn.push(nozzle);
    } else {
      const facts = factsOfPoints(pointsOf(values), limits);
      told.push(plural(facts.lines, 'programs.points'));
      told.push(t('programs.fact_walk', { s: age(facts.seconds * 1000) }));
      if (facts.lies !== 'inside') warn.push(t('programs.points_outside'));
    }
    if (problem && found) warn.push(problemText(found, problem));
    return html`<p class="facts" role="status">
      ${told.map((text) => html`<span>${text}</span>`)}
      ${warn.map((text) => html`<span class="warn">${icon('warning', 16)}${text}</span>`)}
    </p>`;
  }

  private programPart(values: readonly number[]) {
    return html`${programForm(programOf(values), (p) => this.change(valuesOfProgram(p)))}
      <div class="acts">
        <lf-button icon="target" title=${t('programs.take_hint')} .why=${this.whyNoPosition()} @click=${this.take}
          >${t('programs.take')}</lf-button
        >
      </div>`;
  }

  private trajectoryPart(values: readonly number[]) {
    const points = pointsOf(values);
    const full = isFull(points) ? t('programs.why_full') : '';
    return html`<div class="acts">
        <lf-button icon="target" .why=${this.whyNoPosition() || full} @click=${this.takePoint}
          >${t('programs.take_point')}</lf-button
        >
        <lf-button icon="plus" .why=${full} @click=${() => this.addPoint(this.nextPoint(points))}
          >${t('programs.add_point')}</lf-button
        >
        ${
          this.view === 'chart'
            ? html`<lf-button toggle .on=${this.adding} .why=${full} @click=${() => (this.adding = !this.adding)}
              >${t('programs.add_by_press')}</lf-button
            >`
            : nothing
        }
      </div>
      ${pointTable({
        points,
        selected: this.point,
        limits: limitsOf(this.monitor),
        select: (index) => (this.point = index),
        change: (all) => this.change(valuesOfPoints(all)),
      })}`;
  }

  private foot(why: string, values: readonly number[]) {
    const { which, monitor } = this;
    const unsaved = this.drafts.isUnsaved(which);
    const empty = isEmpty(which.kind, values);
    const busy = editing(monitor).busy ? t('params.busy') : '';
    const found = param('Control', titleFor(which).split('.')[1]!);
    const bad = found && problemOf(found, values) ? t('programs.why_problem') : '';
    const outcome = this.outcomes.get(titleFor(which));
    return html`<footer>
      <div class="told">
        ${
          outcome && found
            ? outcomeLine(found, outcome)
            : html`<span class="dim">${unsaved ? t('programs.unsaved') : t('programs.stored_same')}</span>`
        }
      </div>
      <lf-button kind="quiet" .why=${empty ? t('programs.why_empty') : ''} @click=${this.duplicate}
        >${t('programs.duplicate')}</lf-button
      >
      <lf-button kind="quiet" icon="trash" .why=${empty ? t('programs.why_empty') : ''} @click=${() =>
        this.change(which.kind === 'Program' ? new Array<number>(7).fill(0) : [])}
        >${t('programs.clear')}</lf-button
      >
      <lf-button kind="quiet" .why=${unsaved ? '' : t('programs.no_draft')} @click=${this.revert}
        >${t('programs.revert')}</lf-button
      >
      <lf-button kind="primary" .why=${(unsaved ? '' : t('programs.no_draft')) || bad || why || busy} @click=${() => this.store([which])}
        >${t('programs.store', { monitor })}</lf-button
      >
    </footer>`;
  }

  private side() {
    const { which, monitor } = this;
    return html`<lf-program-run
      class="side"
      .monitor=${monitor}
      .which=${which}
      .stored=${this.drafts.stored(which) ?? null}
      .unsaved=${this.drafts.isUnsaved(which)}
      .turn=${this.turn + store.now()}
    ></lf-program-run>`;
  }

  private barrel(): Direction | null {
    const [h, v] = [position(this.monitor, 'Horizontal'), position(this.monitor, 'Vertical')];
    return h === null || v === null ? null : { h, v };
  }

  private whyNoPosition(): string {
    return this.barrel() && !store.stale(this.monitor) ? '' : t('programs.why_stale');
  }

  private select(which: Which): void {
    this.which = which;
    this.point = 0;
    this.adding = false;
    localStorage.setItem(SELECTED_KEY, JSON.stringify(which));
  }

  private change(values: number[]): void {
    this.drafts.set(this.which, values);
    this.outcomes.delete(titleFor(this.which));
    this.turn += 1;
  }

  private readonly revert = (): void => {
    this.drafts.revert(this.which);
    this.turn += 1;
  };

  private readonly drawn = (event: CustomEvent<SectorDetail>): void => {
    const { centre, width, height } = event.detail;
    this.change(valuesOfProgram({ ...programOf(this.drafts.values(this.which)), centre, width, height }));
  };

  /** Drawn on the plan, with the distance; an empty program gets a scan step. */
  private readonly planned = (event: CustomEvent<QuenchSector | null>): void => {
    if (!event.detail) return;
    const before = programOf(this.drafts.values(this.which));
    const fresh = isEmpty('Program', valuesOfProgram(before));
    const { centre_arcmin, width_arcmin, height_arcmin, distance_m, sector } = event.detail;
    const values = valuesOfProgram({
      centre: { h: centre_arcmin[0], v: centre_arcmin[1] },
      width: width_arcmin,
      height: height_arcmin,
      distance: distance_m,
      step: fresh ? 1 : before.step,
      nozzle: fresh ? (limitsOf(this.monitor)?.Nozzle?.max ?? 60) : before.nozzle,
    });
    this.onPlan = { values: String(values), sector };
    this.change(values);
  };

  private readonly dragged = (event: CustomEvent<PointDetail>): void => {
    const { index, at } = event.detail;
    const points = pointsOf(this.drafts.values(this.which));
    const point = points[index];
    if (!point) return;
    points[index] = { ...point, h: at.h, v: at.v };
    this.change(valuesOfPoints(points));
  };

  private placed({ index, horizontal_arcmin: h, sight_arcmin: v, distance_m }: PlanPointDetail): void {
    const points = pointsOf(this.drafts.values(this.which));
    const point = points[index];
    if (!point) return;
    points[index] = { ...point, h, v, distance: Math.min(Math.round(distance_m), 255) };
    this.change(valuesOfPoints(points));
  }

  private aimed({ horizontal_arcmin: h, sight_arcmin: v, distance_m }: AimDetail): void {
    if (isFull(pointsOf(this.drafts.values(this.which)))) return;
    this.addPoint({ h, v, distance: Math.min(Math.round(distance_m), 255) });
  }

  private readonly take = (): void => {
    const at = this.barrel();
    if (!at) return;
    const nozzle = position(this.monitor, 'Nozzle');
    const before = programOf(this.drafts.values(this.which));
    this.change(valuesOfProgram({ ...before, centre: at, nozzle: nozzle ?? before.nozzle }));
    this.chart?.fit();
  };

  private readonly takePoint = (): void => {
    const at = this.barrel();
    if (at) this.addPoint(at);
  };

  private nextPoint(points: readonly Point[]): Direction {
    const last = points.at(-1);
    return last ? { h: last.h - 120, v: last.v } : (this.barrel() ?? { h: 0, v: 0 });
  }

  private addPoint(at: Partial<Point> & Direction): void {
    const points = pointsOf(this.drafts.values(this.which));
    if (isFull(points)) return;
    const last = points.at(-1);
    points.push({ distance: last?.distance ?? DISTANCE_M, dwell: last?.dwell ?? 10, ...at });
    this.point = points.length - 1;
    this.change(valuesOfPoints(points));
  }

  private removePoint(index: number): void {
    const points = pointsOf(this.drafts.values(this.which));
    this.change(valuesOfPoints(points.filter((_, n) => n !== index)));
    this.point = Math.min(this.point, points.length - 2);
  }

  private readonly duplicate = async (): Promise<void> => {
    const { which } = this;
    const others = every().filter(({ kind, number }) => kind === which.kind && number !== which.number);
    const to = await dialog.open<Which>({
      title: t('programs.duplicate_to', { from: titleText(which) }),
      content: (close) => html`<div class="col">
        ${others.map((other) => {
          const empty = isEmpty(other.kind, this.drafts.values(other));
          return html`<lf-button @click=${() => close(other)}
            >${titleText(other)} · ${this.summary(other, this.drafts.values(other))}${empty ? '' : ' !'}</lf-button
          >`;
        })}
        <p class="dim">! ${t('programs.duplicate_over')}</p>
      </div>`,
    });
    if (!to) return;
    this.drafts.set(to, [...this.drafts.values(which)]);
    this.select(to);
    toast({ kind: 'info', text: t('programs.copied', { from: titleText(which), to: titleText(to) }) });
  };

  private async store(all: readonly Which[]): Promise<void> {
    const now = editing(this.monitor);
    const items = all.flatMap((which) => {
      const found = param('Control', titleFor(which).split('.')[1]!);
      const values = this.drafts.values(which);
      if (!found || problemOf(found, values)) return [];
      return [{ param: found, wanted: values, before: this.drafts.stored(which) }];
    });
    await now.save(items, (title, outcome) => {
      this.outcomes.set(title, outcome);
      this.turn += 1;
    });
    for (const which of all) if (!this.drafts.isUnsaved(which)) this.drafts.revert(which);
    this.turn += 1;
  }

  private save(kind: 'toml' | 'json'): void {
    if (!this.dictionary) return;
    const values = new Map(
      every()
        .filter((which) => !isEmpty(which.kind, this.drafts.values(which)))
        .map((which) => [titleFor(which), this.drafts.values(which)]),
    );
    const about = {
      url: linkFigures(this.monitor)?.endpoint ?? '',
      subsystems: Object.keys(store.get(`monitors/${this.monitor}/status`)?.subsystems ?? {}),
      made_by: `lafet console ${store.hello?.hub.version ?? ''}`.trim(),
    };
    const order = this.dictionary.subsystems.map(({ name }) => name);
    about.subsystems.sort((a, b) => order.indexOf(a) - order.indexOf(b));
    const text = toFile(kind, values, about, this.dictionary);
    download(fileName(this.monitor, store.now(), 'programs', kind), text);
  }

  private readonly choose = (): void => {
    this.renderRoot.querySelector<HTMLInputElement>('input[type=file]')?.click();
  };

  private async opened(event: Event): Promise<void> {
    const file = await opened(event);
    if (!file || !this.dictionary) return;
    try {
      const found = fromFile(file.text, this.dictionary);
      for (const which of every()) {
        const values = found.get(titleFor(which));
        if (values) this.drafts.set(which, values);
      }
      this.turn += 1;
      const n = num(found.size);
      toast({
        kind: 'info',
        text: plural(found.size, 'programs.imported').replace('{name}', file.name).replace('{n}', n),
      });
    } catch (cause) {
      if (!(cause instanceof FileError)) throw cause;
      const text = t('params.file_wrong', { name: file.name });
      toast({ kind: 'error', text, more: t(cause.key, cause.args) });
    }
  }
}

function remembered(): Which {
  try {
    const which = JSON.parse(localStorage.getItem(SELECTED_KEY) ?? '') as Which;
    return every().find((one) => same(one, which)) ?? { kind: 'Program', number: 0 };
  } catch {
    return { kind: 'Program', number: 0 };
  }
}
