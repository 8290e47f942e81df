// Where the borders of a labelled cable are, and how a label follows the hand that drags it.
//
// A state is [d, alpha, w, beta], px and rad, as in cable/model/geometry.py: origin at the image centre,
// x to the right, y up. A rectangle is [left, bottom, right, top] in the same frame.

export const SMALLEST_WIDTH = 1;
export const LARGEST_SKEW = Math.PI / 4;

const modulo = (value, divisor) => value - divisor * Math.floor(value / divisor);
const clamp = (value, low, high) => Math.min(high, Math.max(low, value));
const normal = (angle) => [Math.cos(angle), Math.sin(angle)];
const upward = (angle) => [-Math.sin(angle), Math.cos(angle)];
const dot = ([x1, y1], [x2, y2]) => x1 * x2 + y1 * y2;

/** The same cable with alpha in (-pi/2, pi/2]; turning the normal round turns d and beta too. */
export function wrapState([d, alpha, w, beta]) {
  if (alpha > -Math.PI / 2 && alpha <= Math.PI / 2) return [d, alpha, w, beta];
  const wrapped = Math.PI / 2 - modulo(Math.PI / 2 - alpha, Math.PI);
  const turned = modulo(Math.round((alpha - wrapped) / Math.PI), 2) === 1;
  return turned ? [-d, wrapped, w, -beta] : [d, wrapped, w, beta];
}

/** The cable within the limits of what can be drawn. */
export function limitState([d, alpha, w, beta]) {
  return wrapState([d, alpha, Math.max(SMALLEST_WIDTH, w), clamp(beta, -LARGEST_SKEW, LARGEST_SKEW)]);
}

/** Left border, centreline and right border as [angle, offset]. */
export function linesOf([d, alpha, w, beta]) {
  const cosine = Math.cos(beta);
  return {
    left: [alpha - beta, (d - w / 2) * cosine],
    centre: [alpha, d],
    right: [alpha + beta, (d + w / 2) * cosine],
  };
}

/** The inverse of linesOf. */
export function stateOfBorders([leftAngle, leftOffset], [rightAngle, rightOffset]) {
  const beta = (rightAngle - leftAngle) / 2;
  const cosine = Math.cos(beta);
  return [
    (leftOffset + rightOffset) / (2 * cosine),
    (leftAngle + rightAngle) / 2,
    (rightOffset - leftOffset) / cosine,
    beta,
  ];
}

/** Ends of a line within a rectangle, lower one first along the line; null if it is outside. */
export function clipLine([angle, offset], [left, bottom, right, top]) {
  const [foot, along] = [normal(angle).map((part) => part * offset), upward(angle)];
  let [low, high] = [-Infinity, Infinity];
  for (const [start, slope, from, to] of [
    [foot[0], along[0], left, right],
    [foot[1], along[1], bottom, top],
  ]) {
    if (Math.abs(slope) < 1e-12) {
      if (start < from || start > to) return null;
      continue;
    }
    const [first, second] = [(from - start) / slope, (to - start) / slope];
    low = Math.max(low, Math.min(first, second));
    high = Math.min(high, Math.max(first, second));
  }
  if (low >= high) return null;
  return [low, high].map((s) => [foot[0] + s * along[0], foot[1] + s * along[1]]);
}

/** How far along the cable, from its foot point, a point lies. */
const alongOf = ([, alpha], point) => dot(point, upward(alpha));

/** How far across the cable, from its centreline, a point lies. */
const acrossOf = ([d, alpha], point) => dot(point, normal(alpha)) - d;

/** Width of a cable at a place along it. */
export const widthAt = ([, , w, beta], along) => w - 2 * along * Math.tan(beta);

const pointOn = ([d, alpha], along, across) => {
  const [n, t] = [normal(alpha), upward(alpha)];
  return [0, 1].map((i) => (d + across) * n[i] + along * t[i]);
};

/**
 * The handles of a cable, as points of the image frame, within a rectangle.
 * along: place of the middle handle, to which the others belong.
 */
