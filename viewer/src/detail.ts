// SPDX-License-Identifier: BSD-3-Clause
// How much is drawn while the picture moves, so that it moves smoothly where the processor draws; at rest everything is.

const SLOW_MS = 60;       // 15 frames a second, with something to spare
const FAST_MS = 25;
const FAST_FRAMES = 60;   // of them in a row, before more is tried
const REST_MS = 400;
export const MAX_LEVEL = 4;

export class Detail {
  level = 0;  // 0: everything
  private meanMs = 30;
  private numFast = 0;
  private drawnMs = -Infinity;
  private tickMs = 0;

  /// To be called every tick, before drawing. @return true when the level has changed
  tick(nowMs: number): boolean {
    const intervalMs = nowMs - this.tickMs;
    const drewLastTick = this.drawnMs === this.tickMs;
    this.tickMs = nowMs;
    if (drewLastTick) return this.judge(intervalMs);
    if (this.level === 0 || nowMs - this.drawnMs < REST_MS) return false;
    this.set(0);
    return true;
  }

  drawn(): void {
    this.drawnMs = this.tickMs;
  }

  /// Of the cells of the world, the share that is drawn.
  get share(): number {
    return 0.4 ** this.level;
  }

  /// Of the pixels along a side, the share that is drawn.
  get sharpness(): number {
    return this.level === 0 ? 1 : this.level === 1 ? 0.7 : 0.5;
  }

  /// Whether bands too far away to be seen are left out.
  get thinsBands(): boolean {
    return this.level >= 3;
  }

  restore(): void {
    this.set(0);
  }

  private judge(intervalMs: number): boolean {
    this.meanMs += 0.3 * (intervalMs - this.meanMs);
    this.numFast = intervalMs < FAST_MS ? this.numFast + 1 : 0;
    if (this.meanMs > SLOW_MS && this.level < MAX_LEVEL) {
      this.set(this.level + 1);
      return true;
    }
    if (this.numFast < FAST_FRAMES || this.level === 0) return false;
    this.set(this.level - 1);
    return true;
  }

  private set(level: number): void {
    this.level = level;
    this.meanMs = 30;
    this.numFast = 0;
  }
}
