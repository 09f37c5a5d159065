// The contents of the plan, layer by layer, as SVG. Pure: a camera and objects in, templates out.
import { nothing, type SVGTemplateResult, svg } from 'lit';
import type { FirePlace } from '../../hub/api';
import { num } from '../../i18n';
import type { Spot } from '../found';
import {
  ARCMIN,
  bearingOf,
  compass,
  type Place,
  placeAt,
  ringPath,
  roundStep,
  type Sector,
  toScreen,
  toSite,
  type View,
} from '../geometry';
import type { PlanMonitor, PlanScene, PlanSite } from './model';
import { type Box, box, NAME_PX, nameBox, namePlaces, nameWidth } from './names';
import { rangePlaces } from './range-names';

export interface Camera {
  view: View;
  width: number;
  height: number;
  mini: boolean;
  /** Number of pixels at the upper edge that the page's buttons cover. */
  above: number;
}

export interface Drop {
  at: Place;
  litres: number;
  foam: boolean;
  born_ms: number;
}

const RING_PX = 30;
/** Narrower than this the buttons of a page take the whole upper edge. */
const NARROW_PX = 430;
/** The page's own buttons leave no space for text beside the compass. */
const TIGHT_PX = 620;
/** Width of the wind beside the compass, px. */
const WIND_PX = 140;
const RING_MINI_PX = 19;
const CLEAR_PX = RING_PX + 5;
const CLEAR_MINI_PX = 8;
export const DROP_LIFE_MS = 2400;

const px = (camera: Camera, place: Place): Place => toScreen(camera.view, camera.width, camera.height, place);
/** Where the barrel points to; straight ahead while unknown. */
const barrelOf = (monitor: PlanMonitor): number => bearingOf(monitor.heading, monitor.horizontal_arcmin ?? 0);
const f = (value: number): string => value.toFixed(1);

export function grid(camera: Camera): SVGTemplateResult {
  const step = roundStep(90 / camera.view.scale);
  const [west, north] = toSite(camera.view, camera.width, camera.height, [0, 0]);
  const [east, south] = toSite(camera.view, camera.width, camera.height, [camera.width, camera.height]);
  let path = '';
  for (let at = Math.ceil(west / step) * step; at <= east; at += step) {
    path += `M${f(px(camera, [at, 0])[0])} 0V${f(camera.height)}`;
  }
  for (let at = Math.ceil(south / step) * step; at <= north; at += step) {
    path += `M0 ${f(px(camera, [0, at])[1])}H${f(camera.width)}`;
  }
  return svg`<path class="grid" d=${path}></path>`;
}

export function structures(camera: Camera, site: PlanSite): SVGTemplateResult {
  const { scale } = camera.view;
  return svg`${site.walls.map((wall) => {
    const [a, b] = [px(camera, wall.from), px(camera, wall.to)];
    return svg`<line class="wall" x1=${a[0]} y1=${a[1]} x2=${b[0]} y2=${b[1]}></line>`;
  })}${site.tanks.map((tank) => {
    const [x, y] = px(camera, tank.at);
    const radius = (tank.diameter / 2) * scale;
    const inner = radius * 0.86;
    const spoke = inner * Math.SQRT1_2;
    return svg`<g transform="translate(${f(x)} ${f(y)})">
      <circle class="tank" r=${f(radius)}></circle>
      <circle class="roof" r=${f(inner)}></circle>
      <path class="roof" d="M${f(-spoke)} ${f(-spoke)}L${f(spoke)} ${f(spoke)}M${f(-spoke)} ${f(spoke)}L${f(spoke)} ${f(-spoke)}"></path>
    </g>`;
  })}`;
}

/** Names of the tanks, above whatever is drawn on them: of one that burns below the flame. */
export function tankNames(
  camera: Camera,
  site: PlanSite,
  burning: readonly { at: Place; size: number }[],
): SVGTemplateResult {
  return svg`${site.tanks.map((tank) => {
    if ((tank.diameter / 2) * camera.view.scale <= 17) return nothing;
    const [x, y] = px(camera, tank.at);
    const feet = burning
      .filter(({ at }) => Math.hypot(at[0] - tank.at[0], at[1] - tank.at[1]) <= tank.diameter / 2)
      .map(({ at, size }) => px(camera, at)[1] + FLAME_FOOT_PX * flameSize(fireRadius(camera, size)) + NAME_PX / 2);
    return svg`<text class="tank-name" dy="0.35em" x=${f(x)} y=${f(Math.max(y, ...feet))}>${tank.name}</text>`;
  })}`;
}

