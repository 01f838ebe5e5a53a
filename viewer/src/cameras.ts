// SPDX-License-Identifier: BSD-3-Clause
// From where the viewer looks: freely, following the robot, or in true plan and elevation.
import { OrthographicCamera, PerspectiveCamera, Vector3 } from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

export const VIEWS = ['free', 'follow', 'top', 'side'] as const;
export type View = (typeof VIEWS)[number];

export interface Place {
  position: [number, number, number];
  target: [number, number, number];
  zoom: number;
}

export class Cameras {
  readonly controls: OrbitControls;
  view: View = 'follow';
  private readonly perspective = new PerspectiveCamera(50, 1, 0.05, 400);
  private readonly flat = new OrthographicCamera(-1, 1, 1, -1, -200, 400);
  private robot: Vector3 | null = null;

  constructor(element: HTMLElement) {
    for (const camera of [this.perspective, this.flat]) camera.up.set(0, 0, 1);
    this.perspective.position.set(-3.2, -2.4, 2.6);
    this.controls = new OrbitControls(this.perspective, element);
    this.controls.target.set(1, 0, 0);
    this.controls.listenToKeyEvents(window as unknown as HTMLElement);
    this.controls.update();
  }

  get active(): PerspectiveCamera | OrthographicCamera {
    return this.controls.object as PerspectiveCamera | OrthographicCamera;
  }

  resize(width: number, height: number): void {
    this.perspective.aspect = width / height;
    this.perspective.updateProjectionMatrix();
    this.flat.left = -width / height;
    this.flat.right = width / height;
    this.flat.updateProjectionMatrix();
  }

  /// @param extentM  what a plan should show
  choose(view: View, extentM: number, centre: Vector3): void {
    this.view = view;
    const flat = view === 'top' || view === 'side';
    const target = view === 'follow' && this.robot ? this.robot.clone() : flat ? centre.clone() : this.controls.target.clone();
    if (flat) {
      this.flat.zoom = 2 / Math.max(0.5, 1.15 * extentM);
      this.flat.position.copy(target).add(view === 'top' ? new Vector3(0, -1e-3, 50) : new Vector3(0, -50, 0));
      this.flat.updateProjectionMatrix();
      this.controls.object = this.flat;
    } else {
      if (view === 'follow') this.perspective.position.add(target.clone().sub(this.controls.target));
      this.controls.object = this.perspective;
    }
    this.controls.target.copy(target);
    this.controls.enableRotate = !flat;
    this.controls.update();
  }

  /// Where the robot is now: whoever follows it moves along.
  moveRobot(position: Vector3): void {
    if (this.view === 'follow') {
      const step = position.clone().sub(this.robot ?? this.controls.target);
      this.perspective.position.add(step);
      this.controls.target.add(step);
      this.controls.update();
    }
    this.robot = position.clone();
  }

  /// Stands back so far that everything is seen: nearly all of the ball around it, of which maps fill little.
  frame(centre: Vector3, diagonalM: number): void {
    const narrower = Math.min(1, this.perspective.aspect);
    const backM = (0.45 * diagonalM) / (Math.sin((this.perspective.fov * Math.PI) / 360) * narrower);
    const away = new Vector3(-0.62, -0.55, 0.56).multiplyScalar(Math.max(1.5, backM));
    this.perspective.position.copy(centre).add(away);
    this.controls.target.copy(centre);
    this.controls.update();
  }

  place(): Place {
    const round = (v: Vector3) => v.toArray().map((x) => Number(x.toFixed(3))) as [number, number, number];
    return { position: round(this.active.position), target: round(this.controls.target), zoom: Number(this.active.zoom.toFixed(4)) };
  }

  takePlace(place: Place): void {
    this.active.position.fromArray(place.position);
    this.controls.target.fromArray(place.target);
    this.active.zoom = place.zoom;
    this.active.updateProjectionMatrix();
    this.controls.update();
  }
}
