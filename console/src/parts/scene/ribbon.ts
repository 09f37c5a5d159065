// The part of a jet that holds together: a strip of light along its flight, wider where it breaks up.
import { BufferAttribute, BufferGeometry, DoubleSide, DynamicDrawUsage, Mesh, MeshBasicMaterial, Vector3 } from 'three';
import { sprayHalfAngle } from '../spray';
import type { Track } from './track';

const POINTS = 36;
const MOUTH_M = 0.13;
const WIDEST_M = 2.4;
/** Opacity of the strip at the nozzle, and where it lands. */
const ALPHA = [0.85, 0.12] as const;

export class Ribbon {
  readonly mesh: Mesh<BufferGeometry, MeshBasicMaterial>;
  private readonly places = new BufferAttribute(new Float32Array(POINTS * 4 * 3), 3);
  private readonly colours = new BufferAttribute(new Float32Array(POINTS * 4 * 4), 4);

  constructor() {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', this.places.setUsage(DynamicDrawUsage));
    geometry.setAttribute('color', this.colours.setUsage(DynamicDrawUsage));
    const faces: number[] = [];
    // Two crossed strips, one horizontal and one vertical, so that it is visible from every side.
    for (const strip of [0, 2]) {
      for (let point = 0; point < POINTS - 1; point++) {
        const [a, b] = [point * 4 + strip, point * 4 + strip + 1];
        faces.push(a, b, a + 4, b, b + 4, a + 4);
      }
    }
    geometry.setIndex(faces);
    this.mesh = new Mesh(
      geometry,
      new MeshBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false, side: DoubleSide }),
    );
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 6;
    this.mesh.visible = false;
  }

  /** `null`: no water. */
  set(track: Track | null, bearing: number, nozzle_mm: number, colour: readonly [number, number, number]): void {
    this.mesh.visible = Boolean(track);
    if (!track) return;
    const ahead = new Vector3(Math.sin(toRadians(bearing)), 0, -Math.cos(toRadians(bearing)));
    const aside = new Vector3(-ahead.z, 0, ahead.x);
    const spread = Math.tan(toRadians(sprayHalfAngle(nozzle_mm))) * 0.8;
    const [mouth_x, , mouth_z] = track.at(0);
    for (let index = 0; index < POINTS; index++) {
      const part = index / (POINTS - 1);
      const at = new Vector3(...track.at(part * track.end_s));
      const way = Math.hypot(at.x - mouth_x, at.z - mouth_z);
      const half = Math.min(MOUTH_M + way * spread * 0.55, WIDEST_M);
      const alpha = (ALPHA[0] + (ALPHA[1] - ALPHA[0]) * Math.sqrt(part)) * (MOUTH_M / half) ** 0.25;
      this.point(index * 4, at, aside, half, colour, alpha);
      this.point(index * 4 + 2, at, UP, half, colour, alpha);
    }
    this.places.needsUpdate = true;
    this.colours.needsUpdate = true;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }

  private point(
    index: number,
    at: Vector3,
    across: Vector3,
    half: number,
    [red, green, blue]: readonly [number, number, number],
    alpha: number,
  ): void {
    for (const side of [-1, 1]) {
      const vertex = index + (side > 0 ? 1 : 0);
      this.places.setXYZ(
        vertex,
        at.x + across.x * half * side,
        at.y + across.y * half * side,
        at.z + across.z * half * side,
      );
      this.colours.setXYZW(vertex, red, green, blue, alpha);
    }
  }
}

const UP = new Vector3(0, 1, 0);

function toRadians(degrees: number): number {
  return (degrees * Math.PI) / 180;
}
