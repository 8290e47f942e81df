// What fingers, pen and mouse do to the picture: drag handles, draw a cable, move and zoom the view.

const REACH = { mouse: 12, pen: 16, touch: 28 };

export class LabelGestures {
  /**
   * view: the FrameView;
   * target: find(point, reach) -> what lies there, or null for the picture itself;
   *         begin(found, point), move(point, both), end(), cancel() -> the drag of it.
   */
  constructor(view, target) {
    Object.assign(this, { view, target });
    this.pointers = new Map();
    this.drag = null;
    const canvas = view.canvas;
    canvas.style.touchAction = "none";
    const listen = (name, handler) => canvas.addEventListener(name, handler, { passive: false });
    listen("pointerdown", (event) => this.down(event));
    listen("pointermove", (event) => this.move(event));
    listen("pointerup", (event) => this.up(event));
    listen("pointercancel", (event) => this.up(event, true));
    listen("wheel", (event) => this.wheel(event));
    listen("contextmenu", (event) => event.preventDefault());
  }

  down(event) {
    const { view, target } = this;
    if (!view.description) return;
    view.canvas.focus({ preventScroll: true });
    view.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, [event.clientX, event.clientY]);
    if (this.pointers.size > 1) {
      if (this.drag === "target") target.cancel();
      this.drag = "pinch";
      return;
    }
    const point = view.pointAt(event);
    const wantsView = event.button !== 0 || event.altKey;
    const found = wantsView ? null : target.find(point, (REACH[event.pointerType] ?? 12) / view.scale);
    if (found) target.begin(found, point);
    this.drag = found ? "target" : "pan";
    this.showCursor(event);
  }

  move(event) {
    const { view, target } = this;
    const before = this.pointers.get(event.pointerId);
    if (!before) {
      this.showCursor(event);
      return;
    }
    const now = [event.clientX, event.clientY];
    if (this.drag === "target") {
      target.move(view.pointAt(event), event.shiftKey, event.timeStamp);
    } else if (this.drag === "pinch") {
      const other = [...this.pointers].find(([id]) => id !== event.pointerId)?.[1];
      if (other) this.pinch(before, now, other);
    } else {
      const [x, y] = view.middle;
      view.moveTo([x - (now[0] - before[0]) / view.scale, y - (now[1] - before[1]) / view.scale]);
    }
    this.pointers.set(event.pointerId, now);
  }

  pinch(before, now, other) {
    const { view } = this;
    const apart = ([x1, y1], [x2, y2]) => Math.hypot(x2 - x1, y2 - y1);
    const place = view.pointAt({ clientX: (now[0] + other[0]) / 2, clientY: (now[1] + other[1]) / 2 });
    view.zoomAbout(place, apart(now, other) / Math.max(1, apart(before, other)));
    const [x, y] = view.middle;
    const shift = [0, 1].map((i) => (now[i] - before[i]) / 2 / view.scale);
    view.moveTo([x - shift[0], y - shift[1]]);
  }

  up(event, cancelled = false) {
    if (!this.pointers.delete(event.pointerId)) return;
    if (this.drag === "target") cancelled ? this.target.cancel() : this.target.end();
    this.drag = this.pointers.size ? this.drag : null;
    if (!this.pointers.size) this.showCursor(event);
  }

  wheel(event) {
    event.preventDefault();
    if (!this.view.description) return;
    this.view.zoomAbout(this.view.pointAt(event), Math.exp(-event.deltaY / 400));
  }

  showCursor(event) {
    const { view, target } = this;
    if (event.pointerType !== "mouse" || !view.description) return;
    const cursor = { move: "move", rotate: "grab", widen: "ew-resize", skew: "nwse-resize", draw: "crosshair" };
    const found = target.find(view.pointAt(event), REACH.mouse / view.scale);
    view.canvas.style.cursor = cursor[found?.kind] ?? "default";
  }
}
