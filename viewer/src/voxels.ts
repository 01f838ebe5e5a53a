// SPDX-License-Identifier: BSD-3-Clause
// Occupied cells where the world is not planar, as squares of the cells' size. Where they are too many for a smooth picture,
// those far away are thinned, and the page says how many it draws.
import { BufferAttribute, BufferGeometry, Points, ShaderMaterial, Vector3 } from 'three';
import { Voxels } from './model';

const MAX_DRAWN = 200000;

const VERTEX = `
uniform float sizeM;
uniform float pixelsPerRad;
varying float shade;
void main() {
  vec4 p = modelViewMatrix * vec4(position, 1.0);
  gl_Position = projectionMatrix * p;
  gl_PointSize = max(1.0, projectionMatrix[2][3] < -0.5 ? sizeM * pixelsPerRad / max(0.05, -p.z) : sizeM * pixelsPerRad * projectionMatrix[1][1]);
  shade = 0.75 + 0.25 * sin(position.z * 9.0);
}`;
const FRAGMENT = `
varying float shade;
void main() { gl_FragColor = vec4(shade * vec3(0.62, 0.55, 0.72), 1.0); }`;

export class VoxelCloud {
  readonly points = new Points(new BufferGeometry(), new ShaderMaterial({
    vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: { sizeM: { value: 0.05 }, pixelsPerRad: { value: 600 } },
  }));
  numDrawn = 0;
  numThere = 0;
  private numKept = 0;
  private made: Voxels | null = null;

  constructor() {
    this.points.frustumCulled = false;
  }

  update(voxels: Voxels | null, near: Vector3): void {
    if (voxels === this.made) return;
    this.made = voxels;
    const positions = voxels ? nearFirst(voxels.positions, near) : new Float32Array();
    this.numThere = (voxels?.positions.length ?? 0) / 3;
    this.numKept = positions.length / 3;
    this.points.geometry.dispose();
    this.points.geometry.setAttribute('position', new BufferAttribute(positions, 3));
    this.uniform('sizeM', voxels?.sizeM ?? 0.05);
    this.draw(1);
  }

  /// Draws a share of them: near the robot nearly all, far away few.
  draw(share: number): void {
    this.numDrawn = Math.round(share * this.numKept);
    this.points.geometry.setDrawRange(0, this.numDrawn);
  }

  setPixelsPerRad(pixels: number): void {
    this.uniform('pixelsPerRad', pixels);
  }

  private uniform(name: string, value: number): void {
    (this.points.material as ShaderMaterial).uniforms[name].value = value;
  }
}

/// At most MAX_DRAWN, so ordered that any beginning of them is dense near by and thin far away.
function nearFirst(positions: Float32Array, near: Vector3): Float32Array {
  const n = positions.length / 3;
  const keys = new Float64Array(n);
  for (let i = 0; i < n; ++i) {
    const square = (positions[3 * i] - near.x) ** 2 + (positions[3 * i + 1] - near.y) ** 2 + (positions[3 * i + 2] - near.z) ** 2;
    // Fractions of multiples of the golden ratio are spread evenly, and the same each time.
    keys[i] = square * ((i * 0.6180339887498949) % 1);
  }
  const order = Uint32Array.from({ length: n }, (_, i) => i).sort((a, b) => keys[a] - keys[b]);
  const ordered = new Float32Array(3 * Math.min(n, MAX_DRAWN));
  for (let i = 0; 3 * i < ordered.length; ++i) ordered.set(positions.subarray(3 * order[i], 3 * order[i] + 3), 3 * i);
  return ordered;
}