/** An outline of a flame, about 20 high, standing on the origin. */
const FLAME = 'M0 9C-5 9-8 5.6-8 1.4-8-2.4-5-4.6-4-8c2 1 3 2.4 3.4 4C1-6 1.6-9 .6-12 5-9.6 8-4 8 .8 8 5.6 5 9 0 9Z';

/** How far it goes below the origin. */
const FLAME_FOOT_PX = 9;

const fireRadius = (camera: Camera, size: number): number => Math.max((size / 2) * camera.view.scale, 9);
const flameSize = (radius: number): number => Math.min(Math.max(radius / 15, 0.75), 2);

export function fires(camera: Camera, scene: PlanScene): SVGTemplateResult {
  return svg`${scene.fires
    .filter(({ burns }) => burns)
    .map((fire) => {
      const [x, y] = px(camera, fire.at);
      const radius = fireRadius(camera, fire.size);
      const size = flameSize(radius);
      return svg`<g transform="translate(${f(x)} ${f(y)})">
        <circle class="fire-area" r=${f(radius)}></circle>
        <path class="flame" transform="scale(${f(size)})" d=${FLAME}></path>
      </g>`;
    })}`;
}

/** Fires found by detectors, at their computed places: dashed, because their distance is not measured. */
export function found(camera: Camera, spots: readonly Spot[]): SVGTemplateResult {
  return svg`${spots.map((spot) => {
    const [x, y] = px(camera, spot.at);
    return svg`<g class="found" data-seen-by=${spot.seen_by.join(' ')} transform="translate(${f(x)} ${f(y)})">
      <circle class="fire-area" stroke-dasharray=${spot.crossed ? nothing : '4 3'} r=${f(Math.max(2 * camera.view.scale, 13))}></circle>
      <path class="flame" d=${FLAME}></path>
    </g>`;
  })}`;
}

export function drops(camera: Camera, list: readonly Drop[], now_ms: number): SVGTemplateResult {
  return svg`${list.map((drop) => {
    const age = (now_ms - drop.born_ms) / DROP_LIFE_MS;
    if (age >= 1) return nothing;
    const [x, y] = px(camera, drop.at);
    const radius = Math.max((0.5 + Math.sqrt(drop.litres) * 0.55) * camera.view.scale, 3);
    return svg`<circle class=${drop.foam ? 'drop foam' : 'drop'} cx=${f(x)} cy=${f(y)}
      r=${f(radius * (0.7 + 0.5 * age))} opacity=${(0.5 * (1 - age)).toFixed(2)}></circle>`;
  })}`;
}

export function jets(camera: Camera, monitors: readonly PlanMonitor[]): SVGTemplateResult {
  return svg`${monitors
    .filter((monitor) => monitor.water && monitor.lands)
    .map((monitor) => {
      const [x, y] = px(camera, monitor.at);
      const [u, v] = px(camera, monitor.lands!);
      const long = Math.hypot(u - x, v - y);
      if (long < 2) return nothing;
      const [a, b] = [(v - y) / long, -(u - x) / long];
      const wide = Math.min(Math.max(long * 0.05, 3), 16);
      const d =
        `M${f(x + a)} ${f(y + b)}L${f(u + a * wide)} ${f(v + b * wide)}` +
        `A${f(wide)} ${f(wide)} 0 0 1 ${f(u - a * wide)} ${f(v - b * wide)}L${f(x - a)} ${f(y - b)}Z`;
      const kind = monitor.foam ? 'jet foam' : 'jet';
      return svg`<path class="${kind} ${monitor.stale ? 'stale' : ''}" d=${d}></path>
        <circle class="landing ${monitor.stale ? 'stale' : ''}" cx=${f(u)} cy=${f(v)} r="4"></circle>`;
    })}`;
}

