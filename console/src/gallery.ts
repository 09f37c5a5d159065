// All parts on one page, with changing values: for their development. Not built
// into the console. gallery.html?theme=night&lang=ru&only=plan

import { css, html, LitElement, type TemplateResult } from 'lit';
import { customElement } from 'lit/decorators.js';
import type { Jet } from './hub/jets';
import { loadLang } from './i18n';
import { type PlanMonitor, type PlanScene, type PlanSite, planMonitor } from './parts/lf-plan';
import './parts/lf-dial';
import './parts/lf-joystick';
import type { LfPlot, PlotSeries } from './parts/lf-plot';
import './parts/lf-plot';
import './parts/lf-scene';
import './parts/lf-slider';
import './parts/lf-timeline';

const SITE: PlanSite = {
  monitors: {
    M1: { at: [-20, -20], heading: 45, height: 6 },
    M2: { at: [33, -18], heading: 312, height: 6 },
    M3: { at: [-26, 10], heading: 111, height: 6 },
  },
  tanks: [
    { name: 'T-1', at: [0, 0], diameter: 10, height: 6 },
    { name: 'T-2', at: [12.5, 0], diameter: 10, height: 6 },
    { name: 'T-3', at: [0, 15], diameter: 10, height: 6 },
    { name: 'T-4', at: [15, 15], diameter: 10, height: 6 },
  ],
  walls: [{ name: 'W', from: [-12, -9], to: [-4, -14], height: 3 }],
  keep_outs: [{ name: 'Stand', for: 'people', monitor: null, bearings: [350, 20], elevations: [-90, 90] }],
};
const SERIES: PlotSeries[] = [
  { id: 'pressure', label: 'Pressure', unit: 'MPa', digits: 2, range: [0, 1.2] },
  { id: 'flow', label: 'Flow', unit: 'l/s', digits: 0, range: [0, 30] },
];

const parameters = new URLSearchParams(location.search);
document.documentElement.dataset.theme = parameters.get('theme') ?? 'day';

/** As POST /api/jets answers: 96 × 0.1 atm, 28 mm, 6.2° up, 6 m above the ground. */
const JET: Jet = {
  pressure_datm: 96,
  reach_m: 47.73,
  flight: {
    points: [
      [0.0, 0.0, 0.0],
      [3.75, 0.37, 0.088],
      [7.5, 0.66, 0.177],
      [11.25, 0.86, 0.27],
      [15.0, 0.98, 0.372],
      [18.75, 0.99, 0.486],
      [22.5, 0.84, 0.622],
      [26.25, 0.48, 0.785],
      [30.0, -0.2, 0.982],
      [33.75, -1.33, 1.221],
      [37.5, -3.15, 1.514],
      [41.24, -6.0, 1.879],
    ],
    lands_m: 41.24,
    core_m: 21.28,
    speed_mps: 42.78,
  },
  fault: null,
  throw: {
    middle_m: { value: 33.1, low: 27.0, high: 39.8 },
    greatest_m: { value: 38.6, low: 34.7, high: 42.2 },
    left_m: { value: 2.4, low: 1.6, high: 3.2 },
    across_m: 1.1,
    flow_lps: 22,
    wind: { along_mps: 2, left_mps: 3 },
  },
  no_throw: null,
};

@customElement('lf-gallery')
export class Gallery extends LitElement {
  private at_ms = 0;
  private log: string[] = [];
  private selected = 'M1';
  private tool: 'look' | 'sector' | 'aim' = (parameters.get('tool') as 'look') ?? 'look';

  static override styles = css`
    :host {
      display: grid;
      gap: var(--s3);
      padding: var(--s4);
      grid-template-columns: repeat(12, 1fr);
    }
    section {
      background: var(--surface);
      border: 1px solid var(--line);
      border-radius: var(--radius-large);
      padding: var(--s3);
      display: grid;
      gap: var(--s3);
      align-content: start;
      min-width: 0;
    }
    .plan {
      grid-column: span 8;
      padding: 0;
      overflow: hidden;
    }
    .plan lf-plan,
    .plan lf-scene {
      height: 780px;
    }
    .side {
      grid-column: span 4;
    }
    .third {
      grid-column: span 4;
    }
    .half {
      grid-column: span 6;
    }
    .two {
      grid-template-columns: 1fr 1fr;
    }
    .mini {
      height: 160px;
    }
    lf-plot {
      height: 240px;
    }
    .whole {
      grid-column: span 12;
    }
    .grid {
      display: grid;
      gap: var(--s3);
    }
    pre {
      margin: 0;
      min-height: 6em;
      font-size: var(--t-small);
      overflow: hidden;
    }
  `;

  override connectedCallback(): void {
    super.connectedCallback();
    if (parameters.has('still')) this.at_ms = Number(parameters.get('still'));
    else {
      const step = (now: number): void => {
        this.at_ms = now;
        this.requestUpdate();
        setTimeout(() => requestAnimationFrame(step), 80);
      };
      requestAnimationFrame(step);
    }
  }

  protected override firstUpdated(): void {
    const plot = this.renderRoot.querySelector('lf-plot') as LfPlot | null;
    if (!plot) return;
    const now = Date.now();
    for (let at = now - 55_000; at < now; at += 200) this.feed(plot, at);
    if (!parameters.has('still')) setInterval(() => this.feed(plot, Date.now()), 200);
  }

  private feed(plot: LfPlot, at: number): void {
    const off = at % 60_000 > 30_000 && at % 60_000 < 36_000;
    if (off) return;
    plot.push(at, {
      pressure: 0.86 + Math.sin(at / 4000) * 0.08,
      flow: 18 + Math.sin(at / 2700) * 3,
    });
  }

