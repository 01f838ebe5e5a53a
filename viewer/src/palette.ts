// SPDX-License-Identifier: BSD-3-Clause
// Words and colours. The colours are those of Okabe and Ito ("Color Universal Design", 2008), which people with any kind
// of colour blindness tell apart; vermilion is kept for drops.

export const LABELS = ['unknown', 'walkway', 'ramp', 'stair tread', 'stair riser', 'wall', 'obstacle', 'level'];
export const LABEL_COLOURS = ['#8f8f8f', '#009e73', '#f0e442', '#56b4e9', '#0072b2', '#c9c3b8', '#cc79a7', '#e69f00'];
export const EDGE_KINDS = ['limit of view', 'drop', 'rise', 'joins'];
export const EDGE_COLOURS = ['#6b6b6b', '#d55e00', '#1f2d5a', '#ffffff'];
export const TRUTH_COLOUR = '#7a00cc';
export const DROP = 1;
export const RISE = 2;
export const SOURCES = ['seen', 'predicted', 'felt by the feet'];
export const STATES = ['starting', 'running', 'degraded', 'paused', 'without input', 'without calibration', 'stopping'];
export const TRACKING = ['tracking', 'bridging', 'lost'];
export const TRACKING_COLOURS = ['#0072b2', '#e69f00', '#d55e00'];
export const GRAVITY_SOURCES = ['the IMU', 'the body attitude', 'the camera mounting', 'the floor', 'an assumption'];
export const STAGE_COLOURS = ['#999999', '#f0e442', '#56b4e9', '#0072b2', '#009e73', '#cc79a7', '#e69f00', '#d55e00', '#4a4a4a'];

export type Colour = [number, number, number];  // 0..255

export function colourOf(hex: string): Colour {
  return [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16)) as Colour;
}

// Viridis at nine places (Smith and van der Walt, 2015): even to the eye, also in grey.
const VIRIDIS = ['#440154', '#472d7b', '#3b528b', '#2c728e', '#21918c', '#28ae80', '#5ec962', '#addc30', '#fde725'].map(colourOf);

/// @param share  0..1
export function viridis(share: number): Colour {
  const at = Math.min(1, Math.max(0, share)) * (VIRIDIS.length - 1);
  const low = Math.min(VIRIDIS.length - 2, Math.floor(at));
  const part = at - low;
  return VIRIDIS[low].map((value, i) => value + part * (VIRIDIS[low + 1][i] - value)) as Colour;
}
