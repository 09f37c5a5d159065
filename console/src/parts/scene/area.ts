// The landing area of a jet, on the ground.
import { BufferAttribute, BufferGeometry, DoubleSide, Mesh, MeshBasicMaterial } from 'three';
import type { Place } from '../geometry';
import type { LandingArea } from '../plan/landing';

const SPANS = 24;
/** Above the ground, so that the two do not flicker through each other. */
const ABOVE_M = 0.06;
const ALPHA = 0.22;

export class Area {
  readonly mesh: Mesh<BufferGeometry, MeshBasicMaterial>;
  private readonly places = new BufferAttribute(new Float32Array((SPANS + 1) * 2 * 3), 3);

  constructor(colour: string) {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', this.places);
    geometry.setIndex(
      Array.from({ length: SPANS }, (_, n) => [2 * n, 2 * n + 1, 2 * n + 2, 2 * n + 1, 2 * n + 3, 2 * n + 2]).flat(),
    );
    this.mesh = new Mesh(
      geometry,
      new MeshBasicMaterial({ color: colour, transparent: true, opacity: ALPHA, depthWrite: false, side: DoubleSide }),
    );
    this.mesh.frustumCulled = false;
    this.mesh.visible = false;
  }

  /** `null`: not shown. */
  set(at: Place, area: LandingArea | null): void {
    this.mesh.visible = area !== null;
    if (!area) return;
    for (let span = 0; span <= SPANS; span++) {
      const bearing = ((area.bearing + (span / SPANS - 0.5) * area.width) * Math.PI) / 180;
      for (const [side, range] of [area.near_m, area.far_m].entries()) {
        const [east, north] = [at[0] + Math.sin(bearing) * range, at[1] + Math.cos(bearing) * range];
        this.places.setXYZ(2 * span + side, east, ABOVE_M, -north);
      }
    }
    this.places.needsUpdate = true;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }
}