  private get scene(): PlanScene {
    const sway = Math.sin(this.at_ms / 900) * 2;
    return {
      t_s: this.at_ms / 1000,
      wind: [3, 2],
      fires: [
        { name: 'roof-1', at: [0, 0], size: 8, base: 6, burns: true, heat_kw: 2800 },
        { name: 'roof-2', at: [12.5, 0], size: 8, base: 6, burns: false, heat_kw: 0 },
      ],
      jets: { M1: { lps: 18, lands: [1 + sway, -sway], litres: 400 } },
      splashes: [{ monitor: 'M1', at: [1 + sway + Math.random(), Math.random() * 2 - sway], litres: 2, foam: 0 }],
    };
  }

  private get monitors(): PlanMonitor[] {
    const sway = Math.sin(this.at_ms / 900) * 150;
    const status = (position: number, more: Record<string, string[]>, stale = false): never =>
      ({
        at_ms: 1,
        stale,
        subsystems: {
          Horizontal: { position, flags: [], severity: 'info' },
          Vertical: { position: 369, flags: [] },
          Nozzle: { position: 60, flags: [] },
          General: { pressure: 96, flags: [], severity: more.alarm ? 'alarm' : 'info' },
          Valve1: { flags: more.Valve1 ?? [] },
          Deployer: { flags: more.Deployer ?? [] },
        },
      }) as never;
    const free = { Horizontal: { min: -10800, max: 10800 }, Vertical: { min: -900, max: 4500 } };
    const narrow = { Horizontal: { min: -5400, max: 4200 }, Vertical: { min: -900, max: 4500 } };
    const hotbeds = { list: [{ x1: -200, x2: 160, y1: 0, y2: 40, brightness: 900 }] };
    const made = [
      planMonitor('M1', SITE, {
        status: status(sway, { Valve1: ['Open'] }),
        limits: parameters.has('narrow') ? narrow : free,
        scene: this.scene,
        hotbeds,
        jet: JET,
      }),
      planMonitor('M2', SITE, { status: status(-1200, { alarm: ['x'] }), limits: narrow, scene: this.scene }),
      planMonitor('M3', SITE, {
        status: status(300, { Deployer: ['Wrapped'] }, true),
        limits: free,
        scene: this.scene,
      }),
    ];
    if (made[0]) made[0].target_arcmin = 900;
    return made.filter((monitor) => monitor !== null);
  }

  private said = (event: Event): void => {
    const { detail } = event as CustomEvent;
    this.log = [`${event.type} ${JSON.stringify(detail)}`, ...this.log].slice(0, 6);
    if (event.type === 'select') this.selected = detail.id;
    this.requestUpdate();
  };

  protected override render(): TemplateResult {
    const { monitors, scene } = this;
    const sway = Math.sin(this.at_ms / 900);
    return html`
      <section class="plan">
        <lf-plan
          .site=${SITE}
          .scene=${scene}
          .monitors=${monitors}
          .selected=${this.selected}
          .tool=${this.tool}
          .running=${{ M1: { bearing: 45, width: 6, near_m: 26, far_m: 31 } }}
          @select=${this.said}
          @sector=${this.said}
          @aim=${this.said}
        ></lf-plan>
      </section>
      <section class="plan whole">
        <lf-scene
          .site=${SITE}
          .scene=${scene}
          .monitors=${monitors}
          .selected=${this.selected}
          .preset=${parameters.get('preset') ?? 'orbit'}
        ></lf-scene>
      </section>
      <section class="side">
        <div class="two grid">
          <lf-dial .value=${369 + sway * 200} .target=${900} .limits=${{ min: -900, max: 4500 }} moving></lf-dial>
          <lf-dial kind="horizontal" .value=${sway * 600} .target=${-2400} .heading=${45} .limits=${{ min: -5400, max: 4200 }}></lf-dial>
          <lf-dial .value=${-900} .limits=${{ min: -900, max: 4500 }} stale></lf-dial>
          <lf-dial kind="horizontal" .limits=${{ min: -10800, max: 10800 }} .value=${4000} offlimits></lf-dial>
        </div>
        <lf-slider .value=${42} .target=${55} .limits=${{ min: 0, max: 60 }} @set=${this.said}></lf-slider>
        <lf-slider .value=${60} .limits=${{ min: 0, max: 60 }} disabled reason="Not in control of M1."></lf-slider>
      </section>
      <section class="third">
        <lf-joystick .at=${{ Vertical: 'max' }} @hold=${this.said} @release=${this.said}></lf-joystick>
      </section>
      <section class="third">
        <lf-joystick variant="buttons" .at=${{ Horizontal: 'min' }} @hold=${this.said} @release=${this.said}></lf-joystick>
      </section>
      <section class="third">
        <lf-joystick disabled reason="anna is in control. Request control first."></lf-joystick>
      </section>
      <section class="half">
        <lf-plot .series=${SERIES} label="M1"></lf-plot>
      </section>
      <section class="half two">
        <div class="mini"><lf-plan class="mini" mode="mini" .site=${SITE} .scene=${scene} .monitors=${monitors} selected="M1"></lf-plan></div>
      </section>
      <section class="whole">
        <lf-timeline
          .from=${0}
          .to=${240_000}
          .at=${90_000}
          .marks=${[
            { at_ms: 30_000, kind: 'command', text: 'M1 Open Valve1 (anna)' },
            { at_ms: 32_000, kind: 'alarm', text: 'M1: The drive draws too much current.' },
            { at_ms: 150_000, kind: 'event', text: 'M2 linked' },
          ]}
          @seek=${this.said}
        ></lf-timeline>
      </section>
      <section class="whole"><pre>${this.log.join('\n')}</pre></section>
    `;
  }
}

await loadLang();
document.body.append(document.createElement('lf-gallery'));