/** Where the water of a monitor is expected to land: from the nearest to the farthest; the middle and the outermost. */
export function landingArea(camera: Camera, monitor: PlanMonitor): SVGTemplateResult | typeof nothing {
  const { landing } = monitor;
  if (!landing || typeof landing === 'string') return nothing;
  const [x, y] = px(camera, monitor.at);
  const { scale } = camera.view;
  const { bearing, width, near_m, far_m } = landing;
  const line = (range: number): string => ringPath(bearing, width, range * scale, range * scale).split('L')[0]!;
  return svg`<g class="landing-area ${monitor.stale ? 'stale' : ''}" transform="translate(${f(x)} ${f(y)})">
    <path class="area" d=${ringPath(bearing, width, near_m * scale, far_m * scale)}></path>
    <path class="middle" d=${line(landing.middle_m)}></path>
    <path class="outermost" d=${line(landing.greatest_m)}></path>
  </g>`;
}

/** Reach, rings of distance and the part that Horizontal cannot go to, of the chosen monitor. */
export function ranges(camera: Camera, monitor: PlanMonitor): SVGTemplateResult {
  const [x, y] = px(camera, monitor.at);
  const { scale } = camera.view;
  const { reach, far, rings } = ringsOf(monitor);
  return svg`<g>
    <g transform="translate(${f(x)} ${f(y)})">
      ${rings.map((range) => svg`<circle class="ring" r=${f(range * scale)}></circle>`)}
      ${reach ? svg`<circle class="reach" r=${f(reach * scale)}></circle>` : nothing}
      ${forbidden(monitor, far * scale)}
    </g>
  </g>`;
}

/** The sectors that no water of the chosen monitor goes into, with their names. */
export function keepOuts(camera: Camera, site: PlanSite, monitor: PlanMonitor): SVGTemplateResult {
  const [x, y] = px(camera, monitor.at);
  const far = monitor.reach_m || 40;
  const own = site.keep_outs.filter((it) => it.monitor === null || it.monitor === monitor.id);
  return svg`${own.map(({ name, bearings: [from, to] }) => {
    const width = to - from >= 360 ? 360 : (to - from + 720) % 360;
    const middle = from + width / 2;
    const [u, v] = px(camera, placeAt(monitor.at, middle, far * 0.7));
    return svg`<g class="keep-out" data-name=${name}>
      <path transform="translate(${f(x)} ${f(y)})" d=${ringPath(middle, Math.max(width, 0.5), 0, far * camera.view.scale)}></path>
      <text x=${f(u)} y=${f(v)} dy="0.35em">${name}</text>
    </g>`;
  })}`;
}

/** Places where bearings of detectors cross, with the ellipse that holds a fire with 95 %. */
export function located(camera: Camera, places: readonly FirePlace[]): SVGTemplateResult {
  return svg`${places.map(({ at, standing, zone, major_m, minor_m, direction_deg }) => {
    const [x, y] = px(camera, at);
    const radius = (metres: number): string => f(Math.max(metres * camera.view.scale, 4));
    return svg`<g class="located ${standing}" data-zone=${zone} transform="translate(${f(x)} ${f(y)})">
      <ellipse rx=${radius(minor_m)} ry=${radius(major_m)} transform="rotate(${f(direction_deg)})"></ellipse>
      ${standing === 'sure' ? svg`<path class="flame" d=${FLAME}></path>` : svg`<text dy="0.35em">${standing === 'ghost' ? '×' : '?'}</text>`}
    </g>`;
  })}`;
}

/** The distances of the rings, where each can be read; one that cannot is not written. */
export function rangeNames(
  camera: Camera,
  monitor: PlanMonitor,
  length: (metres: number) => string,
  reachText: (distance: string) => string,
  taken: readonly Box[],
): SVGTemplateResult {
  const { reach, rings } = ringsOf(monitor);
  const wanted = [
    ...(reach ? [{ range: reach, text: reachText(length(reach)), strong: true }] : []),
    ...rings.map((range) => ({ range, text: length(range), strong: false })),
  ];
  const on = (range: number, turn: number) => px(camera, placeAt(monitor.at, barrelOf(monitor) + turn, range));
  return svg`${rangePlaces(wanted, on, [camera.width, camera.height], taken).map(
    ({ at, text, strong }) =>
      svg`<text class="ring-name ${strong ? 'strong' : ''}" x=${f(at[0])} y=${f(at[1])} dy="0.35em">${text}</text>`,
  )}`;
}

