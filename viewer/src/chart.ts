// SPDX-License-Identifier: BSD-3-Clause
// What each stage took over the last minute, stacked.
import { StatusMessage } from './messages';
import { STAGE_COLOURS } from './palette';

const SECONDS = 60;

export function drawStages(canvas: HTMLCanvasElement, statuses: StatusMessage[], ink: string): void {
  const context = canvas.getContext('2d')!;
  const [width, height] = [canvas.width, canvas.height];
  context.clearRect(0, 0, width, height);
  const last = statuses.at(-1);
  if (!last) return;
  const sums = statuses.map((s) => s.stages.reduce((sum, stage) => sum + stage.ms_p50, 0));
  const top = Math.max(10, ...sums) * 1.1;
  const x = (utime: number) => width * (1 - (last.utime - utime) * 1e-6 / SECONDS);
  const y = (ms: number) => height * (1 - ms / top);
  const base = statuses.map(() => 0);
  last.stages.forEach((stage, index) => {
    context.fillStyle = STAGE_COLOURS[index % STAGE_COLOURS.length];
    const upper = statuses.map((s, i) => base[i] + (s.stages.find((other) => other.name === stage.name)?.ms_p50 ?? 0));
    context.beginPath();
    statuses.forEach((s, i) => context.lineTo(x(s.utime), y(upper[i])));
    for (let i = statuses.length - 1; i >= 0; --i) context.lineTo(x(statuses[i].utime), y(base[i]));
    context.fill();
    if (statuses.length === 1) context.fillRect(width - 3, y(upper[0]), 3, y(base[0]) - y(upper[0]));
    upper.forEach((value, i) => { base[i] = value; });
  });
  context.fillStyle = ink;
  context.font = `${Math.round(height / 9)}px system-ui, sans-serif`;
  context.fillText(`${top.toFixed(0)} ms`, 3, height / 8);
}
