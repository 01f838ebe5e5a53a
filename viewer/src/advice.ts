// SPDX-License-Identifier: BSD-3-Clause
// The daemon's state in sentences, with what a person can do about it.
import { PoseMessage, StatusMessage } from './messages';
import { GRAVITY_SOURCES, STATES, TRACKING } from './palette';

export interface Advice {
  level: 'good' | 'warning' | 'bad';
  text: string;
}

// By reason_code of pose_v1_t and status_v1_t.
const WHAT_TO_DO: Record<number, string> = {
  2: 'Check the camera driver and its cable.',
  3: 'Give the camera light and something to see; keep it clear and slower.',
  4: 'Go back to where it was still tracking, or reset the map.',
  5: 'Turn the camera to where things stand still and are not alike.',
  6: 'Start the camera, and compare its channel with the configuration (channels.images).',
  7: 'Publish a calibration, or name one in the configuration (camera.calibration).',
  8: 'Calibrate the cameras again; terrace calibration says what is wrong.',
  9: 'Look at the inputs below: the network or the processor may be too slow.',
};

function whatToDo(code: number): string {
  return WHAT_TO_DO[code] ? ` ${WHAT_TO_DO[code]}` : '';
}

export function adviceOn(status: StatusMessage | undefined, pose: PoseMessage | null): Advice[] {
  const advice: Advice[] = [];
  const tracking = pose?.status ?? status?.tracking;
  if (tracking !== undefined) {
    const reason = pose?.reason || status?.reason || '';
    const code = pose?.reason_code || status?.reason_code || 0;
    const state = status ? `The daemon is ${STATES[status.state] ?? 'in an unknown state'}, ${TRACKING[tracking]}` : `The camera is ${TRACKING[tracking]}`;
    advice.push({
      level: tracking === 2 ? 'bad' : tracking === 1 || reason !== '' || (status && status.state !== 1) ? 'warning' : 'good',
      text: `${state}${reason ? `: ${reason}` : ''}.`.replace('..', '.') + whatToDo(code),
    });
  }
  if (status) advice.push(...onStatus(status));
  return advice;
}

function onStatus(s: StatusMessage): Advice[] {
  const advice: Advice[] = [];
  if (s.gravity_source === 4) {
    advice.push({ level: 'warning', text: 'Up is only assumed, so labels are half believed. Name the camera\'s mounting, or give it an IMU.' });
  }
  if (Math.abs(s.vertical_disparity_px) > 0.5) {
    advice.push({ level: 'warning', text: `The two cameras disagree by ${s.vertical_disparity_px.toFixed(2)} px in height. Calibrate them again soon.` });
  }
  if (s.fps_in > 0 && s.fps_out < 0.8 * s.fps_in) {
    advice.push({ level: 'warning', text: `${(s.fps_in - s.fps_out).toFixed(1)} frames a second are left out. The chart shows which stage takes the time.` });
  }
  for (const [count, text] of [
    [s.n_bad_frames, 'unreadable frames'], [s.n_decode_errors, 'unreadable messages'], [s.n_time_jumps, 'jumps of time'],
    [s.n_imu_gaps, 'gaps in the IMU\'s readings'], [s.n_lost, 'frames without a pose'],
  ] as const) {
    if (count > 0) advice.push({ level: 'warning', text: `${count} ${text} since the start.` });
  }
  return advice;
}

export function figuresOf(s: StatusMessage): [string, string][] {
  return [
    ['frames', `${s.fps_out.toFixed(1)} of ${s.fps_in.toFixed(1)} /s`],
    ['image to map', `${s.age_p50_ms.toFixed(0)} ms (99 %: ${s.age_p99_ms.toFixed(0)})`],
    ['up from', GRAVITY_SOURCES[s.gravity_source] ?? 'unknown'],
    ['pair', `${s.vertical_disparity_px.toFixed(2)} px apart in height`],
    ['pixels with depth', `${(100 * s.dense_ratio).toFixed(0)} %`],
    ['matches kept', `${s.vo_inliers} (${s.vo_rms_px.toFixed(2)} px)`],
    ['regions', `${s.n_regions}`],
    ['memory', `${(s.rss_bytes / 1e6).toFixed(0)} MB, map ${(s.map_bytes / 1e6).toFixed(1)} MB`],
    ['processor', `${s.cpu.toFixed(1)} cores`],
    ['version', s.version],
  ];
}
