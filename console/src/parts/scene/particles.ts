// Water, splashes, flames and smoke: all of them points in one draw call.
import {
  BufferAttribute,
  BufferGeometry,
  CustomBlending,
  DynamicDrawUsage,
  OneFactor,
  OneMinusSrcAlphaFactor,
  Points,
  ShaderMaterial,
} from 'three';
import type { Track } from './track';

export const Kind = { Water: 0, Splash: 1, Smoke: 2, Flame: 3 } as const;
export type Kind = (typeof Kind)[keyof typeof Kind];

interface Body {
  kind: Kind;
  age: number;
  life: number;
  x: number;
  y: number;
  z: number;
  vx: number;
  vy: number;
  vz: number;
  size: number;
  grow: number;
  alpha: number;
  /** Where it ends: height of the surface below. */
  floor: number;
  /** The path of water, the direction of its scatter, and the scatter as a part of the distance flown. */
  track: Track | null;
  stray: readonly [number, number, number];
  foam: number;
}

/** Height of a splash, m. */
const SPLASH_M = 0.6;
/** Drawn in this order: smoke behind flames behind water. */
const ORDER = [Kind.Smoke, Kind.Flame, Kind.Splash, Kind.Water];

/** Colours of the kinds: red, green, blue. */
export type Palette = Record<'water' | 'foam' | 'smoke' | 'flame' | 'ember', [number, number, number]> & {
  /** How much a flame hides what is behind it: 0 it adds its light, 1 it covers. */
  shine: number;
};

export class Particles {
  readonly points: Points;
  palette: Palette;
  /** Part of the particles that is drawn, less on weak machines. */
  share = 1;
  private bodies: Body[] = [];
  private spare: Body[] = [];
  private readonly geometry = new BufferGeometry();
  private readonly material: ShaderMaterial;
  private readonly at: BufferAttribute;
  private readonly colour: BufferAttribute;
  private readonly look: BufferAttribute;

  constructor(
    private readonly most: number,
    palette: Palette,
  ) {
    this.palette = palette;
    this.at = new BufferAttribute(new Float32Array(most * 3), 3).setUsage(DynamicDrawUsage);
    this.colour = new BufferAttribute(new Float32Array(most * 4), 4).setUsage(DynamicDrawUsage);
    this.look = new BufferAttribute(new Float32Array(most * 2), 2).setUsage(DynamicDrawUsage);
    this.geometry.setAttribute('position', this.at);
    this.geometry.setAttribute('colour', this.colour);
    this.geometry.setAttribute('look', this.look);
    this.geometry.setDrawRange(0, 0);
    this.material = new ShaderMaterial({
      uniforms: { height: { value: 600 } },
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      transparent: true,
      depthWrite: false,
      blending: CustomBlending,
      blendSrc: OneFactor,
      blendDst: OneMinusSrcAlphaFactor,
    });
    this.points = new Points(this.geometry, this.material);
    this.points.frustumCulled = false;
    this.points.renderOrder = 5;
  }

  get count(): number {
    return this.bodies.length;
  }

  /** Pixels from top to bottom, for the size of a point. */
  set height(pixels: number) {
    this.material.uniforms.height!.value = pixels;
  }

  add(kind: Kind, made: Partial<Body>): void {
    if (this.bodies.length >= this.most) return;
    const body = this.spare.pop() ?? ({} as Body);
    Object.assign(body, BLANK, made, { kind });
    this.bodies.push(body);
  }

  clear(): void {
    this.spare.push(...this.bodies);
    this.bodies = [];
    this.geometry.setDrawRange(0, 0);
  }

  /** Advances everything; reports where water landed. */
  step(
    seconds: number,
    wind: readonly [number, number],
    floorAt: (x: number, y: number, z: number) => number,
    landed: (body: Body) => void,
  ): void {
    const kept: Body[] = [];
    const fallen: Body[] = [];
    for (const body of this.bodies) {
      body.age += seconds;
      if (body.kind === Kind.Water) fly(body);
      else if (body.kind === Kind.Splash) spring(body, seconds);
      else rise(body, seconds, wind);
      const water = body.kind === Kind.Water && body.vy < 0;
      const ended = water && body.age >= body.track!.end_s;
      const down = ended || (body.vy < 0 && body.y <= (water ? floorAt(body.x, body.y, body.z) : body.floor));
      if (water && down) body.floor = body.y;
      if (body.kind === Kind.Water && down) fallen.push(body);
      if (body.age >= body.life || (down && body.kind !== Kind.Smoke)) this.spare.push(body);
      else kept.push(body);
    }
    this.bodies = kept;
    for (const body of fallen) landed(body);
    this.write();
  }

