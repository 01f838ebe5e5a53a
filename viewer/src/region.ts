// SPDX-License-Identifier: BSD-3-Clause
// One planar piece of terrain, as the page draws and asks it.
import { Quaternion, Vector3 } from 'three';
import { PREDICTED, RegionMessage } from './messages';
import { vectorOf } from './space';

export interface RegionEdge {
  kind: number;
  stepM: number;   // NaN: not known
  sigmaM: number;  // NaN: not known
}

export class Region {
  readonly id: number;
  readonly origin: Vector3;
  readonly rotation: Quaternion;  // plane to world
  readonly normal: Vector3;
  readonly rings: Float32Array[];  // x0,y0,x1,y1,... in the plane; outline first
  readonly edges: RegionEdge[][];  // one list a ring
  lastUtime: number;

  constructor(readonly message: RegionMessage) {
    this.id = message.id;
    this.lastUtime = message.last_utime;
    this.origin = vectorOf(message.origin);
    const [w, x, y, z] = message.quat;
    this.rotation = new Quaternion(x, y, z, w).normalize();
    this.normal = new Vector3(0, 0, 1).applyQuaternion(this.rotation);
    this.rings = [];
    this.edges = [];
    let vertex = 0;
    for (const size of message.ring_size) {
      this.rings.push(Float32Array.from(message.coords.slice(2 * vertex, 2 * (vertex + size))));
      const edges: RegionEdge[] = [];
      for (let i = vertex; i < vertex + size; ++i) {
        edges.push({ kind: message.edge_kind[i], stepM: message.edge_step[i], sigmaM: message.edge_sigma[i] });
      }
      this.edges.push(edges);
      vertex += size;
    }
  }

  get label(): number {
    return this.message.label;
  }

  get predicted(): boolean {
    return this.message.source === PREDICTED;
  }

  /// Standard deviation of the plane along its normal, at its middle [m]; none where it is not known, as of maps from a file.
  get sigmaM(): number | null {
    const variance = this.message.plane_cov[5];
    return variance > 0 ? Math.sqrt(variance) : null;
  }

  toWorld(x: number, y: number, above = 0, into = new Vector3()): Vector3 {
    return into.set(x, y, above).applyQuaternion(this.rotation).add(this.origin);
  }

  /// Where a ray meets the region: the distance along `direction` (unit); none when it passes by.
  hit(from: Vector3, direction: Vector3): number | null {
    const slant = this.normal.dot(direction);
    if (Math.abs(slant) < 1e-6) return null;
    const distance = this.normal.dot(this.origin.clone().sub(from)) / slant;
    if (distance <= 0) return null;
    const inverse = this.rotation.clone().invert();
    const p = direction.clone().multiplyScalar(distance).add(from).sub(this.origin).applyQuaternion(inverse);
    return this.holds(p.x, p.y) ? distance : null;
  }

  /// Even-odd over all rings: a hole is not part of the region.
  holds(x: number, y: number): boolean {
    let inside = false;
    for (const ring of this.rings) {
      const n = ring.length / 2;
      for (let i = 0, j = n - 1; i < n; j = i++) {
        const [xi, yi, xj, yj] = [ring[2 * i], ring[2 * i + 1], ring[2 * j], ring[2 * j + 1]];
        if (yi > y !== yj > y && x < ((xj - xi) * (y - yi)) / (yj - yi) + xi) inside = !inside;
      }
    }
    return inside;
  }
}
