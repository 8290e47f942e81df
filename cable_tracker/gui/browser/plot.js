// What the plots have in common: canvases, repainting, and axes.

import { subscribe } from "./feed.js";

const FRAMES_TO_SHRINK = 40;
const STEPS = [1, 2, 5, 10];

export const FONT = "11px system-ui, sans-serif";

/** Fit a canvas to its place on the screen, clear it, and return [context, width, height]. */
export function fit(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  const size = [width, height].map((length) => Math.round(length * ratio));
  if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = FONT;
  context.setLineDash([]);
  context.globalAlpha = 1;
  return [context, width, height];
}

/** Return a function that calls another one at most once in so many ms, and always after the last time it was asked to. */
export function throttled(action, interval) {
  let [last, waiting] = [-Infinity, null];
  const run = () => {
    waiting = null;
    last = performance.now();
    action();
  };
  const ask = () => {
    if (waiting !== null) return;
    const left = last + interval - performance.now();
    if (left <= 0) run();
    else waiting = setTimeout(run, left);
  };
  ask.end = () => clearTimeout(waiting);
  return ask;
}

/**
 * Take every packet of a channel, and paint at most once in `interval` ms, and when the canvas changes its size.
 * Returns how to end it.
 */
export function keepPainted(canvas, channel, { take, paint, interval }) {
  const ask = throttled(paint, interval);
  const end = subscribe(channel, (description) => {
    take(description);
    ask();
  });
  const resizing = new ResizeObserver(() => paint());
  resizing.observe(canvas);
  return () => {
    end();
    ask.end();
    resizing.disconnect();
  };
}

/** A number at an axis, with as many digits as its span asks for. */
export function ticks(value, span) {
  const digits = span >= 20 ? 0 : span >= 2 ? 1 : 2;
  const text = value.toFixed(digits);
  return Number(text) === 0 ? "0" : text.replace("-", "−");
}

/** The smallest of 1, 2, 5, 10, 20, ... that is not smaller. */
function roundUp(span) {
  const power = 10 ** Math.floor(Math.log10(span));
  return power * STEPS.find((step) => step * power >= span * 0.999999);
}

/** Limits of an axis that stay where they are while they suit the values. */
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
