// SPDX-License-Identifier: BSD-3-Clause
// The bar that shows and sets the moment of a recording.
import { h } from './dom';
import { Player } from './player';

const SPEEDS = [0.25, 0.5, 1, 2, 5, 10];

export class Timeline {
  private readonly slider = h('input', { type: 'range', min: '0', max: '1', step: 'any', 'aria-label': 'Time' });
  private readonly clock = h('output');
  private readonly play = h('button', { click: () => this.toggle(), 'data-name': 'play', title: 'Play or pause (space)' }, 'play');

  constructor(footer: HTMLElement, private readonly player: Player, private readonly onMoved: () => void) {
    const speeds = h('select', { 'aria-label': 'Speed' }, ...SPEEDS.map((s) => h('option', { value: String(s) }, `${s}×`)));
    speeds.value = '1';
    speeds.addEventListener('change', () => { player.speed = Number(speeds.value); });
    this.slider.max = String((player.endUtime - player.startUtime) * 1e-6);
    this.slider.addEventListener('input', () => {
      player.playing = false;
      player.seek(player.startUtime + 1e6 * Number(this.slider.value));
      onMoved();
    });
    footer.append(this.play, this.slider, this.clock, speeds);
    footer.hidden = player.endUtime === player.startUtime;  // a map alone has one moment
    this.show();
  }

  toggle(): void {
    if (this.player.playing) this.player.playing = false;
    else this.player.play();
    this.onMoved();
  }

  show(): void {
    const { startUtime, endUtime, utime, playing } = this.player;
    this.slider.value = String((utime - startUtime) * 1e-6);
    this.play.textContent = playing ? 'pause' : 'play';
    this.clock.textContent = `${((utime - startUtime) * 1e-6).toFixed(2)} / ${((endUtime - startUtime) * 1e-6).toFixed(2)} s`;
    this.clock.title = new Date(utime / 1000).toISOString();
  }
}