/** What no text may cover: tanks, monitors and their names, and the controls at the edges. */
export function taken(
  camera: Camera,
  site: PlanSite | null,
  monitors: readonly PlanMonitor[],
  names: ReadonlyMap<string, Place>,
): Box[] {
  const tanks = (site?.tanks ?? []).map(({ at, diameter }) =>
    box(px(camera, at), diameter * camera.view.scale, diameter * camera.view.scale),
  );
  const marks = monitors.flatMap((monitor) => {
    const at = px(camera, monitor.at);
    return [box(at, 2 * CLEAR_PX, 2 * CLEAR_PX), nameBox({ ...monitor, at, barrel: 0 }, names.get(monitor.id)!)];
  });
  return [...edges(camera), ...tanks, ...marks];
}

/** The page's buttons, compass with the wind, buttons of the plan, scale. */
function edges({ width, height, above, view }: Camera): Box[] {
  const [, compassY] = compassAt({ width, above });
  return [
    { x: 0, y: 0, wide: width, high: above },
    { x: width - 34 - WIND_PX, y: compassY - 22, wide: 34 + WIND_PX, high: 44 },
    { x: width - 66, y: height - 166, wide: 66, high: 166 },
    { x: 8, y: height - 46, wide: roundStep(140 / view.scale) * view.scale + 24, high: 46 },
  ];
}

function ringsOf(monitor: PlanMonitor): { reach: number; far: number; rings: number[] } {
  const reach = monitor.reach_m ?? 0;
  const far = reach || 40;
  const step = Math.max(roundStep(far / 3), 5);
  const rings = [];
  for (let range = step; range < far - step * 0.2; range += step) rings.push(range);
  return { reach, far, rings };
}

function forbidden(monitor: PlanMonitor, radius: number): SVGTemplateResult | typeof nothing {
  const limits = monitor.limits?.Horizontal;
  if (!limits) return nothing;
  const open = (limits.max - limits.min) / ARCMIN;
  if (open >= 359) return nothing;
  const middle = bearingOf(monitor.heading, (limits.max + limits.min) / 2) + 180;
  return svg`<path class="forbidden" d=${ringPath(middle, 360 - open, 0, radius)}></path>`;
}

/** Direction of the barrel over the site, its target, and what the detector has seen. */
export function aims(camera: Camera, monitor: PlanMonitor): SVGTemplateResult | typeof nothing {
  if (monitor.horizontal_arcmin === null) return nothing;
  const bearing = bearingOf(monitor.heading, monitor.horizontal_arcmin);
  const [x, y] = px(camera, monitor.at);
  const far = (monitor.reach_m || 40) * camera.view.scale;
  const goal = monitor.target_arcmin;
  return svg`<g transform="translate(${f(x)} ${f(y)})">
    <line class="aim ${monitor.stale ? 'stale' : ''}" y1="-24" y2=${f(-far)}
      transform="rotate(${f(bearing)})"></line>
    ${
      goal === null || goal === undefined
        ? nothing
        : svg`<g transform="rotate(${f(bearingOf(monitor.heading, goal))})">
            <line class="goal" y1="-24" y2=${f(-far)}></line>
            <path class="goal-mark" d="M0 ${f(-far)}l-6-11h12Z"></path></g>`
    }
  </g>`;
}

export function hotbeds(camera: Camera, monitor: PlanMonitor): SVGTemplateResult {
  const [x, y] = px(camera, monitor.at);
  return svg`${monitor.hotbeds.map((hotbed, index) => {
    const range = hotbed.distance_m * camera.view.scale;
    const width = Math.max(hotbed.width, 2);
    const [u, v] = px(camera, placeAt(monitor.at, hotbed.bearing, hotbed.distance_m));
    return svg`<path class="hotbed-way" transform="translate(${f(x)} ${f(y)})"
        d=${ringPath(hotbed.bearing, width, 0, range)}></path>
      <g class="hotbed" transform="translate(${f(u)} ${f(v - 26)})">
        <line y1="10" y2="26"></line><path d="M0-11 11 0 0 11-11 0Z"></path><text dy="0.35em">${index + 1}</text></g>`;
  })}`;
}

