// A canvas that shows the pictures of one channel, with what is drawn on them, and can be zoomed.
//
// A packet describes a picture (frame_channel.py):
//   number       which picture it is
//   size         [width, height] of the frame; the JPEG may be smaller
//   layers       each may have a name, by which it can be hidden:
//                [{kind: "lines", colour, width, dash?, opacity?, points: [x1, y1, x2, y2, ...]},
//                 {kind: "area", colour, opacity, points: [x, y, ...]}]
//   parts        picture: the JPEG;
//                particles: rows of x1, y1, x2, y2, opacity
// All points are in pixels of the frame, origin at the upper left corner, y down.

import { unpack } from "./feed.js";

const OPACITY_STEPS = 16;
const RETRY_MS = 1000;
const LARGEST_ZOOM = 16;

export class FrameView {
  /**
   * canvas: the element to draw on.
   * hooks: draw(context, view) draws on top of all; received(description) hears of each packet;
   *        connection(isOpen) hears of the connection.
   */
  constructor(canvas, channel, hooks = {}) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.hooks = hooks;
    this.description = null;
    this.bitmap = null;
    this.zoom = 1;
    this.centre = null;
    this.closed = false;
    /** Names of layers that are not drawn; "picture" and "particles" too. */
    this.hidden = new Set();
    this.resizing = new ResizeObserver(() => this.redraw());
    this.resizing.observe(canvas);
    this.connect(channel);
  }

  connect(channel) {
    const base = document.baseURI.replace(/^http/, "ws").replace(/[?#].*$/, "");
    this.socket = new WebSocket(new URL(`frames/${channel}`, base));
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => this.hooks.connection?.(true);
    this.socket.onmessage = (message) => this.receive(message.data);
    this.socket.onclose = () => {
      if (this.closed) return;
      this.hooks.connection?.(false);
      this.retry = setTimeout(() => this.connect(channel), RETRY_MS);
    };
  }

  /** Whole seconds since the last packet has come. */
  get age() {
    return Math.floor((performance.now() - (this.receivedAt ?? 0)) / 1000);
  }

  close() {
    this.closed = true;
    clearTimeout(this.retry);
    this.resizing.disconnect();
    this.socket.close();
    this.bitmap?.close();
  }

  async receive(buffer) {
    const description = unpack(buffer);
    this.receivedAt = performance.now();
    const picture = description.parts.picture;
    const bitmap = picture ? await createImageBitmap(picture) : null;
    if (this.closed) return;
    this.bitmap?.close();
    this.bitmap = bitmap;
    this.description = description;
    // Drawn when the browser paints; a page in the background paints nothing, and wants no more.
    requestAnimationFrame(() => {
      this.paint();
      if (this.socket.readyState === WebSocket.OPEN) this.socket.send(String(description.number));
    });
    this.hooks.received?.(description);
  }

  /** Draw again before long, for instance because the user drags something. */
  redraw() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.paint();
    });
  }

  /** Pixels of the screen for one of the frame. */
  get scale() {
    const [width, height] = this.description.size;
    return this.zoom * Math.min(this.canvas.clientWidth / width, this.canvas.clientHeight / height);
  }

  /** Point of the frame in the middle of the canvas. */
  get middle() {
    const [width, height] = this.description.size;
    return this.zoom === 1 || !this.centre ? [width / 2, height / 2] : this.centre;
  }

  /** Point of the frame under a pointer event. */
  pointAt(event) {
    const area = this.canvas.getBoundingClientRect();
    const [x, y] = this.middle;
    return [
      x + (event.clientX - area.left - area.width / 2) / this.scale,
      y + (event.clientY - area.top - area.height / 2) / this.scale,
    ];
  }

  /** Zoom by a factor, and keep the given point of the frame where it is on the screen. */
  zoomAbout([x, y], factor) {
    if (!this.description) return;
    const [cx, cy] = this.middle;
    const zoom = Math.min(LARGEST_ZOOM, Math.max(1, this.zoom * factor));
    const ratio = this.zoom / zoom;
    this.zoom = zoom;
    this.moveTo([x + (cx - x) * ratio, y + (cy - y) * ratio]);
  }

  /** Put a point of the frame into the middle of the canvas, as far as the frame goes. */
  moveTo([x, y]) {
    const [width, height] = this.description.size;
    this.centre = [Math.min(width, Math.max(0, x)), Math.min(height, Math.max(0, y))];
    this.redraw();
  }

  resetZoom() {
    this.zoom = 1;
    this.centre = null;
    this.redraw();
  }

  paint() {
    const { canvas, context, description } = this;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth * ratio, canvas.clientHeight * ratio].map(Math.round);
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, width, height);
    if (!description || !width || !height) return;
    const scale = this.scale * ratio;
    const [x, y] = this.middle;
    context.setTransform(scale, 0, 0, scale, width / 2 - x * scale, height / 2 - y * scale);
    // Lines are as wide on the screen at any zoom.
    this.pixel = ratio / scale;
    if (this.bitmap && !this.hidden.has("picture")) {
      context.imageSmoothingEnabled = scale < 3;
      context.drawImage(this.bitmap, 0, 0, ...description.size);
    }
    // Lines go on for ever; what lies beside the picture is not of it.
    context.save();
    context.beginPath();
    context.rect(0, 0, ...description.size);
    context.clip();
    if (description.parts.particles && !this.hidden.has("particles")) this.paintParticles(description);
    for (const layer of description.layers ?? []) {
      if (!this.hidden.has(layer.name)) this.paintLayer(layer);
    }
    context.restore();
    this.hooks.draw?.(context, this);
  }

  paintLayer({ kind, colour, width = 1, dash = [], opacity = 1, points }) {
    const { context } = this;
    context.globalAlpha = opacity;
    context.beginPath();
    if (kind === "area") {
      for (let i = 0; i < points.length; i += 2) context.lineTo(points[i], points[i + 1]);
      context.fillStyle = colour;
      context.fill();
    } else {
      for (let i = 0; i < points.length; i += 4) {
        context.moveTo(points[i], points[i + 1]);
        context.lineTo(points[i + 2], points[i + 3]);
      }
      context.strokeStyle = colour;
      context.lineWidth = width * this.pixel;
      context.setLineDash(dash.map((length) => length * this.pixel));
      context.stroke();
      context.setLineDash([]);
    }
    context.globalAlpha = 1;
  }

  // A path for each step of opacity: one for each particle would cost ten times as much.
  paintParticles({ parts, particle_colour: colour = "#5ad1ff" }) {
    const { context } = this;
    const { rows, columns, values } = parts.particles;
    const paths = Array.from({ length: OPACITY_STEPS }, () => new Path2D());
    for (let row = 0; row < rows; row++) {
      const at = row * columns;
      const step = Math.min(OPACITY_STEPS - 1, Math.floor(values[at + 4] * OPACITY_STEPS));
      paths[step].moveTo(values[at], values[at + 1]);
      paths[step].lineTo(values[at + 2], values[at + 3]);
    }
    context.strokeStyle = colour;
    context.lineWidth = this.pixel;
    paths.forEach((path, step) => {
      context.globalAlpha = (step + 1) / OPACITY_STEPS;
      context.stroke(path);
    });
    context.globalAlpha = 1;
  }
}
