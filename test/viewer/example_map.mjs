// SPDX-License-Identifier: BSD-3-Clause
// Maps of known geometry, as terrain_map.json has them.
import { writeFileSync } from 'node:fs';

export const T0_NS = 1_600_000_000_000_000_000n;

/// @param corners  x,y,z each, counter-clockwise seen from where the normal points
export function region(id, label, normal, corners, more = {}) {
  const offset = normal.reduce((sum, n, i) => sum + n * corners[0][i], 0);
  const rings = [corners, ...(more.holes ?? [])];
  return {
    id, revision: 1, label, confidence: 0.9, normal, offset_m: offset, rms_m: 0.002, area_m2: 1, outline: corners, holes: [], staircase: null,
    step_index: null, first_seen_ns: Number(T0_NS), last_seen_ns: Number(T0_NS), predicted: false, why: '',
    edges: rings.map((ring) => ring.map(() => ({ kind: 'limit', step_m: null, sigma_m: null }))), ...more,
  };
}

export function level(id, label, x0, y0, x1, y1, z, more = {}) {
  return region(id, label, [0, 0, 1], [[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]], more);
}

export function writeMap(path, regions, staircases = []) {
  const map = { format: 'terrace-map', version: 1, t_capture_ns: Number(T0_NS), frame: 'world', regions, staircases };
  writeFileSync(path, JSON.stringify(map));
}

/// A floor with a hole in it, a box top over the floor, a wall, a predicted tread, two treads with a riser between.
export function exampleRegions() {
  const hole = [[1.0, 1.0, 0], [1.0, 1.5, 0], [1.5, 1.5, 0], [1.5, 1.0, 0]];
  const floor = level(1, 'walkway', -2, -2, 2, 2, 0, { holes: [hole], area_m2: 15.75 });
  floor.edges[0][0] = { kind: 'drop', step_m: -0.4, sigma_m: 0.01 };
  return [
    floor,
    level(2, 'obstacle', -1, -1, -0.5, -0.5, 0.5, { why: 'stands on the ground' }),
    region(3, 'wall', [-1, 0, 0], [[2, 2, 0], [2, -2, 0], [2, -2, 1.5], [2, 2, 1.5]].reverse()),
    level(4, 'stair_tread', -3, -0.5, -2.7, 0.5, 0.17, { staircase: 1, step_index: 1 }),
    level(5, 'stair_tread', -3.3, -0.5, -3, 0.5, 0.34, { staircase: 1, step_index: 2, predicted: true }),
    region(6, 'stair_riser', [1, 0, 0], [[-3, -0.5, 0.17], [-3, 0.5, 0.17], [-3, 0.5, 0.34], [-3, -0.5, 0.34]], { staircase: 1, step_index: 2 }),
  ];
}

export const EXAMPLE_STAIRCASE = {
  id: 1, num_steps: 2, num_treads: 2, riser_m: 0.17, tread_m: 0.3, width_m: 1.0, direction_world: [-1, 0, 0], base_world: [-2.7, 0, 0],
  confidence: 0.9, region_ids: [4, 5, 6],
};
