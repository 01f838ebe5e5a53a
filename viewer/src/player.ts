// SPDX-License-Identifier: BSD-3-Clause
// Plays a recording into a model: pause, speed, any moment.
import { Model } from './model';
import { StreamRecord } from './records';

const TIMELESS = 'HFCUW';  // who speaks, figures, the camera, the truth: known from the start

/// When it was heard: clocks of different senders need not agree. What never was live has its own time.
function timeOf(record: StreamRecord): number {
  return record.heardUtime > 0 ? record.heardUtime : record.utime;
}

export class Player {
  readonly startUtime: number;
  readonly endUtime: number;
  utime: number;
  playing = false;
  speed = 1;
  private readonly records: StreamRecord[];
  private next = 0;

  constructor(records: StreamRecord[], private readonly model: Model) {
    for (const record of records) if (TIMELESS.includes(record.kind)) model.apply(record);
    // Sorting is stable: what belongs to one moment stays in order.
    this.records = records.filter((r) => !TIMELESS.includes(r.kind)).sort((a, b) => timeOf(a) - timeOf(b));
    this.startUtime = this.records.length > 0 ? timeOf(this.records[0]) : 0;
    this.endUtime = this.records.length > 0 ? timeOf(this.records.at(-1)!) : 0;
    this.utime = this.startUtime;
  }

  seek(utime: number): void {
    const wanted = Math.min(this.endUtime, Math.max(this.startUtime, utime));
    if (wanted < this.utime) {
      this.model.clear();
      this.next = 0;
    }
    this.utime = wanted;
    while (this.next < this.records.length && timeOf(this.records[this.next]) <= wanted) this.model.apply(this.records[this.next++]);
  }

  /// @return true when time has moved
  advance(elapsedS: number): boolean {
    if (!this.playing) return false;
    this.seek(this.utime + 1e6 * this.speed * elapsedS);
    if (this.utime >= this.endUtime) this.playing = false;
    return true;
  }

  play(): void {
    if (this.utime >= this.endUtime) this.seek(this.startUtime);
    this.playing = true;
  }
}
