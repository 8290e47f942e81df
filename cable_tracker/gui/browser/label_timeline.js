// A slider over all frames, with a mark for each labelled one. Drawn once for any number of frames.

const INSET = 10;
const KINDS = ["interpolated", "proposed", "hand", "no_cable"];

export class LabelTimeline {
  /** element: a canvas; colours: by kind of label; go(frame): the user wants that frame. */
  constructor(element, colours, go) {
    Object.assign(this, { element, colours, go });
    this.context = element.getContext("2d");
    this.count = 1;
    this.frame = 0;
    this.labels = new Map();
    this.resizing = new ResizeObserver(() => this.redraw());
    this.resizing.observe(element);
    element.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      element.setPointerCapture(event.pointerId);
      this.scrub(event);
    });
    element.addEventListener("pointermove", (event) => {
      if (element.hasPointerCapture(event.pointerId)) this.scrub(event);
    });
  }

  close() {
    this.resizing.disconnect();
  }

  scrub(event) {
    const area = this.element.getBoundingClientRect();
    const share = (event.clientX - area.left - INSET) / Math.max(1, area.width - 2 * INSET);
    const frame = Math.round(Math.min(1, Math.max(0, share)) * (this.count - 1));
    if (frame !== this.frame) this.go(frame);
  }

  show(changes) {
    Object.assign(this, changes);
    this.redraw();
  }

  redraw() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.paint();
    });
  }

  paint() {
    const { element, context, colours } = this;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [element.clientWidth, element.clientHeight];
    element.width = Math.round(width * ratio);
    element.height = Math.round(height * ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const step = (width - 2 * INSET) / Math.max(1, this.count - 1);
    const place = (frame) => INSET + frame * step;
    const base = height - 16;
    context.fillStyle = "#2b3238";
    context.fillRect(INSET, base, width - 2 * INSET, 4);
    // Seldom kinds last, so that they are seen where many frames share one pixel.
    for (const kind of KINDS) {
      context.fillStyle = colours[kind];
      const tall = { interpolated: 5, proposed: 9 }[kind] ?? 13;
      const thick = Math.min(8, Math.max(1.5, step - 1));
      for (const [frame, label] of this.labels) {
        if (label.flag !== kind) continue;
        const x = place(frame) - thick / 2;
        if (kind === "no_cable") {
          context.fillRect(x, base - 9, thick, 3);
          context.fillRect(x, base - 3, thick, 3);
        } else {
          context.fillRect(x, base - tall, thick, tall);
        }
      }
    }
    const x = place(this.frame);
    context.fillStyle = "#ffffff";
    context.fillRect(x - 1, base - 16, 2, 22);
    context.beginPath();
    context.arc(x, base + 8, 6, 0, 2 * Math.PI);
    context.fill();
  }
}
