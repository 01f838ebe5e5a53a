// SPDX-License-Identifier: BSD-3-Clause
// Where a planner will set its feet: a sole for each step with the way it points, numbered in the order of the plan.
import {
  BufferGeometry, CircleGeometry, DoubleSide, Group, Line, LineBasicMaterial, Mesh, MeshBasicMaterial, Quaternion, RingGeometry, Sprite, Vector3,
} from 'three';
import { disposeSprite, textSprite } from './labels';
import { CLIMB, FootstepPlanMessage, RIGHT } from './messages';
import { vectorOf } from './space';

export const SOLE_COLOURS = ['#0b3d91', '#a33b00'];  // left, right
const LIFT_M = 0.006;
const CORNERS = 20;
const NUMBERED_EVERY = 5;  // more numbers would hide the soles

function numberOf(step: number, place: Vector3): Sprite {
  const above = place.clone().add(new Vector3(0, 0, 0.08));
  return textSprite(String(step), above, { size: 0.018, paper: 'rgba(40, 40, 40, 0.7)' });
}

export class Footsteps {
  readonly group = new Group();
  private made: FootstepPlanMessage | null = null;
  private readonly soles = SOLE_COLOURS.map((color) => new MeshBasicMaterial({ color, side: DoubleSide }));
  private readonly rim = new MeshBasicMaterial({ color: 0xffffff, side: DoubleSide });
  private readonly way = new LineBasicMaterial({ color: 0xffffff });

  update(plan: FootstepPlanMessage | null): void {
    if (plan === this.made) return;
    this.made = plan;
    this.clear();
    if (!plan || plan.n_steps === 0) return;
    const sole = new CircleGeometry(plan.foot_radius, CORNERS);
    const rim = new RingGeometry(plan.foot_radius, 1.25 * plan.foot_radius, CORNERS);
    const places: Vector3[] = [];
    for (let i = 0; i < plan.n_steps; ++i) {
      const normal = vectorOf(plan.normal[i]);
      const place = vectorOf(plan.pos[i]).addScaledVector(normal, LIFT_M);
      const upright = new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), normal);
      places.push(place);
      const disc = new Mesh(sole, this.soles[plan.side[i] === RIGHT ? 1 : 0]);
      disc.position.copy(place);
      disc.quaternion.copy(upright);
      this.group.add(disc, this.toe(place, upright, plan.heading[i], plan.foot_radius));
      if (plan.gait[i] === CLIMB) {
        const ring = new Mesh(rim, this.rim);
        ring.position.copy(place);
        ring.quaternion.copy(upright);
        this.group.add(ring);
      }
      if (i === 0 || i === plan.n_steps - 1 || (i + 1) % NUMBERED_EVERY === 0) this.group.add(numberOf(i + 1, place));
    }
    this.group.add(new Line(new BufferGeometry().setFromPoints(places), this.way));
  }

  get numSoles(): number {
    return this.made?.n_steps ?? 0;
  }

  private toe(place: Vector3, upright: Quaternion, heading: number, radiusM: number): Line {
    const ahead = new Vector3(Math.cos(heading), Math.sin(heading), 0).applyQuaternion(upright);
    const lifted = place.clone().add(new Vector3(0, 0, LIFT_M));
    return new Line(new BufferGeometry().setFromPoints([lifted, lifted.clone().addScaledVector(ahead, 1.8 * radiusM)]), this.way);
  }

  private clear(): void {
    for (const child of [...this.group.children]) {
      if (child instanceof Sprite) disposeSprite(child);
      else (child as Mesh).geometry.dispose();
      this.group.remove(child);
    }
  }
}
