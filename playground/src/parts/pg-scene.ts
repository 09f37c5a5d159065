// The monitor from above and from the side, with its jet, fires and limits. The figures come from the simulator; nothing
// of the flight of water is known here.
import { css, html, LitElement, nothing, svg, type TemplateResult } from 'lit';
import { customElement, property } from 'lit/decorators.js';
import { num, t } from '../i18n';
import { shared } from '../style';
import type { Scene } from '../wire';

/** Half of the width of the plan, m. */
const REACH_M = 50;
const RINGS_M = [20, 40];
/** Length of the drawn barrel, m: larger than life. */
const BARREL_M = 6;
const SIDE_TOP_M = 30;

type Svg = TemplateResult<2>;

@customElement('pg-scene')
export class SceneView extends LitElement {
  static override styles = [
    shared,
    css`
      svg {
        width: 100%;
        height: auto;
        background: var(--sunken);
        border-radius: var(--radius);
        display: block;
      }
      figure {
        margin: 0;
        display: grid;
        gap: var(--s1);
      }
      figcaption {
        color: var(--dim);
        font-size: var(--t-note);
      }
      .ring,
      .axis {
        fill: none;
        stroke: var(--line);
        stroke-width: 0.3;
      }
      .ground {
        stroke: var(--line-strong);
        stroke-width: 0.4;
      }
      .limit {
        stroke: var(--medium);
        stroke-width: 0.4;
        stroke-dasharray: 1.5 1;
        fill: none;
      }
      .barrel {
        stroke: var(--text);
        stroke-width: 1.6;
        stroke-linecap: round;
      }
      .barrel.stowed {
        stroke: var(--dim);
      }
      .base {
        fill: var(--text);
      }
      .jet {
        fill: none;
        stroke: var(--water);
        stroke-width: 0.9;
      }
      .print {
        fill: var(--water);
        opacity: 0.5;
      }
      .fire {
        fill: var(--fire);
      }
      .out {
        fill: none;
        stroke: var(--dim);
        stroke-width: 0.4;
        stroke-dasharray: 1 1;
      }
      .move {
        fill: none;
        stroke: var(--accent);
        stroke-width: 0.9;
        marker-end: url(#head);
      }
      .head {
        fill: var(--accent);
      }
      text {
        font: 3px var(--font);
        fill: var(--dim);
      }
      dl {
        display: grid;
        grid-template-columns: auto 1fr;
        gap: var(--s05) var(--s25);
        margin: 0;
        font-size: var(--t-note);
      }
      dt {
        color: var(--dim);
      }
      dd {
        margin: 0;
      }
    `,
  ];

  @property({ attribute: false }) scene: Scene | null = null;

  protected override render(): TemplateResult | typeof nothing {
    const { scene } = this;
    if (!scene) return nothing;
    return html`<section class="card" aria-labelledby="scene">
      <h2 id="scene">${t('scene.title')}</h2>
      <figure>
        <svg viewBox="-50 -50 100 76" role="img" aria-label="${t('scene.plan')}: ${spoken(scene)}">
          ${arrowHead()}${plan(scene)}
        </svg>
        <figcaption>${t('scene.plan')}</figcaption>
      </figure>
      <figure>
        <svg viewBox="-12 -31 72 35" role="img" aria-label="${t('scene.side')}: ${spoken(scene)}">
          ${arrowHead()}${side(scene)}
        </svg>
        <figcaption>${t('scene.side')}</figcaption>
      </figure>
      ${figures(scene)}
    </section>`;
  }
}

function spoken(scene: Scene): string {
  const { water } = scene;
  return t('scene.about', {
    deployment: deployment(scene),
    az: num(scene.azimuth, 1),
    el: num(scene.elevation, 1),
    v1: num(scene.valves[0] * 100),
    v2: num(scene.valves[1] * 100),
    water: water ? t('scene.jet', { d: num(Math.hypot(...water.at)) }) : t('scene.dry'),
    fires: scene.fires.filter((fire) => fire.heat > 0).length,
  });
}

function deployment(scene: Scene): string {
  if (scene.deployed) return t('scene.deployed');
  return scene.deployment > 0.01 ? t('scene.between') : t('scene.stowed');
}

function arrowHead(): Svg {
  return svg`<defs><marker id="head" viewBox="0 0 4 4" refX="2" refY="2" markerWidth="3" markerHeight="3" orient="auto">
    <path class="head" d="M0 0 L4 2 L0 4 z"></path></marker></defs>`;
}

/** Metres forward and left to the plan, where forward is up. */
const onPlan = (forward: number, left: number): [number, number] => [-left, -forward];
const radians = (degrees: number): number => (degrees * Math.PI) / 180;
const polar = (azimuth: number, distance: number): [number, number] =>
  onPlan(Math.cos(radians(azimuth)) * distance, Math.sin(radians(azimuth)) * distance);
const point = ([x, y]: readonly [number, number]): string => `${x.toFixed(2)} ${y.toFixed(2)}`;

