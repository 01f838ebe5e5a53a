// SPDX-License-Identifier: BSD-3-Clause
// What the robot believes, as far as the records that came tell: the map, the path, the daemon's state. Knows nothing of
// how it is drawn.
import {
  DELTA, decodePlan, decodePose, decodeReply, decodeStatus, decodeTerrain, FootstepPlanMessage, LOST, PoseMessage, ReplyMessage,
  SNAPSHOT, StaircaseMessage, StatusMessage, TerrainMessage,
} from './messages';
import { jsonOf, StreamRecord } from './records';
import { Region } from './region';
import { Cubes, readCells, readPoints } from './surroundings';
import { compose, inverse, Pose, poseOf } from './space';

export interface Hello {
  source: 'live' | 'log' | 'result' | 'map' | 'report';
  name: string;
  version: string;
  control: boolean;
}

export interface CameraInfo {
  width: number;
  height: number;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
}

export interface Figures {
  title: string;
  rows: [string, string][];
  stages: { name: string; p50_ms: number; p99_ms: number; cpu_ms: number }[];
  images: { caption: string; utime: number; jpeg: string }[];
}

export interface PathPoint {
  utime: number;
  body: Pose;
  message: PoseMessage;
}

export interface Picture {
  utime: number;
  jpeg: Uint8Array;
}

/// Disparity as a picture, and what its colours run between.
export interface DisparityPicture extends Picture {
  leastPx: number;
  greatestPx: number;
}

const STATUS_SECONDS = 60;

export class Model {
  hello: Hello | null = null;
  figures: Figures | null = null;
  camera: CameraInfo | null = null;
  regions = new Map<number, Region>();
  staircases = new Map<number, StaircaseMessage>();
  terrain: TerrainMessage | null = null;  // the newest one's head
  path: PathPoint[] = [];
  pose: PoseMessage | null = null;
  statuses: StatusMessage[] = [];  // of the last minute, oldest first
  replies: ReplyMessage[] = [];
  picture: Picture | null = null;
  disparity: DisparityPicture | null = null;
  cells: Cubes | null = null;   // of the octree, beside the regions
  points: Cubes | null = null;  // of a disparity image, beside the regions
  plan: FootstepPlanMessage | null = null;
  truth: Region[] = [];                // true surfaces, in the world of the result
  trueWay: Float32Array | null = null;  // x,y,z,... of the left camera
  inStep = true;
  numBad = 0;
  lastProblem = '';
  /// Regions that came, changed or went since whoever draws has asked last.
  readonly touched = new Set<number>();
  private T_body_left: Pose | null = null;

  /// Bytes that are no message are counted and change nothing.
  apply(record: StreamRecord): void {
    try {
      this.take(record);
    } catch (error) {
      this.numBad += 1;
      this.lastProblem = error instanceof Error ? error.message : String(error);
    }
  }

  /// Everything that records told, but who is speaking.
  clear(): void {
    this.clearMap();
    this.terrain = null;
    this.path = [];
    this.pose = null;
    this.statuses = [];
    this.replies = [];
    this.picture = null;
    this.disparity = null;
    this.plan = null;
    this.forgetSurroundings();
  }

  /// The left camera in the world, newest first known of; before any terrain the body's place stands for it.
  cameraPose(): Pose | null {
    const last = this.path.at(-1);
    if (last && this.T_body_left && this.pose?.status !== LOST) return compose(last.body, this.T_body_left);
    return this.terrain ? poseOf(this.terrain.sensor_pos, this.terrain.sensor_quat) : last?.body ?? null;
  }

  cameraPoseAt(point: PathPoint): Pose {
    return this.T_body_left ? compose(point.body, this.T_body_left) : point.body;
  }

