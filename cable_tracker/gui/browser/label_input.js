// What a user does in the labelling window: keys, one table for what they do and for what the help says; and fingers, pen
// and mouse on the picture, which drag handles, draw a cable, move and zoom the view.

/** group: heading in the help; keys: as in the help; on: what KeyboardEvent says; does: [command, ...]. */
export const KEYS = [
  { group: "Frames", keys: ["Enter"], words: "accept what is drawn, and go on", on: ["Enter"], does: "accept" },
  { group: "Frames", keys: ["PageDown", "."], words: "next frame (Shift: 10)", on: ["PageDown", ".", ">"], does: "next" },
  { group: "Frames", keys: ["PageUp", ","], words: "frame before (Shift: 10)", on: ["PageUp", ",", "<"], does: "previous" },
  { group: "Frames", keys: ["Home", "End"], words: "first, last frame", on: ["Home", "End"], does: "end" },
  { group: "Frames", keys: ["J", "K"], words: "key frame before, after", on: ["j", "k"], does: "key" },
  { group: "Frames", keys: ["U"], words: "next frame without a label", on: ["u"], does: "unlabelled" },
  { group: "Cable", keys: ["←", "→"], words: "move by 1 px (Shift: 10)", on: ["ArrowLeft", "ArrowRight"], does: "move" },
  { group: "Cable", keys: ["↑", "↓"], words: "wider, narrower by 1 px (Shift: 10)", on: ["ArrowUp", "ArrowDown"], does: "move" },
  { group: "Cable", keys: ["Q", "E"], words: "turn by 0.5° (Shift: 5)", on: ["q", "e"], does: "turn" },
  { group: "Cable", keys: ["A", "D"], words: "skew by 0.5° (Shift: 5)", on: ["a", "d"], does: "skew" },
  { group: "Labels", keys: ["P"], words: "propose by the tracker", on: ["p"], does: "propose" },
  { group: "Labels", keys: ["C"], words: "copy to the next frame, and go there", on: ["c"], does: "copy" },
  { group: "Labels", keys: ["I"], words: "interpolate to the key frames beside (Shift: everywhere)", on: ["i"], does: "interpolate" },
  { group: "Labels", keys: ["N"], words: "no cable in view", on: ["n"], does: "none" },
  { group: "Labels", keys: ["Delete"], words: "take the label away", on: ["Delete", "Backspace"], does: "clear" },
  { group: "Labels", keys: ["Esc"], words: "dismiss the proposal", on: ["Escape"], does: "dismiss" },
  { group: "View", keys: ["+", "−", "0"], words: "zoom in, out, whole picture", on: ["+", "=", "-", "0"], does: "zoom" },
  { group: "View", keys: ["Alt ←→↑↓"], words: "move the zoomed picture", on: [], does: "" },
  { group: "View", keys: ["V"], words: "hide what is drawn, while held down", on: ["v"], does: "hide" },
  { group: "View", keys: ["H", "?"], words: "this help", on: ["h", "?"], does: "help" },
  { group: "File", keys: ["Ctrl Z", "Ctrl Y"], words: "undo, redo", on: [], does: "" },
  { group: "File", keys: ["Ctrl S"], words: "save (Shift: save as)", on: [], does: "" },
  { group: "File", keys: ["Ctrl O"], words: "open another label file", on: [], does: "" },
];

const WITH_CONTROL = { z: "undo", y: "redo", s: "save", o: "open" };
const BY_KEY = new Map(KEYS.flatMap(({ on, does }) => on.map((key) => [key, does])));

/** What a key means: {does, key, large}; null if nothing. */
export function meaningOf(event) {
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const meaning = (does) => ({ does, key, large: event.shiftKey });
  if (event.ctrlKey || event.metaKey) {
    const does = WITH_CONTROL[key];
    if (!does || event.altKey) return null;
    return meaning(event.shiftKey ? { undo: "redo", save: "save_as" }[does] ?? does : does);
  }
  if (event.altKey) return key.startsWith("Arrow") ? meaning("pan") : null;
  return BY_KEY.has(key) ? meaning(BY_KEY.get(key)) : null;
}

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
