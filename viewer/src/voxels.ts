// SPDX-License-Identifier: BSD-3-Clause
// Occupied cells where the world is not planar, as squares of the cells' size. Too many for a smooth picture are thinned, the
// far ones first, and the page says how many it draws.
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
  private made: Voxels | null = null;

  constructor() {
    this.points.frustumCulled = false;
  }

  update(voxels: Voxels | null, near: Vector3): void {
    if (voxels === this.made) return;
    this.made = voxels;
    const positions = voxels ? thinned(voxels.positions, near) : new Float32Array();
    this.numThere = (voxels?.positions.length ?? 0) / 3;
    this.numDrawn = positions.length / 3;
    this.points.geometry.dispose();
    this.points.geometry.setAttribute('position', new BufferAttribute(positions, 3));
    this.uniform('sizeM', voxels?.sizeM ?? 0.05);
  }

  setPixelsPerRad(pixels: number): void {
    this.uniform('pixelsPerRad', pixels);
  }

  private uniform(name: string, value: number): void {
    (this.points.material as ShaderMaterial).uniforms[name].value = value;
  }
}

/// The nearest MAX_DRAWN.
function thinned(positions: Float32Array, near: Vector3): Float32Array {
  const n = positions.length / 3;
  if (n <= MAX_DRAWN) return positions;
  const squares = new Float32Array(n);
  for (let i = 0; i < n; ++i) {
    squares[i] = (positions[3 * i] - near.x) ** 2 + (positions[3 * i + 1] - near.y) ** 2 + (positions[3 * i + 2] - near.z) ** 2;
  }
  const limit = squares.slice().sort()[MAX_DRAWN];
  const kept: number[] = [];
  for (let i = 0; i < n && kept.length < 3 * MAX_DRAWN; ++i) {
    if (squares[i] < limit) kept.push(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]);
  }
  return new Float32Array(kept);
}