  private take(record: StreamRecord): void {
    switch (record.kind) {
      case 'H': this.hello = jsonOf<Hello>(record); break;
      case 'F': this.figures = jsonOf<Figures>(record); break;
      case 'C': this.camera = jsonOf<CameraInfo>(record); break;
      case 'T': this.takeTerrain(decodeTerrain(record.content)); break;
      case 'P': this.takePose(decodePose(record.content)); break;
      case 'S': this.takeStatus(decodeStatus(record.content)); break;
      case 'R': this.replies = [...this.replies, decodeReply(record.content)].slice(-5); break;
      case 'I': this.picture = { utime: record.utime, jpeg: record.content }; break;
      case 'D': this.disparity = disparityOf(record); break;
      case 'V': this.cells = readCells(record.content); break;
      case 'N': this.points = readPoints(record.content); break;
      case 'G': this.plan = decodePlan(record.content); break;
      case 'U': this.truth = decodeTerrain(record.content).regions.map((r) => new Region(r)); break;
      case 'W': this.trueWay = new Float32Array(record.content.slice().buffer); break;
      default: throw new Error(`a record of unknown kind ${record.kind as string}`);
    }
  }

  private takeTerrain(message: TerrainMessage): void {
    if (message.kind === DELTA) {
      const fits = this.terrain && this.terrain.map_id === message.map_id && this.terrain.seq === message.base_seq;
      this.inStep = Boolean(fits);
      if (!fits) return;
      for (const id of message.removed_ids) this.drop(id);
      for (const id of message.removed_staircase_ids) this.staircases.delete(id);
    } else if (message.kind === SNAPSHOT) {
      this.inStep = true;
      this.dropAllBut(new Set(message.regions.map((r) => r.id)), message.map_id);
      this.staircases.clear();
    } else {
      this.seeAgain(message);
    }
    for (const r of message.regions) this.put(new Region(r));
    for (const stairs of message.staircases) this.staircases.set(stairs.id, stairs);
    this.terrain = message;
    const left = poseOf(message.sensor_pos, message.sensor_quat);
    const body = poseOf(message.body_pos, message.body_quat);
    if (left && body) this.T_body_left = compose(inverse(body), left);
  }

  private put(region: Region): void {
    const old = this.regions.get(region.id);
    this.regions.set(region.id, region);
    if (!old || old.message.revision !== region.message.revision) this.touched.add(region.id);
  }

  private drop(id: number): void {
    this.regions.delete(id);
    this.touched.add(id);
  }

  private dropAllBut(kept: Set<number>, mapId: number): void {
    const other = this.terrain !== null && this.terrain.map_id !== mapId;
    for (const id of [...this.regions.keys()]) {
      if (other || !kept.has(id)) this.drop(id);
    }
    // What was in another world is nowhere in this one.
    if (other) this.forgetSurroundings();
  }

  private forgetSurroundings(): void {
    this.cells = null;
    this.points = null;
  }

  private clearMap(): void {
    for (const id of this.regions.keys()) this.touched.add(id);
    this.regions.clear();
    this.staircases.clear();
  }

  private seeAgain(message: TerrainMessage): void {
    message.seen_ids.forEach((id, i) => {
      const region = this.regions.get(id);
      if (region) region.lastUtime = message.utime - 1000 * message.seen_age_ms[i];
    });
  }

  private takePose(message: PoseMessage): void {
    if (this.pose && this.pose.epoch !== message.epoch) this.path = [];
    // A source that begins again, as a replay does, has a path of its own.
    if (this.path.length > 0 && message.utime < this.path[this.path.length - 1].utime) this.path = [];
    this.pose = message;
    const body = poseOf(message.pos, message.quat);
    if (body) this.path.push({ utime: message.utime, body, message });
  }

  private takeStatus(message: StatusMessage): void {
    const since = message.utime - 1e6 * STATUS_SECONDS;
    this.statuses = [...this.statuses.filter((s) => s.utime >= since && s.utime < message.utime), message];
  }
}

function disparityOf(record: StreamRecord): DisparityPicture {
  const view = new DataView(record.content.buffer, record.content.byteOffset, record.content.byteLength);
  return { utime: record.utime, leastPx: view.getFloat32(0, true), greatestPx: view.getFloat32(4, true), jpeg: record.content.subarray(8) };
}
