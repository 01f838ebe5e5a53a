// SPDX-License-Identifier: BSD-3-Clause
// Cells and points beside the regions, as tools/view_surroundings.h writes them.

/// Cubes in the world: where the world is not planar.
export interface Cubes {
  positions: Float32Array;  // x,y,z,... of their middles [m]
  edges: Float32Array;      // of each [m]
}

const POINT_M = 0.01;  // a point has no size; so large it is drawn

function header(content: Uint8Array): { view: DataView; floats: number[]; at: number } {
  const view = new DataView(content.buffer, content.byteOffset, content.byteLength);
  return { view, floats: [0, 4, 8, 12].map((at) => view.getFloat32(at, true)), at: 16 };
}

export function readCells(content: Uint8Array): Cubes {
  const { view, floats: [leafM, ...low], at } = header(content);
  const count = Math.floor((content.length - at) / 8);
  const positions = new Float32Array(3 * count);
  const edges = new Float32Array(count);
  for (let i = 0; i < count; ++i) {
    const leaves = view.getUint16(at + 8 * i + 6, true);
    edges[i] = leafM * leaves;
    for (let axis = 0; axis < 3; ++axis) {
      positions[3 * i + axis] = low[axis] + leafM * (view.getUint16(at + 8 * i + 2 * axis, true) + 0.5 * leaves);
    }
  }
  return { positions, edges };
}

export function readPoints(content: Uint8Array): Cubes {
  const { view, floats: [x, y, z, unitM], at } = header(content);
  const camera = [x, y, z];
  const count = Math.floor((content.length - at) / 6);
  const positions = new Float32Array(3 * count);
  for (let i = 0; i < 3 * count; ++i) positions[i] = camera[i % 3] + unitM * view.getInt16(at + 2 * i, true);
  return { positions, edges: new Float32Array(count).fill(POINT_M) };
}