function plan(scene: Scene): Svg {
  const tip = polar(scene.azimuth, BARREL_M * scene.deployment);
  const turn = scene.motion[1];
  const [wx, wy] = onPlan(...scene.wind);
  return svg`
    ${RINGS_M.map(
      (ring) =>
        svg`<circle class="ring" r=${ring}></circle><text x="1" y=${-ring + 3.4}>${ring} ${t('scene.m')}</text>`,
    )}
    ${scene.limits ? limitsOnPlan(scene.limits) : nothing}
    ${scene.fires.map((fire) => {
      const [x, y] = onPlan(...fire.at);
      const size = Math.max(fire.size_m / 2, 1);
      return fire.heat > 0
        ? svg`<circle class="fire" cx=${x} cy=${y} r=${size} opacity=${0.35 + 0.65 * fire.heat}></circle>`
        : svg`<circle class="out" cx=${x} cy=${y} r=${size}></circle>`;
    })}
    ${scene.water ? jetOnPlan(scene.water) : nothing}
    ${turn !== 0 ? svg`<path class="move" d=${arc(scene.azimuth, scene.azimuth + 25 * turn, BARREL_M + 3)}></path>` : nothing}
    <circle class="base" r="1.6"></circle>
    <line class="barrel ${scene.deployed ? '' : 'stowed'}" x2=${tip[0]} y2=${tip[1]}></line>
    ${wx !== 0 || wy !== 0 ? svg`<path class="move" d="M-40 18 l${wx} ${wy}"></path>` : nothing}
  `;
}

function arc(from: number, to: number, radius: number): string {
  const steps = Array.from({ length: 9 }, (_, step) => polar(from + ((to - from) * step) / 8, radius));
  return `M${steps.map(point).join(' L')}`;
}

function limitsOnPlan([right, left]: NonNullable<Scene['limits']>): Svg {
  return svg`${[right, left].map((limit) => svg`<path class="limit" d="M0 0 L${point(polar(limit, REACH_M))}"></path>`)}`;
}

function jetOnPlan(water: NonNullable<Scene['water']>): Svg {
  const [x, y] = onPlan(...water.at);
  const degrees = -90 - (water.heading * 180) / Math.PI;
  return svg`<path class="jet" d="M0 0 L${point([x, y])}"></path>
    <ellipse class="print" rx=${water.along_m} ry=${water.across_m}
      transform="translate(${point([x, y])}) rotate(${degrees.toFixed(1)})"></ellipse>`;
}

function side(scene: Scene): Svg {
  const height = scene.height_m;
  const angle = -90 + (scene.elevation + 90) * scene.deployment;
  const at = (degrees: number, length: number): [number, number] => [
    Math.cos(radians(degrees)) * length,
    -height - Math.sin(radians(degrees)) * length,
  ];
  const tip = at(angle, scene.deployed ? BARREL_M : Math.min(BARREL_M, height + 2));
  const [lift, , , fold] = scene.motion;
  const moves = lift !== 0 ? lift : fold;
  const shown = scene.fires.filter((fire) => Math.hypot(...fire.at) <= 60);
  return svg`
    <line class="ground" x1="-12" x2="60" y1="0" y2="0"></line>
    ${[20, 40].map((x) => svg`<line class="axis" x1=${x} x2=${x} y1="0" y2=${-SIDE_TOP_M}></line><text x=${x + 0.6} y="3.2">${x} ${t('scene.m')}</text>`)}
    ${scene.limits?.slice(2).map((limit) => svg`<path class="limit" d="M0 ${-height} L${point(at(limit, 14))}"></path>`)}
    ${shown.map((fire) => {
      const [x, size] = [Math.hypot(...fire.at), Math.max(fire.size_m, 2)];
      const flame = `M${x - size / 2} 0 Q${x - size / 3} ${-size * fire.heat} ${x} ${-size * 1.6 * fire.heat} Q${x + size / 3} ${-size * fire.heat} ${x + size / 2} 0 z`;
      return fire.heat > 0
        ? svg`<path class="fire" d=${flame}></path>`
        : svg`<circle class="out" cx=${x} cy="-1" r="1"></circle>`;
    })}
    ${scene.water ? svg`<path class="jet" d="M${scene.water.arc.map(([x, y]) => point([x, -y])).join(' L')}"></path>` : nothing}
    <rect class="base" x="-0.5" width="1" y=${-height} height=${height}></rect>
    <line class="barrel ${scene.deployed ? '' : 'stowed'}" x1="0" y1=${-height} x2=${tip[0]} y2=${tip[1]}></line>
    ${
      moves !== 0
        ? svg`<path class="move" d="M${[0, 8, 16].map((more) => point(at(angle + more * moves, BARREL_M + 2.5))).join(' L')}"></path>`
        : nothing
    }
  `;
}

function figures(scene: Scene): TemplateResult {
  const [lift, turn, spray] = scene.motion;
  const moving = (motion: number): string => (motion !== 0 ? `, ${t('scene.moves')}` : '');
  const open = scene.valves.map((valve, index) => `${index + 1}: ${t('scene.open', { n: num(valve * 100) })}`);
  const burning = scene.fires.filter((fire) => fire.heat > 0).length;
  const { limits } = scene;
  return html`<dl>
    <dt>${t('scene.title')}</dt>
    <dd>${deployment(scene)}${moving(scene.motion[3])}</dd>
    <dt>${t('scene.azimuth')}</dt>
    <dd>${num(scene.azimuth, 1)}°${limits ? ` (${num(limits[0])}…${num(limits[1])}°)` : ''}${moving(turn)}</dd>
    <dt>${t('scene.elevation')}</dt>
    <dd>${num(scene.elevation, 1)}°${limits ? ` (${num(limits[2])}…${num(limits[3])}°)` : ''}${moving(lift)}</dd>
    <dt>${t('scene.nozzle')}</dt>
    <dd>${num(scene.nozzle_mm)} ${t('scene.mm')}${moving(spray)}</dd>
    <dt>${t('scene.valves')}</dt>
    <dd>${open.join('; ')}</dd>
    <dt>${t('scene.water')}</dt>
    <dd>${t('scene.flow', { q: num(scene.flow_lps, 1), p: num(scene.pressure_atm, 1) })}</dd>
    <dt>${t('scene.fires')}</dt>
    <dd>${t('scene.burns', { n: burning, all: scene.fires.length })}</dd>
  </dl>`;
}
