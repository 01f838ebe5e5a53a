// SPDX-License-Identifier: BSD-3-Clause
// What the page uses of the daemon's messages. Names and units are those of lcmtypes/*.lcm; 64-bit times in microseconds
// and ids are exact as numbers.
import { LcmTypes } from './lcm';

const files = import.meta.glob('../../lcmtypes/*.lcm', { query: '?raw', import: 'default', eager: true });
const types = new LcmTypes(Object.values(files) as string[]);

export interface RegionMessage {
  id: number;
  revision: number;
  source: number;
  label: number;
  confidence: number;
  why: string;
  first_utime: number;
  last_utime: number;
  n_obs: number;
  origin: number[];
  quat: number[];
  plane_cov: number[];
  area: number;
  rms: number;
  slope: number;
  support: number;
  staircase_id: number;
  step_index: number;
  piece: number;
  n_pieces: number;
  ring_size: number[];
  coords: number[];
  edge_kind: number[];
  edge_step: number[];
  edge_sigma: number[];
}

export interface StaircaseMessage {
  id: number;
  last_utime: number;
  n_risers: number;
  n_treads: number;
  riser: number;
  riser_sigma: number;
  tread: number;
  tread_sigma: number;
  width: number;
  foot_edge: number[];
  head_edge: number[];
  direction_up: number[];
  turn_per_step: number;
  pitch: number;
  confidence: number;
}

export interface TerrainMessage {
  utime: number;
  map_id: number;
  seq: number;
  epoch: number;
  sensor_pos: number[];
  sensor_quat: number[];
  body_pos: number[];
  body_quat: number[];
  sensor_cov: number[];
  gravity: number[];
  gravity_sigma: number;
  gravity_source: number;
  kind: number;
  base_seq: number;
  removed_ids: number[];
  removed_staircase_ids: number[];
  regions: RegionMessage[];
  staircases: StaircaseMessage[];
  seen_ids: number[];
  seen_age_ms: number[];
}

export interface PoseMessage {
  utime: number;
  map_id: number;
  epoch: number;
  status: number;
  reason_code: number;
  reason: string;
  pos: number[];
  quat: number[];
  cov: number[];
  has_velocity: boolean;
  vel: number[];
}

export interface StageMessage {
  name: string;
  n_in: number;
  n_out: number;
  n_dropped: number;
  queue_depth: number;
  ms_last: number;
  ms_p50: number;
  ms_p99: number;
  ms_max: number;
}

export interface InputMessage {
  name: string;
  channel: string;
  n_messages: number;
  n_bad: number;
  rate: number;
  age_ms: number;
}

export interface StatusMessage {
  utime: number;
  version: string;
  uptime_ms: number;
  state: number;
  source: number;
  tracking: number;
  gravity_source: number;
  reason: string;
  reason_code: number;
  fps_in: number;
  fps_out: number;
  age_p50_ms: number;
  age_p99_ms: number;
  age_max_ms: number;
  n_deadline_missed: number;
  n_bad_frames: number;
  n_time_jumps: number;
  n_decode_errors: number;
  n_imu_gaps: number;
  n_lost: number;
  vo_inliers: number;
  vo_rms_px: number;
  dense_ratio: number;
  vertical_disparity_px: number;
  octree_nodes: number;
  n_regions: number;
  map_bytes: number;
  rss_bytes: number;
  cpu: number;
  inputs: InputMessage[];
  stages: StageMessage[];
}

export interface ReplyMessage {
  utime: number;
  request_id: number;
  result: number;
  message: string;
}

export interface FootstepPlanMessage {
  utime: number;
  map_id: number;
  foot_radius: number;
  n_steps: number;
  side: number[];
  pos: number[][];
  normal: number[][];
  heading: number[];
  gait: number[];
}

export const SNAPSHOT = 0;
export const DELTA = 1;
export const LOST = 2;
export const PREDICTED = 1;
export const CLIMB = 1;
export const RIGHT = 1;

function decoder<T>(name: string): (bytes: Uint8Array) => T {
  return (bytes) => types.decode(name, bytes) as unknown as T;
}

export const decodeTerrain = decoder<TerrainMessage>('terrain_v1_t');
export const decodePose = decoder<PoseMessage>('pose_v1_t');
export const decodeStatus = decoder<StatusMessage>('status_v1_t');
export const decodePlan = decoder<FootstepPlanMessage>('footstep_plan_v1_t');
export const decodeReply = decoder<ReplyMessage>('command_reply_v1_t');
