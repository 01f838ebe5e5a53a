// SPDX-License-Identifier: BSD-3-Clause
// The daemon's state in words, figures, and the stages over the last minute.
import { adviceOn, figuresOf } from './advice';
import { drawStages } from './chart';
import { chip, h, table } from './dom';
import { Latencies } from './latency';
import { Model } from './model';
import { STAGE_COLOURS } from './palette';

export interface Connection {
  live: boolean;
  connected: boolean;
  latencies: Latencies;
}

export class StatePanel {
  private readonly chart = h('canvas', { width: '532', height: '140' });
  private figuresShown: object | null = null;
  private readonly words = h('div');
  private readonly figures = h('div', { id: 'figures' });
  private readonly stages = h('div', { class: 'stages' });

  constructor(panel: HTMLElement, private readonly onImage: (utime: number) => void) {
    panel.append(this.words, this.chart, this.stages, this.figures);
  }

  update(model: Model, connection: Connection, counts: string): void {
    const status = model.statuses.at(-1);
    const words: HTMLElement[] = [];
    if (connection.live && !connection.connected) words.push(h('p', { class: 'bad' }, 'No connection to terrace view. Trying again.'));
    const advice = adviceOn(status, model.pose);
    if (advice.length === 0 && model.regions.size === 0 && connection.connected) {
      words.push(h('p', { class: 'warning' }, 'Nothing has been heard from a daemon yet. Compare --url with the daemon\'s lcm.url.'));
    }
    for (const { level, text } of advice) words.push(h('p', { class: level }, text));
    if (!model.inStep) words.push(h('p', { class: 'warning' }, 'The map is out of step and is being asked for again.'));
    if (model.numBad > 0) words.push(h('p', { class: 'bad' }, `${model.numBad} messages could not be read: ${model.lastProblem}.`));
    for (const reply of model.replies.slice(-1)) words.push(h('p', { class: reply.result === 0 ? 'good' : 'bad' }, `Answer: ${reply.message}`));
    const rows: [string, string][] = status ? figuresOf(status) : [];
    if (model.camera) rows.push(['calibration', `rectified ${model.camera.width}×${model.camera.height}, f ${model.camera.fx.toFixed(1)} px`]);
    rows.push(['drawn', counts]);
    const { busMs, imageToPoseMs, imageToMapMs } = connection.latencies;
    if (busMs !== null) rows.push(['bus to screen', `${busMs.toFixed(0)} ms`]);
    if (imageToPoseMs !== null) rows.push(['image to screen', `${imageToPoseMs.toFixed(0)} ms its pose${imageToMapMs === null ? '' : `, ${imageToMapMs.toFixed(0)} ms its map`}`]);
    this.words.replaceChildren(...words, ...(model.figures ? [h('h2', {}, model.figures.title), table(model.figures.rows)] : []), table(rows));
    this.updateStages(model);
    this.updateFigures(model);
  }

  private updateStages(model: Model): void {
    const ink = getComputedStyle(document.documentElement).getPropertyValue('--faint');
    this.chart.hidden = model.statuses.length === 0;
    drawStages(this.chart, model.statuses, ink);
    const rows = model.statuses.at(-1)?.stages.map((s) => ({ name: s.name, p50_ms: s.ms_p50, p99_ms: s.ms_p99 })) ?? model.figures?.stages ?? [];
    this.stages.replaceChildren(...rows.map((s, i) => (
      h('span', { title: `99 %: ${s.p99_ms.toFixed(1)} ms` }, chip(STAGE_COLOURS[i % STAGE_COLOURS.length]), `${s.name} ${s.p50_ms.toFixed(1)} ms`))));
  }

  private updateFigures(model: Model): void {
    if (model.figures === this.figuresShown) return;
    this.figuresShown = model.figures;
    this.figures.replaceChildren(...(model.figures?.images ?? []).map((image) => (
      h('button', { click: () => this.onImage(image.utime), title: 'Go to this moment' },
        h('img', { src: `data:image/jpeg;base64,${image.jpeg}`, alt: image.caption }), h('small', {}, image.caption)))));
  }
}