export function handlesOf(state, rectangle) {
  const { left, right, centre } = linesOf(state);
  const seen = [centre, left, right].map((line) => clipLine(line, rectangle)).find((ends) => ends);
  const places = seen ? seen.map((point) => alongOf(state, point)) : [-1, 1];
  const middle = (places[0] + places[1]) / 2;
  const reach = (places[1] - places[0]) / 2;
  const half = (along) => widthAt(state, along) / 2;
  const [low, high] = [middle - 0.6 * reach, middle + 0.6 * reach];
  return {
    along: middle,
    points: [
      { kind: "move", at: pointOn(state, middle, 0) },
      { kind: "rotate", at: pointOn(state, high, 0) },
      { kind: "rotate", at: pointOn(state, low, 0) },
      { kind: "widen", side: -1, at: pointOn(state, middle, -half(middle)) },
      { kind: "widen", side: 1, at: pointOn(state, middle, half(middle)) },
      { kind: "skew", side: -1, at: pointOn(state, high, -half(high)) },
      { kind: "skew", side: 1, at: pointOn(state, high, half(high)) },
    ],
  };
}

/** Whether a point lies on the cable, or within a margin of it. */
export function isOn(state, point, margin) {
  return Math.abs(acrossOf(state, point)) <= widthAt(state, alongOf(state, point)) / 2 + margin;
}

/** A cable as wide at `along` as another is, but with another skew. */
function reskewed([d, alpha, w, beta], along, skew) {
  const limited = clamp(skew, -LARGEST_SKEW, LARGEST_SKEW);
  return [d, alpha, widthAt([d, alpha, w, beta], along) + 2 * along * Math.tan(limited), limited];
}

/** The cable turned about the point on its centreline at `along`, to another angle. */
export function turned(state, along, angle) {
  const [, , , beta] = state;
  const pivot = pointOn(state, along, 0);
  const there = dot(pivot, upward(angle));
  const width = widthAt(state, along) + 2 * there * Math.tan(beta);
  return [dot(pivot, normal(angle)), angle, width, beta];
}

/**
 * The cable after a drag.
 * start: the state when it began; handle: {kind, side}; along: place of the middle handle then;
 * from, to: points of the image frame where the pointer went down, and where it is;
 * both: whether the other border moves too, away from the centreline or towards it.
 */
export function dragged(start, { kind, side }, along, from, to, both = false) {
  const [d, alpha, w, beta] = start;
  if (kind === "move") {
    return limitState([d + acrossOf(start, to) - acrossOf(start, from), alpha, w, beta]);
  }
  if (kind === "rotate") {
    const pivot = pointOn(start, along, 0);
    const direction = ([x, y]) => Math.atan2(y - pivot[1], x - pivot[0]);
    return limitState(turned(start, along, alpha + direction(to) - direction(from)));
  }
  // How far the pointer has gone from the border, outwards.
  const beyond = (point) => side * acrossOf(start, point) - widthAt(start, alongOf(start, point)) / 2;
  const outwards = beyond(to) - beyond(from);
  if (kind === "widen") {
    const wider = Math.max(SMALLEST_WIDTH, w + (both ? 2 : 1) * outwards);
    const shift = both ? 0 : (side * (wider - w)) / 2;
    return limitState([d + shift, alpha, wider, beta]);
  }
  // Skew: the border follows the pointer and keeps its place at the middle handle.
  const arm = alongOf(start, to) - along;
  if (arm * (alongOf(start, from) - along) <= 0) return start;
  const half = widthAt(start, alongOf(start, to)) / 2 + outwards;
  return limitState(reskewed(start, along, Math.atan((widthAt(start, along) / 2 - half) / arm)));
}

/** A cable whose centreline goes through two points; null if they are one. */
export function cableThrough([x1, y1], [x2, y2], width) {
  const length = Math.hypot(x2 - x1, y2 - y1);
  if (length === 0) return null;
  const alpha = Math.atan2(-(x2 - x1) / length, (y2 - y1) / length);
  return wrapState([dot([x1, y1], normal(alpha)), alpha, width, 0]);
}

/** The cable after a step of the keyboard: across [px], turn [rad], wider [px], skew [rad]. */
export function stepped(state, { across = 0, turn = 0, wider = 0, skew = 0 }, along = 0) {
  let next = [state[0] + across, ...state.slice(1)];
  if (turn) next = turned(next, along, next[1] + turn);
  if (skew) next = reskewed(next, along, next[3] + skew);
  return limitState([next[0], next[1], next[2] + wider, next[3]]);
}
