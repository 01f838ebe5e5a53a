// SPDX-License-Identifier: BSD-3-Clause
// Cells or points where the world is not planar, as squares of their size. Where they are too many for a smooth picture,
// those far away are thinned, and the page says how many it draws.
import { BufferAttribute, BufferGeometry, Points, ShaderMaterial, Vector3 } from 'three';
import { colourOf } from './palette';
import { Cubes } from './surroundings';

const MAX_DRAWN = 200000;
const FEW = 5000;  // cost nothing worth saving

const VERTEX = `
attribute float edgeM;
uniform float pixelsPerRad;
varying float shade;
void main() {
  vec4 p = modelViewMatrix * vec4(position, 1.0);
  gl_Position = projectionMatrix * p;
  gl_PointSize = max(1.0, projectionMatrix[2][3] < -0.5 ? edgeM * pixelsPerRad / max(0.05, -p.z) : edgeM * pixelsPerRad * projectionMatrix[1][1]);
  shade = 0.75 + 0.25 * sin(position.z * 9.0);
}`;
const FRAGMENT = `
uniform vec3 colour;
varying float shade;
void main() { gl_FragColor = vec4(shade * colour, 1.0); }`;

export class VoxelCloud {
  readonly points: Points;
  numDrawn = 0;
  numThere = 0;
  private numKept = 0;
  private made: Cubes | null = null;

  constructor(colour: string) {
    this.points = new Points(new BufferGeometry(), new ShaderMaterial({
      vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: { pixelsPerRad: { value: 600 }, colour: { value: colourOf(colour).map((v) => v / 255) } },
    }));
    this.points.frustumCulled = false;
  }

  update(cubes: Cubes | null, near: Vector3): void {
    if (cubes === this.made) return;
    this.made = cubes;
    const order = cubes ? nearFirst(cubes.positions, near) : new Uint32Array();
    const positions = new Float32Array(3 * order.length);
    const edges = new Float32Array(order.length);
    order.forEach((from, to) => {
      positions.set(cubes!.positions.subarray(3 * from, 3 * from + 3), 3 * to);
      edges[to] = cubes!.edges[from];
    });
    this.numThere = cubes?.edges.length ?? 0;
    this.numKept = order.length;
    this.points.geometry.dispose();
    this.points.geometry.setAttribute('position', new BufferAttribute(positions, 3));
    this.points.geometry.setAttribute('edgeM', new BufferAttribute(edges, 1));
    this.draw(1);
  }

  /// Draws a share of them: near the robot nearly all, far away few.
  draw(share: number): void {
    this.numDrawn = Math.min(this.numKept, Math.max(FEW, Math.round(share * this.numKept)));
    this.points.geometry.setDrawRange(0, this.numDrawn);
  }

  setPixelsPerRad(pixels: number): void {
    (this.points.material as ShaderMaterial).uniforms.pixelsPerRad.value = pixels;
  }
}

/// At most MAX_DRAWN, so ordered that any beginning of them is dense near by and thin far away.
function nearFirst(positions: Float32Array, near: Vector3): Uint32Array {
  const n = positions.length / 3;
  const keys = new Float64Array(n);
  for (let i = 0; i < n; ++i) {
    const square = (positions[3 * i] - near.x) ** 2 + (positions[3 * i + 1] - near.y) ** 2 + (positions[3 * i + 2] - near.z) ** 2;
    // Fractions of multiples of the golden ratio are spread evenly, and the same each time.
    keys[i] = square * ((i * 0.6180339887498949) % 1);
  }
  return Uint32Array.from({ length: n }, (_, i) => i).sort((a, b) => keys[a] - keys[b]).subarray(0, MAX_DRAWN);
}
