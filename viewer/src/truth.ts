// SPDX-License-Identifier: BSD-3-Clause
// What was true, where a report knows it: outlines of the true surfaces and the true way over the result, and on request
// the surfaces themselves in the colours of their labels.
import { BufferAttribute, BufferGeometry, Group, Line, LineBasicMaterial } from 'three';
import { Model } from './model';
import { colourOf, TRUTH_COLOUR } from './palette';
import { Region } from './region';
import { Surfaces } from './surfaces';

export class Truth {
  readonly surfaces = new Surfaces(colourOf(TRUTH_COLOUR));
  readonly way = new Line(new BufferGeometry(), new LineBasicMaterial({ color: TRUTH_COLOUR }));
  readonly group = new Group();
  private made: { truth: Region[]; way: Float32Array | null } = { truth: [], way: null };

  constructor() {
    this.way.frustumCulled = false;
    this.surfaces.show('fill', false);
    this.surfaces.show('bands', false);
    this.group.add(this.surfaces.group, this.way);
  }

  update(model: Model): void {
    if (model.truth !== this.made.truth) {
      const regions = new Map(model.truth.map((region) => [region.id, region]));
      this.surfaces.update(regions, new Set([...regions.keys(), ...this.made.truth.map((region) => region.id)]));
    }
    if (model.trueWay !== this.made.way) {
      this.way.geometry.dispose();
      this.way.geometry.setAttribute('position', new BufferAttribute(model.trueWay ?? new Float32Array(), 3));
    }
    this.made = { truth: model.truth, way: model.trueWay };
  }

  showOutlines(on: boolean): void {
    this.surfaces.show('lines', on);
    this.way.visible = on;
  }
}
