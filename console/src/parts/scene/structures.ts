// What does not move: ground, tanks, walls. Everything that exists more than once is one mesh.
import {
  BoxGeometry,
  BufferGeometry,
  CircleGeometry,
  Color,
  CylinderGeometry,
  DoubleSide,
  Float32BufferAttribute,
  Group,
  InstancedMesh,
  LineBasicMaterial,
  LineSegments,
  type Material,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  Quaternion,
  TorusGeometry,
  Vector3,
} from 'three';
import type { Box } from '../geometry';
import type { PlanSite } from '../plan/model';

export interface Colours {
  sky: string;
  ground: string;
  grid: string;
  shell: string;
  roof: string;
  wall: string;
  steel: string;
  dark: string;
  accent: string;
  high: string;
  water: string;
  text: string;
  surface: string;
  line: string;
  quiet: string;
}

const UP = new Vector3(0, 1, 0);
const FLAT = new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), -Math.PI / 2);
/** Roofs float a little below the rim. */
const ROOF_BELOW_M = 0.35;

export class Structures {
  readonly group = new Group();
  private readonly owned: { dispose(): void }[] = [];

  constructor(site: PlanSite, box: Box, colours: Colours) {
    this.ground(box, colours);
    this.tanks(site, colours);
    this.walls(site, colours);
  }

  dispose(): void {
    for (const thing of this.owned) thing.dispose();
    this.group.clear();
  }

  private keep<T extends { dispose(): void }>(thing: T): T {
    this.owned.push(thing);
    return thing;
  }

  private many(geometry: BufferGeometry, material: Material, places: Matrix4[]): void {
    if (!places.length) return;
    const mesh = this.keep(new InstancedMesh(this.keep(geometry), this.keep(material), places.length));
    places.forEach((place, index) => mesh.setMatrixAt(index, place));
    mesh.computeBoundingSphere();
    this.group.add(mesh);
  }

  private ground(box: Box, colours: Colours): void {
    const ground = new Mesh(
      this.keep(new CircleGeometry(600, 48)),
      this.keep(new MeshLambertMaterial({ color: new Color(colours.ground) })),
    );
    ground.quaternion.copy(FLAT);
    ground.position.y = -0.04;
    this.group.add(ground);
    const places: number[] = [];
    const round = (value: number, up: boolean): number => (up ? Math.ceil(value / 10) : Math.floor(value / 10)) * 10;
    const [west, east] = [round(box.west - 20, false), round(box.east + 20, true)];
    const [south, north] = [round(box.south - 20, false), round(box.north + 20, true)];
    for (let x = west; x <= east; x += 10) places.push(x, 0, -south, x, 0, -north);
    for (let y = south; y <= north; y += 10) places.push(west, 0, -y, east, 0, -y);
    const lines = this.keep(new BufferGeometry());
    lines.setAttribute('position', new Float32BufferAttribute(places, 3));
    const material = new LineBasicMaterial({ color: colours.grid, transparent: true, opacity: 0.55 });
    this.group.add(new LineSegments(lines, this.keep(material)));
  }

  private tanks(site: PlanSite, colours: Colours): void {
    const round = site.tanks.map(({ at, diameter, height }) => ({
      x: at[0],
      z: -at[1],
      radius: diameter / 2,
      height,
    }));
    const at = (x: number, y: number, z: number, turn: Quaternion, scale: Vector3): Matrix4 =>
      new Matrix4().compose(new Vector3(x, y, z), turn, scale);
    const none = new Quaternion();
    this.many(
      new CylinderGeometry(1, 1, 1, 40, 1, true),
      new MeshLambertMaterial({ color: colours.shell, side: DoubleSide }),
      round.map(({ x, z, radius, height }) => at(x, height / 2, z, none, new Vector3(radius, height, radius))),
    );
    this.many(
      new CircleGeometry(1, 40),
      new MeshLambertMaterial({ color: colours.roof }),
      round.map(({ x, z, radius, height }) => at(x, height - ROOF_BELOW_M, z, FLAT, new Vector3(radius, radius, 1))),
    );
    const rims = round.flatMap(({ x, z, radius, height }) =>
      [1, 0.55].map((part) => at(x, height * part, z, FLAT, new Vector3(radius, radius, radius))),
    );
    this.many(new TorusGeometry(1, 0.022, 6, 40), new MeshLambertMaterial({ color: colours.steel }), rims);
    this.shadows(round);
  }

  /** Soft discs under the tanks: no shadow maps on weak machines. */
  private shadows(round: { x: number; z: number; radius: number }[]): void {
    this.many(
      new CircleGeometry(1, 32),
      new MeshBasicMaterial({ color: '#000000', transparent: true, opacity: 0.18, depthWrite: false }),
      round.map(({ x, z, radius }) =>
        new Matrix4().compose(new Vector3(x + 0.9, 0.01, z + 0.7), FLAT, new Vector3(radius + 0.9, radius + 0.9, 1)),
      ),
    );
  }

  private walls(site: PlanSite, colours: Colours): void {
    this.many(
      new BoxGeometry(1, 1, 1),
      new MeshLambertMaterial({ color: colours.wall }),
      site.walls.map(({ from, to, height }) => {
        const [x, z] = [to[0] - from[0], -(to[1] - from[1])];
        const turn = new Quaternion().setFromAxisAngle(UP, -Math.atan2(z, x));
        return new Matrix4().compose(
          new Vector3((from[0] + to[0]) / 2, height / 2, -(from[1] + to[1]) / 2),
          turn,
          new Vector3(Math.hypot(x, z), height, 0.4),
        );
      }),
    );
  }
}
