// How a labelled cable looks on the picture.
import { clipLine, handlesOf, linesOf } from "./label_geometry.js";

const HANDLE = 6;
const SHADOW = "rgba(0, 0, 0, 0.65)";

/** Points between the image frame (origin in the middle, y up) and the canvas of a picture. */
export const toCanvas = ([x, y], [width, height]) => [width / 2 + x, height / 2 - y];
export const fromCanvas = ([x, y], [width, height]) => [x - width / 2, height / 2 - y];

/** The part of the image that can be seen, as a rectangle of the image frame. */
export function visibleRectangle(view) {
  const [width, height] = view.description.size;
  const [x, y] = view.middle;
  const reach = [view.canvas.clientWidth, view.canvas.clientHeight].map((side) => side / 2 / view.scale);
  return [
    Math.max(0, x - reach[0]) - width / 2,
    height / 2 - Math.min(height, y + reach[1]),
    Math.min(width, x + reach[0]) - width / 2,
    height / 2 - Math.max(0, y - reach[1]),
  ];
}

/**
 * Draw borders and centreline.
 * style: {colour, width, dash?}; grasped: the handle that is being dragged, if any.
 */
export function drawCable(context, view, state, style, grasped = null) {
  const { size } = view.description;
  const [width, height] = size;
  const image = [-width / 2, -height / 2, width / 2, height / 2];
  const lines = linesOf(state);
  const stroke = (line, colour, thickness, dash = []) => {
    const ends = clipLine(line, image);
    if (!ends) return;
    context.beginPath();
    context.moveTo(...toCanvas(ends[0], size));
    context.lineTo(...toCanvas(ends[1], size));
    context.strokeStyle = colour;
    context.lineWidth = thickness * view.pixel;
    context.setLineDash(dash.map((length) => length * view.pixel));
    context.stroke();
    context.setLineDash([]);
  };
  for (const border of [lines.left, lines.right]) {
    stroke(border, SHADOW, style.width + 2);
    stroke(border, style.colour, style.width, style.dash);
  }
  context.globalAlpha = 0.7;
  stroke(lines.centre, style.colour, 1, [2, 5]);
  context.globalAlpha = 1;
  for (const handle of handlesOf(state, visibleRectangle(view)).points) {
    const isGrasped = grasped && grasped.kind === handle.kind && grasped.side === handle.side;
    drawHandle(context, view.pixel, toCanvas(handle.at, size), handle.kind, isGrasped ? "#fff" : style.colour);
  }
}

function drawHandle(context, pixel, [x, y], kind, colour) {
  const r = HANDLE * pixel;
  context.beginPath();
  if (kind === "rotate") {
    context.arc(x, y, r, 0, 2 * Math.PI);
  } else if (kind === "move") {
    context.rect(x - r, y - r, 2 * r, 2 * r);
  } else if (kind === "widen") {
    for (const [dx, dy] of [[0, -1.3], [1.3, 0], [0, 1.3], [-1.3, 0]]) context.lineTo(x + dx * r, y + dy * r);
    context.closePath();
  } else {
    for (const [dx, dy] of [[0, -1.3], [1.2, 0.9], [-1.2, 0.9]]) context.lineTo(x + dx * r, y + dy * r);
    context.closePath();
  }
  context.fillStyle = SHADOW;
  context.fill();
  context.lineWidth = 2 * pixel;
  context.strokeStyle = colour;
  context.stroke();
}
