// SPDX-License-Identifier: BSD-3-Clause
// All that is known about one region.
import { h, table } from './dom';
import { Model } from './model';
import { EDGE_KINDS, LABELS, SOURCES } from './palette';
import { Region } from './region';
import { dimensionsInWords } from './staircases';

const DEGREES = 180 / Math.PI;

function edgesInWords(region: Region): [string, string][] {
  const rows: [string, string][] = [];
  EDGE_KINDS.forEach((name, kind) => {
    let length = 0;
    const steps: number[] = [];
    region.rings.forEach((ring, r) => region.edges[r].forEach((edge, i) => {
      if (edge.kind !== kind) return;
      const j = (i + 1) % (ring.length / 2);
      length += Math.hypot(ring[2 * j] - ring[2 * i], ring[2 * j + 1] - ring[2 * i + 1]);
      if (Number.isFinite(edge.stepM)) steps.push(edge.stepM);
    }));
    if (length === 0) return;
    const [least, most] = [Math.min(...steps).toFixed(3), Math.max(...steps).toFixed(3)];
    const range = steps.length === 0 ? '' : `, by ${least === most ? most : `${least} to ${most}`} m`;
    rows.push([name, `${length.toFixed(2)} m${range}`]);
  });
  return rows;
}

export function detailRows(region: Region, model: Model): [string, string][] {
  const m = region.message;
  const n = region.normal;
  const age = ((model.terrain?.utime ?? region.lastUtime) - region.lastUtime) * 1e-6;
  const rows: [string, string][] = [
    ['label', `${LABELS[m.label] ?? 'unknown'} (${(100 * m.confidence).toFixed(0)} % sure)`],
  ];
  if (m.why !== '') rows.push(['why', m.why]);
  rows.push(
    ['known by', SOURCES[m.source] ?? 'unknown'],
    ['middle', region.origin.toArray().map((v) => v.toFixed(3)).join(', ') + ' m'],
    ['normal', n.toArray().map((v) => v.toFixed(3)).join(', ')],
    ['offset', `${n.dot(region.origin).toFixed(4)} m`],
    ['slope', `${(m.slope * DEGREES).toFixed(1)}°`],
    ['plane', region.sigmaM === null ? 'how sure is not known' : `±${(1e3 * region.sigmaM).toFixed(1)} mm, ±${(Math.sqrt(Math.max(m.plane_cov[0], m.plane_cov[3])) * DEGREES).toFixed(2)}°`],
    ['flatness', `${(1e3 * m.rms).toFixed(1)} mm rms`],
    ['area', `${m.area.toFixed(3)} m²${m.n_obs > 0 ? `, ${(100 * m.support).toFixed(0)} % observed` : ''}`],
    ['last seen', age < 0.05 ? 'now' : `${age.toFixed(1)} s ago`],
    ['seen', `${m.n_obs > 0 ? `${m.n_obs} times ` : ''}over ${((region.lastUtime - m.first_utime) * 1e-6).toFixed(1)} s`],
    ['outline', `${region.rings[0].length / 2} corners, ${region.rings.length - 1} holes`],
  );
  const stairs = model.staircases.get(m.staircase_id);
  if (m.staircase_id !== 0) rows.push(['staircase', `${m.staircase_id}, step ${m.step_index}${stairs ? `: ${dimensionsInWords(stairs)}` : ''}`]);
  return [...rows, ...edgesInWords(region)];
}

export function detailsOf(region: Region, model: Model, close: () => void): HTMLElement[] {
  return [
    h('h2', {}, `Region ${region.id}, revision ${region.message.revision} `, h('button', { click: close, title: 'Esc' }, 'close')),
    table(detailRows(region, model)),
  ];
}
