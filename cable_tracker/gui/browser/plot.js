// What the plots have in common.

import { subscribe } from "./feed.js";

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
