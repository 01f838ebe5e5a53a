// SPDX-License-Identifier: BSD-3-Clause
// Where the camera has been, how sure that is, and where it looks now.
import {
  BufferAttribute, BufferGeometry, Group, InstancedMesh, Line, LineBasicMaterial, LineSegments, Matrix4, MeshBasicMaterial, SphereGeometry,
  Vector3,
} from 'three';
import { CameraInfo, Model, PathPoint } from './model';
import { colourOf, TRACKING_COLOURS } from './palette';
import { ellipsoidOf, matrixOf, Pose } from './space';

const ELLIPSOID_EVERY_M = 0.25;
const MAX_ELLIPSOIDS = 2000;
const SIGMAS = 3;
const FRUSTUM_M = 0.35;
const COLOURS = TRACKING_COLOURS.map(colourOf);
const DEFAULT_VIEW: CameraInfo = { width: 4, height: 3, fx: 3, fy: 3, cx: 2, cy: 1.5 };

export class CameraPath {
  readonly line = new Line(new BufferGeometry(), new LineBasicMaterial({ vertexColors: true, linewidth: 2 }));
  readonly covariance = new Group();
  readonly camera = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: 0xd55e00 }));
  private ellipsoids: InstancedMesh;
  private drawn = { length: -1, last: -1 };

  constructor() {
    const material = new MeshBasicMaterial({ color: 0x0072b2, transparent: true, opacity: 0.3, depthWrite: false });
    this.ellipsoids = new InstancedMesh(new SphereGeometry(1, 12, 8), material, MAX_ELLIPSOIDS);
    this.ellipsoids.count = 0;
    this.ellipsoids.frustumCulled = false;
    this.covariance.add(this.ellipsoids);
    for (const object of [this.line, this.camera]) object.frustumCulled = false;
  }

  update(model: Model): void {
    const last = model.path.at(-1)?.utime ?? -1;
    if (model.path.length === this.drawn.length && last === this.drawn.last) return;
    this.drawn = { length: model.path.length, last };
    this.drawLine(model);
    this.drawCovariance(model);
    this.drawCamera(model.cameraPose(), model.camera ?? DEFAULT_VIEW);
  }

  get numEllipsoids(): number {
    return this.ellipsoids.count;
  }

  private drawLine(model: Model): void {
    const positions = new Float32Array(3 * model.path.length);
    const colours = new Uint8Array(3 * model.path.length);
    model.path.forEach((point, i) => {
      model.cameraPoseAt(point).position.toArray(positions, 3 * i);
      colours.set(COLOURS[point.message.status] ?? COLOURS[0], 3 * i);
    });
    this.line.geometry.dispose();
    this.line.geometry.setAttribute('position', new BufferAttribute(positions, 3));
    this.line.geometry.setAttribute('color', new BufferAttribute(colours, 3, true));
  }

  /// Ellipsoids of three standard deviations, true to scale; the covariance is in the axes of the body.
  private drawCovariance(model: Model): void {
    let count = 0;
    let before: PathPoint | null = null;
    const add = (point: PathPoint) => {
      const c = point.message.cov;
      const block = [21, 22, 23, 27, 28, 29, 33, 34, 35].map((i) => c[i]);
      const shape = new Matrix4().setFromMatrix3(ellipsoidOf(block, SIGMAS));
      const place: Pose = { position: model.cameraPoseAt(point).position, rotation: point.body.rotation };
      this.ellipsoids.setMatrixAt(count++, matrixOf(place).multiply(shape));
    };
    for (const point of model.path) {
      if (before && point.body.position.distanceTo(before.body.position) < ELLIPSOID_EVERY_M) continue;
      before = point;
      if (count < MAX_ELLIPSOIDS - 1) add(point);
    }
    const last = model.path.at(-1);
    if (last && last !== before) add(last);
    this.ellipsoids.count = count;
    this.ellipsoids.instanceMatrix.needsUpdate = true;
  }

  private drawCamera(pose: Pose | null, view: CameraInfo): void {
    this.camera.geometry.dispose();
    // Otherwise three.js keeps the old buffer, and cuts off what is longer.
    this.camera.geometry.deleteAttribute('position');
    if (!pose) {
      this.camera.geometry.setFromPoints([]);
      return;
    }
    const corners = [[0, 0], [view.width, 0], [view.width, view.height], [0, view.height]].map(([u, v]) => (
      new Vector3((u - view.cx) / view.fx, (v - view.cy) / view.fy, 1).multiplyScalar(FRUSTUM_M)));
    const points: Vector3[] = [];
    corners.forEach((corner, i) => points.push(new Vector3(), corner, corner, corners[(i + 1) % 4]));
    const up = new Vector3(0, (-view.cy / view.fy) * 1.25, 1).multiplyScalar(FRUSTUM_M);
    points.push(corners[0], up, up, corners[1]);
    const T = matrixOf(pose);
    this.camera.geometry.setFromPoints(points.map((p) => p.clone().applyMatrix4(T)));
  }
}