  dispose(): void {
    this.geometry.dispose();
    this.material.dispose();
  }

  private write(): void {
    let index = 0;
    const [at, colour, look] = [this.at.array, this.colour.array, this.look.array];
    for (const kind of ORDER) {
      for (const body of this.bodies) {
        if (body.kind !== kind) continue;
        at[index * 3] = body.x;
        at[index * 3 + 1] = body.y;
        at[index * 3 + 2] = body.z;
        this.paint(body, colour, index * 4);
        look[index * 2] = body.size + body.grow * body.age;
        look[index * 2 + 1] = kind === Kind.Flame ? this.palette.shine : 1;
        index++;
      }
    }
    this.geometry.setDrawRange(0, index);
    for (const attribute of [this.at, this.colour, this.look]) {
      attribute.clearUpdateRanges();
      attribute.addUpdateRange(0, index * attribute.itemSize);
      attribute.needsUpdate = true;
    }
  }

  private paint(body: Body, colour: ArrayLike<number> & { [n: number]: number }, to: number): void {
    const part = body.age / body.life;
    const { palette } = this;
    let from = body.foam > 0.5 ? palette.foam : palette.water;
    let alpha = body.alpha;
    if (body.kind === Kind.Smoke) {
      from = palette.smoke;
      alpha *= Math.min(part * 6, 1) * (1 - part) ** 1.2;
    } else if (body.kind === Kind.Flame) {
      const mix = Math.min(part * 1.6, 1);
      from = [0, 1, 2].map((channel) => palette.flame[channel]! * (1 - mix) + palette.ember[channel]! * mix) as [
        number,
        number,
        number,
      ];
      alpha *= Math.min(part * 8, 1) * (1 - part);
    } else {
      alpha *= body.kind === Kind.Splash ? (1 - part) ** 1.5 : Math.min(part * 10, 1);
    }
    colour[to] = from[0];
    colour[to + 1] = from[1];
    colour[to + 2] = from[2];
    colour[to + 3] = alpha;
  }
}

const BLANK: Omit<Body, 'kind'> = {
  age: 0,
  life: 1,
  x: 0,
  y: 0,
  z: 0,
  vx: 0,
  vy: 0,
  vz: 0,
  size: 0.3,
  grow: 0,
  alpha: 1,
  floor: -1000,
  track: null,
  stray: [0, 0, 0],
  foam: 0,
};

/** Along its computed flight, scattered as spray. */
function fly(body: Body): void {
  if (!body.track) return;
  const [x, y, z] = body.track.at(body.age);
  const [from_x, , from_z] = body.track.at(0);
  const far = Math.hypot(x - from_x, z - from_z);
  const before = body.y;
  body.x = x + body.stray[0] * far;
  body.y = y + body.stray[1] * far;
  body.z = z + body.stray[2] * far;
  body.vy = body.age >= body.track.end_s ? -1 : body.y - before;
}

/** Up and down once in its lifetime. */
function spring(body: Body, seconds: number): void {
  const part = Math.min(body.age / body.life, 1);
  body.x += body.vx * seconds;
  body.z += body.vz * seconds;
  body.y = body.floor + 4 * SPLASH_M * body.vy * part * (1 - part);
}

function rise(body: Body, seconds: number, wind: readonly [number, number]): void {
  const ease = Math.min(seconds * 0.9, 1);
  body.vx += (wind[0] - body.vx) * ease;
  body.vz += (-wind[1] - body.vz) * ease;
  body.x += body.vx * seconds;
  body.y += body.vy * seconds;
  body.z += body.vz * seconds;
}

const VERTEX = `
attribute vec4 colour;
attribute vec2 look;
uniform float height;
varying vec4 tint;
varying float solid;
void main() {
  tint = colour;
  solid = look.y;
  vec4 seen = modelViewMatrix * vec4(position, 1.0);
  gl_Position = projectionMatrix * seen;
  gl_PointSize = clamp(look.x * height * projectionMatrix[1][1] * 0.5 / max(-seen.z, 0.1), 1.0, 220.0);
}`;

const FRAGMENT = `
varying vec4 tint;
varying float solid;
void main() {
  float away = length(gl_PointCoord - 0.5) * 2.0;
  float soft = smoothstep(1.0, 0.1, away) * tint.a;
  gl_FragColor = vec4(tint.rgb * soft, soft * solid);
}`;
