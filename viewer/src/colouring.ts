// SPDX-License-Identifier: BSD-3-Clause
// What colour a region has in each mode, and what the legend says.
import { Colour, colourOf, LABEL_COLOURS, LABELS, viridis } from './palette';
import { Region } from './region';

export const MODES = ['label', 'sigma', 'age', 'height', 'seen'] as const;
export type Mode = (typeof MODES)[number];

// Ends of the scales: beyond them a planner need not tell apart.
const SIGMA_MIN_M = 0.0003;
const SIGMA_MAX_M = 0.03;
const AGE_MAX_S = 60;

const LABEL = LABEL_COLOURS.map(colourOf);
const SEEN: Colour[] = [colourOf('#56b4e9'), colourOf('#e69f00'), colourOf('#009e73')];

const NOT_KNOWN = LABEL[0];

function ofSigma(sigmaM: number): Colour {
  return viridis(Math.log(sigmaM / SIGMA_MIN_M) / Math.log(SIGMA_MAX_M / SIGMA_MIN_M));
}

export interface Scale {
  nowUtime: number;
  lowM: number;   // heights between which the colours run
  highM: number;
}

export function colourFor(mode: Mode, region: Region, heightM: number, scale: Scale): Colour {
  switch (mode) {
    case 'label': return LABEL[region.label] ?? LABEL[0];
    case 'sigma': return region.sigmaM === null ? NOT_KNOWN : ofSigma(region.sigmaM);
    case 'age': return viridis(1 - (scale.nowUtime - region.lastUtime) * 1e-6 / AGE_MAX_S);
    case 'height': return viridis((heightM - scale.lowM) / Math.max(0.01, scale.highM - scale.lowM));
    case 'seen': return SEEN[region.message.source] ?? SEEN[0];
  }
}

export interface LegendEntry {
  colour: Colour;
  text: string;
}

export function legendOf(mode: Mode, scale: Scale, regions: Iterable<Region>): LegendEntry[] {
  switch (mode) {
    case 'label': {
      const areas = new Map<number, [number, number]>();
      for (const region of regions) {
        const [count, area] = areas.get(region.label) ?? [0, 0];
        areas.set(region.label, [count + 1, area + region.message.area]);
      }
      return [...areas].sort(([a], [b]) => a - b).map(([label, [count, area]]) => (
        { colour: LABEL[label] ?? LABEL[0], text: `${LABELS[label] ?? 'unknown'}: ${count}, ${area.toFixed(1)} m²` }));
    }
    case 'sigma': return [...[0.3, 1, 3, 10, 30].map((mm) => ({ colour: ofSigma(1e-3 * mm), text: `±${mm} mm` })), { colour: NOT_KNOWN, text: 'not known' }];
    case 'age': return [0, 15, 30, 60].map((s) => (
      { colour: viridis(1 - s / AGE_MAX_S), text: s === 60 ? 'a minute ago or more' : s === 0 ? 'seen now' : `${s} s ago` }));
    case 'height': return [0, 0.25, 0.5, 0.75, 1].map((share) => (
      { colour: viridis(share), text: `${(scale.lowM + share * (scale.highM - scale.lowM)).toFixed(2)} m` }));
    case 'seen': return ['seen', 'predicted', 'felt by the feet'].map((text, i) => ({ colour: SEEN[i], text }));
  }
}
