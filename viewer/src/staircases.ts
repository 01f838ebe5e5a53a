// SPDX-License-Identifier: BSD-3-Clause
// Staircases: a number on every step, the dimensions before the foot, an arrow up.
import { ArrowHelper, Group, Sprite, Vector3 } from 'three';
import { disposeSprite, textSprite } from './labels';
import { StaircaseMessage } from './messages';
import { Region } from './region';
import { vectorOf } from './space';

const TREAD = 3;
const DEGREES = 180 / Math.PI;

export function dimensionsInWords(stairs: StaircaseMessage): string {
  const turn = stairs.turn_per_step === 0 ? '' : `, turning ${Math.abs(stairs.turn_per_step * DEGREES).toFixed(0)}° a step`;
  return `${stairs.n_risers} steps of ${stairs.riser.toFixed(3)} m, treads ${stairs.tread.toFixed(3)} m, ` +
    `${stairs.width.toFixed(2)} m wide${turn}`;
}

/// A tread may be known in pieces: its number stands on the largest of those that were seen, else on the largest.
function oneOfEachStep(treads: Region[]): Region[] {
  const best = new Map<string, Region>();
  for (const tread of treads) {
    const step = `${tread.message.staircase_id}.${tread.message.step_index}`;
    const other = best.get(step);
    const better = !other || (tread.predicted === other.predicted ? tread.message.area > other.message.area : other.predicted);
    if (better) best.set(step, tread);
  }
  return [...best.values()];
}

export class Staircases {
  readonly group = new Group();
  private made = '';

  update(staircases: Map<number, StaircaseMessage>, regions: Map<number, Region>): void {
    const treads = oneOfEachStep([...regions.values()].filter((r) => r.label === TREAD && r.message.step_index > 0));
    const key = JSON.stringify([...staircases.values()]) + treads.map((r) => `${r.id}.${r.message.revision}`).join();
    if (key === this.made) return;
    this.made = key;
    this.clear();
    for (const tread of treads) {
      const at = tread.origin.clone().addScaledVector(tread.normal, 0.02);
      const paper = tread.predicted ? 'rgba(130, 80, 0, 0.8)' : 'rgba(0, 62, 110, 0.85)';
      this.group.add(textSprite(String(tread.message.step_index), at, { size: 0.026, paper }));
    }
    for (const stairs of staircases.values()) this.add(stairs);
  }

  get texts(): string[] {
    return this.group.children.filter((c) => c instanceof Sprite).map((c) => c.userData.text as string);
  }

  private add(stairs: StaircaseMessage): void {
    const foot = vectorOf(stairs.foot_edge).add(vectorOf(stairs.foot_edge, 3)).multiplyScalar(0.5);
    const head = vectorOf(stairs.head_edge).add(vectorOf(stairs.head_edge, 3)).multiplyScalar(0.5);
    const up = head.clone().sub(foot);
    if (up.length() > 0.05) {
      this.group.add(new ArrowHelper(up.clone().normalize(), foot.clone().add(new Vector3(0, 0, 0.12)), up.length(), 0xffffff, 0.16, 0.1));
    }
    // On the way to it, where the words hide no step from above either.
    const before = vectorOf(stairs.direction_up).multiplyScalar(-0.5).add(foot).add(new Vector3(0, 0, 0.05));
    this.group.add(textSprite(dimensionsInWords(stairs), before, { size: 0.024, stacked: true }));
  }

  private clear(): void {
    for (const child of [...this.group.children]) {
      if (child instanceof Sprite) disposeSprite(child);
      if (child instanceof ArrowHelper) child.dispose();
      this.group.remove(child);
    }
  }
}