/** Where the name of each monitor is, from its middle. */
export function namesOf(camera: Camera, monitors: readonly PlanMonitor[]): Map<string, Place> {
  return namePlaces(
    monitors.map((monitor) => ({ id: monitor.id, at: px(camera, monitor.at), barrel: barrelOf(monitor) })),
    [camera.width, camera.height],
    camera.mini ? CLEAR_MINI_PX : CLEAR_PX,
    camera.mini ? [] : edges(camera),
  );
}

/** All monitors, the chosen one above the others. */
export function monitorMarks(
  camera: Camera,
  monitors: readonly PlanMonitor[],
  selected: string,
  names: ReadonlyMap<string, Place>,
): SVGTemplateResult {
  const ordered = [...monitors].sort((a, b) => Number(a.id === selected) - Number(b.id === selected));
  return svg`${ordered.map((monitor) => monitorMark(camera, monitor, monitor.id === selected, names.get(monitor.id)!))}`;
}

function monitorMark(camera: Camera, monitor: PlanMonitor, selected: boolean, name: Place): SVGTemplateResult {
  const [x, y] = px(camera, monitor.at);
  const bearing = barrelOf(monitor);
  const known = monitor.horizontal_arcmin !== null;
  const ring = camera.mini ? RING_MINI_PX : RING_PX;
  const classes = [
    'monitor',
    monitor.stale ? 'stale' : '',
    selected ? 'selected' : '',
    monitor.concern,
    monitor.wrapped ? 'wrapped' : '',
  ].join(' ');
  const size = camera.mini ? 0.72 : 1;
  return svg`<g class=${classes} data-id=${monitor.id} transform="translate(${f(x)} ${f(y)})">
    <circle class="hit" r="24"></circle>
    ${selected && !camera.mini ? svg`<circle class="halo" r="21"></circle>` : nothing}
    ${camera.mini ? nothing : travel(monitor, ring)}
    <g transform="rotate(${f(bearing)}) scale(${size})">
      ${known ? svg`<path class="barrel" d=${monitor.wrapped ? SHORT_BARREL : BARREL}></path>` : nothing}
    </g>
    <circle class="body" r=${f(11 * size)}></circle>
    ${concernMark(monitor, size)}
    ${nameOf(camera, monitor, name)}
  </g>`;
}

const BARREL = 'M-3.5 0V-20L-4.5-20V-25H4.5V-20L3.5-20V0Z';
const SHORT_BARREL = 'M-3.5 0V-15H3.5V0Z';

function concernMark(monitor: PlanMonitor, size: number): SVGTemplateResult {
  if (monitor.concern === 'alarm' || monitor.concern === 'warning') {
    return svg`<path class="sign" transform="scale(${size})" d="M0-5V1.4M0 4.2v.6"></path>`;
  }
  return svg`<circle class="pin" r=${f(3.2 * size)}></circle>`;
}

/** The arc that Horizontal may travel, with its ends; a full turn has a stop at the back instead. */
function travel(monitor: PlanMonitor, ring: number): SVGTemplateResult | typeof nothing {
  const limits = monitor.limits?.Horizontal;
  if (!limits) return nothing;
  const open = (limits.max - limits.min) / ARCMIN;
  const [left, right] = [bearingOf(monitor.heading, limits.max), bearingOf(monitor.heading, limits.min)];
  const tick = (bearing: number): SVGTemplateResult =>
    svg`<line class="stop" y1=${-ring - 4} y2=${-ring + 4} transform="rotate(${f(bearing)})"></line>`;
  if (open >= 359) {
    return svg`<circle class="travel" r=${ring}></circle>${tick(left)}`;
  }
  const middle = bearingOf(monitor.heading, (limits.max + limits.min) / 2);
  const path = ringPath(middle, open, 0.02, ring).split('L')[0]!;
  return svg`<path class="travel" d=${path}></path>${tick(left)}${tick(right)}`;
}

