// What the plots have in common.

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

/** A number at an axis, with as many digits as its span asks for. */
export function ticks(value, span) {
  const digits = span >= 20 ? 0 : span >= 2 ? 1 : 2;
  const text = value.toFixed(digits);
  return Number(text) === 0 ? "0" : text.replace("-", "−");
}
