// The monitors: a mast, a turret that turns, a barrel that rises; instanced, whatever their number.
import {
  BoxGeometry,
  BufferGeometry,
  Color,
  CylinderGeometry,
  Float32BufferAttribute,
  Group,
  InstancedMesh,
  Line,
  LineBasicMaterial,
  type Material,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  Quaternion,
  RingGeometry,
  SphereGeometry,
  Vector3,
} from 'three';
import { bearingOf, signedDegrees } from '../geometry';
import type { PlanMonitor } from '../plan/model';
import type { Colours } from './structures';

const RADIANS = Math.PI / 180;
/** Drawn larger than it is, to be seen across a site. */
const BARREL_M = 3;
const WRAPPED_DEGREES = -78;
/** How quickly the picture follows the values: most of the distance in a fifth of a second. */
const FOLLOW_PER_S = 14;

export interface Pose {
  id: string;
  /** Degrees from north, and above the horizon. */
  bearing: number;
  elevation: number;
  /** The mouth of the barrel. */
  mouth: Vector3;
  foot: Vector3;
}

export class Barrels {
  readonly group = new Group();
  readonly poses = new Map<string, Pose>();
  private readonly owned: { dispose(): void }[] = [];
  private readonly masts: InstancedMesh;
  private readonly decks: InstancedMesh;
  private readonly turrets: InstancedMesh;
  private readonly tubes: InstancedMesh;
  private readonly aim: Line;
  private readonly ring: Mesh;

  constructor(
    private readonly count: number,
    private readonly colours: Colours,
  ) {
    const steel = (): Material => this.keep(new MeshLambertMaterial({ color: '#ffffff' }));
    this.masts = this.many(new CylinderGeometry(0.34, 0.5, 1, 10), steel());
    this.decks = this.many(new BoxGeometry(2.6, 0.22, 2.6), steel());
    this.turrets = this.many(new SphereGeometry(0.62, 24, 16), steel());
    this.tubes = this.many(tube(), steel());
    const aim = this.keep(new BufferGeometry());
    aim.setAttribute('position', new Float32BufferAttribute([0, 0, 0, 0, 0, 1], 3));
    this.aim = new Line(
      aim,
      this.keep(new LineBasicMaterial({ color: colours.accent, transparent: true, opacity: 0.5 })),
    );
    this.aim.frustumCulled = false;
    this.ring = new Mesh(
      this.keep(new RingGeometry(0.9, 1, 48)),
      this.keep(new MeshBasicMaterial({ color: colours.accent, transparent: true, opacity: 0.85, depthTest: false })),
    );
    this.ring.rotation.x = -Math.PI / 2;
    this.ring.renderOrder = 4;
    this.group.add(this.aim, this.ring);
  }

  /** Moves the picture towards the values. */
  step(monitors: readonly PlanMonitor[], selected: string, seconds: number, marked = true): void {
    const near = seconds <= 0 ? 1 : 1 - Math.exp(-FOLLOW_PER_S * seconds);
    this.ring.visible = false;
    this.aim.visible = false;
    monitors.slice(0, this.count).forEach((monitor, index) => {
      const pose = this.pose(monitor, near);
      this.place(index, monitor, pose, monitor.id === selected, marked);
    });
    for (const mesh of [this.masts, this.decks, this.turrets, this.tubes]) {
      mesh.count = Math.min(monitors.length, this.count);
      mesh.instanceMatrix.needsUpdate = true;
      if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
    }
  }

  dispose(): void {
    for (const thing of this.owned) thing.dispose();
    this.group.clear();
  }

  private keep<T extends { dispose(): void }>(thing: T): T {
    this.owned.push(thing);
    return thing;
  }

  private many(geometry: BufferGeometry, material: Material): InstancedMesh {
    const mesh = this.keep(new InstancedMesh(this.keep(geometry), material, Math.max(this.count, 1)));
    mesh.frustumCulled = false;
    this.group.add(mesh);
    return mesh;
  }

