// Limits of an axis that stay where they are while they suit the values.

const FRAMES_TO_SHRINK = 40;
const STEPS = [1, 2, 5, 10];

/** The smallest of 1, 2, 5, 10, 20, ... that is not smaller. */
function roundUp(span) {
  const power = 10 ** Math.floor(Math.log10(span));
  return power * STEPS.find((step) => step * power >= span * 0.999999);
}

export class Axis {
  /** least: the smallest span; zero: whether the axis begins at 0. */
  constructor(least, { zero = false } = {}) {
    this.least = least;
    this.zero = zero;
    this.low = 0;
    this.high = 0;
    this.narrow = 0;
  }

  /** Make room for values from low to high. It widens at once and narrows after a while. */
  include(low, high) {
    if (this.zero) [low, high] = [0, Math.max(0, high)];
    if (!Number.isFinite(low) || !Number.isFinite(high)) return;
    const needed = Math.max(high - low, this.least / 2);
    const fits = low >= this.low && high <= this.high;
    this.narrow = fits && needed < (this.high - this.low) / 5 ? this.narrow + 1 : 0;
    if (fits && this.narrow < FRAMES_TO_SHRINK) return;
    this.narrow = 0;
    let span = Math.max(this.least, roundUp(needed * 1.1));
    do {
      const quarter = span / 4;
      this.low = this.zero ? 0 : Math.round((low + high) / 2 / quarter) * quarter - span / 2;
      this.high = this.low + span;
      span = roundUp(span * 1.01);
    } while (low < this.low || high > this.high);
  }

  /** Where a value lies, 0 to 1. */
  at(value) {
    return (value - this.low) / (this.high - this.low || 1);
  }
}
