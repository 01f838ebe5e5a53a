// SPDX-License-Identifier: BSD-3-Clause
// How long it takes until what happened is on the screen, by the clock of the computer that runs `terrace view`; true where the
// browser runs there, too.
import { StreamRecord } from './records';

const KEPT = 200;

/// Medians, newest ones only [ms]; null: not known yet.
export interface Latencies {
  busMs: number | null;        // from hearing a pose or a map to the screen
  imageToPoseMs: number | null;  // from hearing an image to its pose on the screen
  imageToMapMs: number | null;   // from hearing an image to the map with it on the screen
}

function median(values: number[]): number | null {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted.length > 0 ? sorted[sorted.length >> 1] : null;
}

/// When things happened, by the capture time of their frame; so many that no more can be under way.
class Moments extends Map<number, number> {
  note(utime: number, atUs: number): void {
    if (this.has(utime)) return;
    this.set(utime, atUs);
    if (this.size > KEPT) this.delete(this.keys().next().value!);
  }
}

export class Latency {
  private undrawn: StreamRecord[] = [];
  private readonly imagesHeard = new Moments();
  private readonly drawn = { P: new Moments(), T: new Moments() };
  private readonly found: Record<'bus' | 'P' | 'T', number[]> = { bus: [], P: [], T: [] };

  heard(record: StreamRecord): void {
    if (record.heardUtime <= 0) return;
    if (record.kind === 'P' || record.kind === 'T') this.undrawn.push(record);
    if (record.kind !== 'I') return;
    this.imagesHeard.note(record.utime, record.heardUtime);
    // The image comes after its pose, or even its map.
    for (const kind of ['P', 'T'] as const) this.match(kind, record.utime);
  }

  /// Everything that was heard is on the screen.
  onScreen(nowUs: number): void {
    for (const { kind, utime, heardUtime } of this.undrawn) {
      this.keep('bus', nowUs - heardUtime);
      const of = kind as 'P' | 'T';
      this.drawn[of].note(utime, nowUs);
      this.match(of, utime);
    }
    this.undrawn = [];
  }

  medians(): Latencies {
    return { busMs: median(this.found.bus), imageToPoseMs: median(this.found.P), imageToMapMs: median(this.found.T) };
  }

  private match(kind: 'P' | 'T', utime: number): void {
    const heardUs = this.imagesHeard.get(utime);
    const drawnUs = this.drawn[kind].get(utime);
    if (heardUs !== undefined && drawnUs !== undefined) this.keep(kind, drawnUs - heardUs);
  }

  private keep(what: 'bus' | 'P' | 'T', us: number): void {
    this.found[what].push(us / 1000);
    if (this.found[what].length > KEPT) this.found[what].shift();
  }
}