  private pose(monitor: PlanMonitor, near: number): Pose {
    const bearing = bearingOf(monitor.heading, monitor.horizontal_arcmin ?? 0);
    const elevation = monitor.wrapped ? WRAPPED_DEGREES : (monitor.vertical_arcmin ?? 0) / 60;
    const known = this.poses.get(monitor.id);
    const foot = new Vector3(monitor.at[0], monitor.height, -monitor.at[1]);
    const pose = known ?? { id: monitor.id, bearing, elevation, mouth: new Vector3(), foot };
    pose.foot = foot;
    pose.bearing += signedDegrees(bearing - pose.bearing) * near;
    pose.elevation += (elevation - pose.elevation) * near;
    pose.mouth.copy(directionOf(pose)).multiplyScalar(BARREL_M).add(foot);
    this.poses.set(monitor.id, pose);
    return pose;
  }

  private place(index: number, monitor: PlanMonitor, pose: Pose, chosen: boolean, marked: boolean): void {
    const { foot } = pose;
    const none = new Quaternion();
    const turn = new Quaternion().setFromAxisAngle(new Vector3(0, 1, 0), -pose.bearing * RADIANS);
    const rise = new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), pose.elevation * RADIANS);
    const mast = Math.max(monitor.height - 0.5, 0.1);
    const one = new Vector3(1, 1, 1);
    const matrix = new Matrix4();
    const at = (x: number, y: number, z: number): Vector3 => new Vector3(x, y, z);
    this.masts.setMatrixAt(index, matrix.compose(at(foot.x, mast / 2, foot.z), none, at(1, mast, 1)));
    this.decks.setMatrixAt(index, matrix.compose(at(foot.x, mast, foot.z), turn, one));
    this.turrets.setMatrixAt(index, matrix.compose(foot, turn, one));
    this.tubes.setMatrixAt(index, matrix.compose(foot, turn.clone().multiply(rise), one));
    const colour = new Color(this.colourOf(monitor, chosen));
    const steel = new Color(this.colours.steel);
    this.masts.setColorAt(index, steel);
    this.decks.setColorAt(index, steel);
    this.turrets.setColorAt(index, colour);
    this.tubes.setColorAt(index, colour);
    if (!chosen) return;
    this.ring.visible = marked;
    this.ring.position.set(foot.x, mast + 0.14, foot.z);
    this.ring.scale.setScalar(2);
    this.aim.visible = !monitor.stale && !monitor.wrapped;
    this.aim.position.copy(pose.mouth);
    this.aim.lookAt(pose.mouth.clone().add(directionOf(pose)));
    this.aim.scale.z = (monitor.reach_m ?? 40) * 0.8;
  }

  private colourOf(monitor: PlanMonitor, chosen: boolean): string {
    if (monitor.stale) return this.colours.line;
    if (monitor.concern === 'alarm') return this.colours.high;
    return chosen ? this.colours.accent : this.colours.dark;
  }
}

export function directionOf({ bearing, elevation }: { bearing: number; elevation: number }): Vector3 {
  const level = Math.cos(elevation * RADIANS);
  return new Vector3(
    Math.sin(bearing * RADIANS) * level,
    Math.sin(elevation * RADIANS),
    -Math.cos(bearing * RADIANS) * level,
  );
}

/** A barrel that points to −z (north) from its pivot, with its nozzle. */
function tube(): BufferGeometry {
  const profile: [number, number][] = [
    [0.01, -0.9],
    [0.34, -0.9],
    [0.34, 0.7],
    [0.2, 1.0],
    [0.17, 2.35],
    [0.29, 2.4],
    [0.24, BARREL_M],
    [0.01, BARREL_M],
  ];
  const sides = 20;
  const places: number[] = [];
  const faces: number[] = [];
  for (const [radius, along] of profile) {
    for (let side = 0; side < sides; side++) {
      const angle = (side / sides) * 2 * Math.PI;
      places.push(Math.cos(angle) * radius, Math.sin(angle) * radius, -along);
    }
  }
  for (let ring = 0; ring < profile.length - 1; ring++) {
    for (let side = 0; side < sides; side++) {
      const [a, b] = [ring * sides + side, ring * sides + ((side + 1) % sides)];
      faces.push(a, b, a + sides, b, b + sides, a + sides);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute(places, 3));
  geometry.setIndex(faces);
  geometry.computeVertexNormals();
  return geometry;
}