function nameOf(camera: Camera, monitor: PlanMonitor, [x, y]: Place): SVGTemplateResult {
  if (camera.mini) {
    return svg`<text class="name" x=${f(x)} y=${f(y)} dy="0.35em">${monitor.id}</text>`;
  }
  const wide = nameWidth(monitor.id);
  return svg`<g transform="translate(${f(x)} ${f(y)})">
    <rect class="name-box" x=${f(-wide / 2)} y=${-NAME_PX / 2} width=${wide} height=${NAME_PX} rx="4"></rect>
    <text class="name" dy="0.35em">${monitor.id}</text></g>`;
}

export function sectorShape(
  camera: Camera,
  monitor: PlanMonitor,
  sector: Sector,
  kind: 'running' | 'drawn' | 'drawn bad',
): SVGTemplateResult {
  const [x, y] = px(camera, monitor.at);
  const { scale } = camera.view;
  const d = ringPath(
    sector.bearing,
    Math.max(sector.width, 0.4),
    sector.near_m * scale,
    Math.max(sector.far_m * scale, sector.near_m * scale + 1),
  );
  return svg`<path class="sector ${kind}" transform="translate(${f(x)} ${f(y)})" d=${d}></path>`;
}

/** A trajectory: places in their order. */
export function route(
  camera: Camera,
  points: readonly Place[],
  selected: number,
  name: (n: number) => string,
): SVGTemplateResult | typeof nothing {
  if (!points.length) return nothing;
  const path = points.map((at, n) => `${n ? 'L' : 'M'}${px(camera, at).map(f).join(' ')}`).join('');
  return svg`<path class="route" d=${path}></path>
    ${points.map((at, n) => {
      const [x, y] = px(camera, at);
      return svg`<g class="route-point ${n === selected ? 'selected' : ''}" data-point=${n}
        aria-label=${name(n + 1)} transform="translate(${f(x)} ${f(y)})">
        <circle class="hit" r="22"></circle><circle class="knob" r="12"></circle>
        <text dy="4.5">${n + 1}</text></g>`;
    })}`;
}

export function scaleBar(camera: Camera, length: (metres: number) => string): SVGTemplateResult {
  const metres = roundStep(140 / camera.view.scale);
  const long = metres * camera.view.scale;
  return svg`<g class="scale" transform="translate(16 ${f(camera.height - 18)})">
    <path d="M0-6V0H${f(long)}V-6M${f(long / 2)}-4V0"></path>
    <text x=${f(long / 2)} y="-10">${length(metres)}</text>
  </g>`;
}

/** Beside the page's buttons, and below what else it has on the picture. */
export function compassAt({ width, above }: Pick<Camera, 'width' | 'above'>): Place {
  return [width - 34, width < NARROW_PX ? 92 : Math.max(34, above - 26)];
}

export function compassMark(
  camera: Camera,
  north: string,
  scene: PlanScene | null,
  wind: (speed: string, short: boolean) => string,
  noWind: string,
): SVGTemplateResult {
  const speed = scene ? Math.hypot(...scene.wind) : 0;
  // The arrow points to where the wind blows.
  const toward = scene ? compass((Math.atan2(scene.wind[0], scene.wind[1]) * 180) / Math.PI) : 0;
  return svg`<g class="compass" transform="translate(${compassAt(camera).join(' ')})">
    <circle r="19"></circle>
    <path class="needle" d="M0-16 5-3H-5Z"></path><text y="9">${north}</text>
    ${
      !scene
        ? svg`<text class="wind-speed" x="-28" dy="0.35em">${camera.width < TIGHT_PX ? '' : noWind}</text>`
        : speed > 0.2
          ? svg`<g transform="translate(-46 0)"><g transform="rotate(${f(toward)})">
            <path class="wind" d="M0 12V-12M-5-6 0-12 5-6"></path></g>
            <text class="wind-speed" x="-16" dy="0.35em">${wind(num(speed, 1), camera.width < TIGHT_PX)}</text></g>`
          : nothing
    }
  </g>`;
}
