// The site in three dimensions: east is x, up is y, north is −z. Loaded only when it is looked at.
import {
  AmbientLight,
  Color,
  DirectionalLight,
  Fog,
  HemisphereLight,
  PerspectiveCamera,
  PointLight,
  Scene,
  SRGBColorSpace,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import type { Flight } from '../../hub/jets';
import { boundsOf, distanceTo, groundAt, type Place } from '../geometry';
import { flows, type PlanMonitor, type PlanScene, type PlanSite, placesOf } from '../plan/model';
import { sprayHalfAngle, sprayOf } from '../spray';
import { Area } from './area';
import { Barrels, directionOf, type Pose } from './barrels';
import { Label } from './labels';
import { Kind, type Palette, Particles } from './particles';
import { Ribbon } from './ribbon';
import { type Colours, Structures } from './structures';
import { type At, roughFlight, Track } from './track';

export type Preset = 'eye' | 'orbit' | 'top' | 'side';

export interface Shown {
  site: PlanSite | null;
  monitors: readonly PlanMonitor[];
  scene: PlanScene | null;
  selected: string;
}

const PARTICLES_MAX = 4000;
const MONITORS_MAX = 32;
const WATER_PER_S = 260;
const FLAMES_PER_S = 46;
const SMOKE_PER_S = 18;
const FIRES_MAX = 4;
const PIXEL_RATIO_MAX = 1.5;
/** Slower than this on average: fewer pixels and particles. */
const SLOW_FRAME_MS = 24;
const FRAMES_JUDGED = 45;
const SHARE_LEAST = 0.3;
const FLIGHT_S = 0.6;
const LABEL_PX = 27;
/** A tank that looks smaller than this has no name. */
const NAMED_PX = 58;
/** Part of the picture that the site and everything above the ground may fill. */
const FILLED = 0.9;
const ROOM_ABOVE_M = 10;
const AWAY_MAX_M = 250;
/** Slope of the view from which on the names are on the roofs. */
const STEEP = 1.6;
/** The point of view. */
const FROM: Record<Preset, Vector3> = {
  eye: new Vector3(-0.55, 0.48, 0.7),
  orbit: new Vector3(-0.55, 0.48, 0.7),
  side: new Vector3(0, 0.15, 1),
  top: new Vector3(0, 1, 0.001),
};

export class World {
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(46, 1, 0.2, 1500);
  private readonly controls: OrbitControls;
  private readonly particles: Particles;
  private readonly barrels: Barrels;
  private readonly labels = new Map<string, Label>();
  private readonly glows: PointLight[] = [];
  private readonly ribbons = new Map<string, Ribbon>();
  private readonly area: Area;
  private structures: Structures | null = null;
  private shown: Shown = { site: null, monitors: [], scene: null, selected: '' };
  private builtFor: PlanSite | null = null;
  private tallest = 0;
  private owed = new Map<string, number>();
  private preset: Preset = 'orbit';
  private flight: { from: Vector3; look: Vector3; to: Vector3; at: Vector3; part: number } | null = null;
  private frames: number[] = [];
  private size: Place = [0, 0];

  constructor(
    canvas: HTMLCanvasElement,
    private readonly colours: Colours,
    private readonly palette: Palette,
    private readonly still: boolean,
    private readonly dark: boolean,
  ) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: 'low-power' });
    this.renderer.outputColorSpace = SRGBColorSpace;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, PIXEL_RATIO_MAX));
    this.scene.background = new Color(colours.sky);
    this.scene.fog = new Fog(colours.sky, 110, 420);
    this.lights(dark);
    this.particles = new Particles(PARTICLES_MAX, palette);
    this.barrels = new Barrels(MONITORS_MAX, colours);
    this.area = new Area(colours.water);
    this.scene.add(this.particles.points, this.barrels.group, this.area.mesh);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.maxPolarAngle = Math.PI / 2 - 0.03;
    this.controls.minDistance = 4;
    this.controls.maxDistance = 260;
    this.controls.enableDamping = !still;
    this.controls.dampingFactor = 0.12;
    this.controls.addEventListener('start', this.grabbed);
    this.camera.position.set(-60, 45, 60);
  }

  /** Draw calls, number of particles and their share in the last frame. */
  get figures(): { calls: number; particles: number; share: number } {
    const { calls } = this.renderer.info.render;
    return { calls, particles: this.particles.count, share: this.particles.share };
  }

  /** Monitors whose water is drawn. */
  get waters(): string[] {
    return [...this.ribbons].flatMap(([id, { mesh }]) => (mesh.visible ? [id] : []));
  }

  resize(width: number, height: number): void {
    this.size = [width, height];
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
    this.particles.height = height * this.renderer.getPixelRatio();
  }

  show(shown: Shown): void {
    const before = this.shown;
    this.shown = shown;
    if (shown.site && JSON.stringify(shown.site) !== JSON.stringify(this.builtFor)) this.build(shown.site);
    const backwards = shown.scene && before.scene && shown.scene.t_s < before.scene.t_s - 1;
    if (backwards) this.particles.clear();
    if (shown.selected !== before.selected && this.preset !== 'orbit' && this.preset !== 'top') {
      this.look(this.preset);
    }
  }

  look(preset: Preset, atOnce = this.still): void {
    this.preset = preset;
    const [to, at] = this.viewpoint(preset);
    if (atOnce) {
      this.camera.position.copy(to);
      this.controls.target.copy(at);
      this.controls.update();
      return;
    }
    this.flight = {
      from: this.camera.position.clone(),
      look: this.controls.target.clone(),
      to,
      at,
      part: 0,
    };
  }

  /** By keyboard: degrees sideways and up, a factor of the distance. */
  turn(sideways: number, up: number, nearer: number): void {
    this.grabbed();
    const { target } = this.controls;
    const off = this.camera.position.clone().sub(target);
    const flat = Math.hypot(off.x, off.z);
    const long = Math.min(Math.max(off.length() * nearer, 4), 260);
    const angle = Math.atan2(off.x, off.z) + (sideways * Math.PI) / 180;
    const rise = Math.min(Math.max(Math.atan2(off.y, flat) + (up * Math.PI) / 180, 0.04), 1.55);
    this.camera.position.set(
      target.x + Math.sin(angle) * Math.cos(rise) * long,
      target.y + Math.sin(rise) * long,
      target.z + Math.cos(angle) * Math.cos(rise) * long,
    );
    this.controls.update();
  }

  frame(seconds: number): void {
    this.barrels.step(this.shown.monitors, this.shown.selected, seconds, this.preset !== 'eye');
    this.water(seconds);
    this.landing();
    this.fire(seconds);
    const wind = this.shown.scene?.wind ?? [0, 0];
    this.particles.step(seconds, wind, this.floorAt, (drop) => this.splash(drop));
    this.named();
    this.fly(seconds);
    this.controls.update();
    this.renderer.render(this.scene, this.camera);
    this.judge(seconds * 1000);
  }

  dispose(): void {
    this.controls.dispose();
    this.particles.dispose();
    this.barrels.dispose();
    this.area.dispose();
    this.structures?.dispose();
    for (const label of this.labels.values()) label.dispose();
    for (const glow of this.glows) glow.dispose();
    for (const ribbon of this.ribbons.values()) ribbon.dispose();
    this.scene.clear();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }

  private readonly grabbed = (): void => {
    this.flight = null;
    if (this.preset === 'eye') this.preset = 'orbit';
  };

  private lights(dark: boolean): void {
    const sun = new DirectionalLight('#fff3df', dark ? 0.5 : 1.7);
    sun.position.set(-40, 70, 30);
    const sky = new HemisphereLight(dark ? '#5b7288' : '#eef4fa', dark ? '#1b2127' : '#98a09f', dark ? 1.1 : 1.6);
    this.scene.add(sun, sky, new AmbientLight('#ffffff', dark ? 0.15 : 0.25));
    for (let index = 0; index < FIRES_MAX; index++) {
      const glow = new PointLight('#ff7a2f', 0, 60, 1.4);
      this.glows.push(glow);
      this.scene.add(glow);
    }
  }

  private build(site: PlanSite): void {
    const first = this.builtFor === null;
    this.builtFor = site;
    this.tallest = Math.max(0, ...site.tanks.map(({ height }) => height));
    if (this.structures) {
      this.scene.remove(this.structures.group);
      this.structures.dispose();
    }
    this.structures = new Structures(site, boundsOf(placesOf(site, null)), this.colours);
    this.scene.add(this.structures.group);
    this.particles.clear();
    this.look(this.preset, first || this.still);
  }

  private viewpoint(preset: Preset): [Vector3, Vector3] {
    const pose = this.chosen();
    if (preset === 'eye' && pose) {
      const ahead = directionOf({ bearing: pose.bearing, elevation: 0 });
      const to = pose.foot
        .clone()
        .addScaledVector(ahead, -7)
        .add(new Vector3(0, 3.4, 0));
      return [to, pose.foot.clone().addScaledVector(ahead, 26)];
    }
    const box = boundsOf(placesOf(this.shown.site, this.shown.scene));
    const middle = new Vector3((box.west + box.east) / 2, 2, -(box.south + box.north) / 2);
    const from = FROM[preset].clone().normalize();
    return [middle.clone().addScaledVector(from, this.distance(middle, from)), middle];
  }

  /** Distance at which everything is in the picture. */
  private distance(middle: Vector3, from: Vector3): number {
    const across = new Vector3(0, 1, 0).cross(from).normalize();
    const up = from.clone().cross(across);
    const high = Math.tan((this.camera.fov * Math.PI) / 360) * FILLED;
    const wide = high * this.camera.aspect;
    let most = 20;
    for (const [[east, north], radius] of placesOf(this.shown.site, this.shown.scene)) {
      for (const [x, y, z] of [
        [-1, 0, 1],
        [1, 0, 1],
        [-1, 0, -1],
        [1, 0, -1],
        [0, ROOM_ABOVE_M, 0],
      ] as const) {
        const at = new Vector3(east + x * radius, y, -north + z * radius).sub(middle);
        const near = at.dot(from);
        most = Math.max(most, near + Math.abs(at.dot(across)) / wide, near + Math.abs(at.dot(up)) / high);
      }
    }
    return Math.min(most, AWAY_MAX_M);
  }

  private chosen(): Pose | undefined {
    const { poses } = this.barrels;
    if (!poses.size) this.barrels.step(this.shown.monitors, this.shown.selected, 0);
    return poses.get(this.shown.selected) ?? poses.values().next().value;
  }

  private fly(seconds: number): void {
    const { flight } = this;
    if (flight) {
      flight.part = Math.min(flight.part + seconds / FLIGHT_S, 1);
      const eased = flight.part * flight.part * (3 - 2 * flight.part);
      this.camera.position.lerpVectors(flight.from, flight.to, eased);
      this.controls.target.lerpVectors(flight.look, flight.at, eased);
      if (flight.part === 1) this.flight = null;
    } else if (this.preset === 'eye') {
      const [to, at] = this.viewpoint('eye');
      this.camera.position.copy(to);
      this.controls.target.copy(at);
    }
  }

  /** Whole particles for a rate; the fraction is carried over to the next frame. */
  private due(key: string, per_s: number, seconds: number): number {
    const sum = (this.owed.get(key) ?? 0) + per_s * this.particles.share * seconds;
    this.owed.set(key, sum % 1);
    return Math.floor(sum);
  }

  private water(seconds: number): void {
    for (const monitor of this.shown.monitors) {
      const pose = this.barrels.poses.get(monitor.id);
      const runs = pose && !monitor.stale && flows(monitor, this.shown.scene);
      const flight = runs ? (monitor.flight ?? this.rough(monitor, pose)) : null;
      const track = pose && flight ? this.track(monitor, pose, flight) : null;
      this.ribbon(monitor, track, pose?.bearing ?? 0);
      // Water whose end is not known has only a beginning.
      if (track && (monitor.flight || monitor.lands)) this.pour(monitor, track, seconds);
    }
  }

  /** Of the chosen monitor, as on the plan. */
  private landing(): void {
    const { monitors, selected } = this.shown;
    const chosen = monitors.find(({ id }) => id === selected) ?? (monitors.length === 1 ? monitors[0] : undefined);
    const area = chosen?.landing;
    this.area.set(chosen?.at ?? [0, 0], area && typeof area !== 'string' && !chosen?.stale ? area : null);
  }

  /** What is known of a jet that the hub cannot compute; nothing without a direction. */
  private rough({ at, height, lands, horizontal_arcmin, vertical_arcmin }: PlanMonitor, pose: Pose): Flight | null {
    if (horizontal_arcmin === null || vertical_arcmin === null) return null;
    const floor = lands ? groundAt(lands, this.shown.site?.tanks ?? []) : 0;
    const end = lands ? { way_m: Math.max(distanceTo(at, lands), 1), rise_m: floor - height } : null;
    return roughFlight(pose.elevation, end);
  }

  private track(monitor: PlanMonitor, pose: Pose, flight: Flight): Track {
    return new Track({
      flight,
      nozzle: { at: monitor.at, height: monitor.height },
      bearing: pose.bearing,
      mouth: pose.mouth.toArray() as At,
      lands: monitor.lands ?? null,
      floor: monitor.lands ? groundAt(monitor.lands, this.shown.site?.tanks ?? []) : 0,
      until_m: monitor.strikes && !monitor.strikes.on_top ? monitor.strikes.way_m : null,
    });
  }

  private pour(monitor: PlanMonitor, track: Track, seconds: number): void {
    const nozzle = monitor.nozzle_mm ?? 60;
    const wide = sprayOf(nozzle);
    const spread = Math.tan((sprayHalfAngle(nozzle) * Math.PI) / 180) * (wide < 0.02 ? 0.9 : 1) * 0.5;
    for (let count = this.due(monitor.id, WATER_PER_S, seconds); count > 0; count--) {
      const early = Math.random() * seconds;
      const [x, y, z] = track.at(early);
      this.particles.add(Kind.Water, {
        x,
        y,
        z,
        age: early,
        // It ends where it lands.
        life: track.end_s + 1,
        size: 0.34,
        grow: 0.55 + wide * 0.9,
        alpha: 0.34 - wide * 0.16,
        track,
        stray: scatter().multiplyScalar(spread).toArray(),
        foam: monitor.foam ? 1 : 0,
      });
    }
  }

  /** The surface that water falls on: the ground or a roof; only low enough water is looked up. */
  private readonly floorAt = (x: number, y: number, z: number): number =>
    y > this.tallest ? 0 : groundAt([x, -z], this.shown.site?.tanks ?? []);

  private ribbon(monitor: PlanMonitor, track: Track | null, bearing: number): void {
    let ribbon = this.ribbons.get(monitor.id);
    if (!ribbon) {
      if (!track) return;
      ribbon = new Ribbon();
      this.ribbons.set(monitor.id, ribbon);
      this.scene.add(ribbon.mesh);
    }
    ribbon.set(track, bearing, monitor.nozzle_mm ?? 60, monitor.foam ? this.palette.foam : this.palette.water);
  }

  private splash(drop: { x: number; y: number; z: number; foam: number; floor: number }): void {
    if (Math.random() > 0.55) return;
    const out = scatter().multiplyScalar(2.2);
    this.particles.add(Kind.Splash, {
      x: drop.x,
      y: Math.max(drop.floor, drop.y) + 0.15,
      z: drop.z,
      vx: out.x,
      vy: 0.4 + Math.random() * 0.6,
      vz: out.z,
      life: 0.75,
      size: 0.5,
      grow: 2.6,
      alpha: 0.2,
      floor: drop.floor,
      foam: drop.foam,
    });
  }

  private fire(seconds: number): void {
    const burning = (this.shown.scene?.fires ?? []).filter(({ burns }) => burns);
    this.glows.forEach((glow, index) => {
      const fire = burning[index];
      glow.intensity = fire ? (this.dark ? 300 : 45) * (0.85 + Math.random() * 0.3) : 0;
      if (fire) glow.position.set(fire.at[0], fire.base + 3, -fire.at[1]);
    });
    for (const fire of burning) {
      const radius = fire.size / 2;
      const strong = Math.min(Math.sqrt(Math.max(fire.heat_kw, 200) / 2800), 1.3);
      const many = Math.min(Math.max(radius / 3, 0.5), 2);
      for (let count = this.due(`${fire.name}/f`, FLAMES_PER_S * many, seconds); count > 0; count--) {
        this.particles.add(
          Kind.Flame,
          this.spot(fire, radius * 0.85, {
            vy: (3.2 + Math.random() * 3) * strong,
            life: 0.7 + Math.random() * 0.7,
            size: radius * 0.62 * strong,
            grow: -radius * 0.22,
            alpha: this.dark ? 0.62 : 0.8,
          }),
        );
      }
      for (let count = this.due(`${fire.name}/s`, SMOKE_PER_S * many, seconds); count > 0; count--) {
        this.particles.add(
          Kind.Smoke,
          this.spot(fire, radius * 0.6, {
            y: fire.base + 2.5 + Math.random() * 2,
            vy: 2.6 + Math.random() * 1.8,
            life: 6 + Math.random() * 4,
            size: radius * 0.9,
            grow: 0.95,
            alpha: this.dark ? 0.36 : 0.26,
          }),
        );
      }
    }
  }

  private spot(fire: { at: Place; base: number }, radius: number, more: object): object {
    const angle = Math.random() * 2 * Math.PI;
    const far = Math.sqrt(Math.random()) * radius;
    return {
      x: fire.at[0] + Math.cos(angle) * far,
      y: fire.base,
      z: -fire.at[1] + Math.sin(angle) * far,
      ...more,
    };
  }

  private named(): void {
    const { site, monitors, selected } = this.shown;
    const wanted = new Set<string>();
    const size = (LABEL_PX * 2 * Math.tan((this.camera.fov * Math.PI) / 360)) / Math.max(this.size[1], 1);
    const put = (key: string, text: string, at: Vector3, chosen: boolean, quiet = false): void => {
      wanted.add(key);
      let label = this.labels.get(key);
      if (!label) {
        label = new Label(quiet);
        this.labels.set(key, label);
        this.scene.add(label.sprite);
      }
      const { accent, surface, line } = this.colours;
      label.set({
        text,
        colour: quiet ? this.colours.quiet : chosen ? (this.dark ? '#08131d' : '#ffffff') : this.colours.text,
        back: chosen ? accent : quiet ? '#0000' : surface,
        line: chosen ? accent : quiet ? '#0000' : line,
      });
      label.size = size;
      label.sprite.position.copy(at);
    };
    for (const { id, at, height } of monitors) {
      // Seen from a monitor, its own name is hidden.
      if (id === selected && this.preset === 'eye') continue;
      put(`m/${id}`, id, new Vector3(at[0], height + 2.2, -at[1]), id === selected);
    }
    for (const { name, at, height, diameter } of site?.tanks ?? []) {
      // On the side of the shell that is seen, where other tanks may hide it; on the roof from above.
      const middle = new Vector3(at[0], 0, -at[1]);
      const toward = this.camera.position.clone().sub(middle);
      // Its name must not be wider than the tank.
      if ((diameter / toward.length()) * (LABEL_PX / size) < NAMED_PX) continue;
      const above = toward.y > Math.hypot(toward.x, toward.z) * STEEP;
      const place = above
        ? middle.setY(height + 1)
        : middle.add(toward.setY(0).setLength(diameter / 2 + 1.3)).setY(height * 0.36);
      put(`t/${name}`, name, place, false, true);
    }
    for (const [key, label] of this.labels) {
      if (wanted.has(key)) continue;
      this.scene.remove(label.sprite);
      label.dispose();
      this.labels.delete(key);
    }
  }

  /** Fewer pixels, then fewer particles, where the machine is slow. */
  private judge(took_ms: number): void {
    this.frames.push(took_ms);
    if (this.frames.length < FRAMES_JUDGED) return;
    const middle = [...this.frames].sort((a, b) => a - b)[FRAMES_JUDGED >> 1]!;
    this.frames = [];
    if (middle <= SLOW_FRAME_MS) return;
    const ratio = this.renderer.getPixelRatio();
    if (ratio > 0.75) {
      this.renderer.setPixelRatio(Math.max(ratio * 0.8, 0.75));
      this.resize(...this.size);
    } else {
      this.particles.share = Math.max(this.particles.share * 0.7, SHARE_LEAST);
    }
  }
}

function scatter(): Vector3 {
  const up = Math.random() * 2 - 1;
  const angle = Math.random() * 2 * Math.PI;
  const flat = Math.sqrt(1 - up * up) * Math.sqrt(Math.random());
  return new Vector3(Math.cos(angle) * flat, up * Math.sqrt(Math.random()), Math.sin(angle) * flat);
}
