// What both windows share; NiceGUI serves it as the module "cable-tracker-browser".
export { FrameView } from "./frame_view.js";
export { publish, subscribe, unpack } from "./feed.js";
export { Axis, fit, keepPainted, ticks, throttled } from "./plot.js";
export * as labelGeometry from "./label_geometry.js";
export { drawCable, fromCanvas, toCanvas, visibleRectangle } from "./label_drawing.js";
export { KEYS, LabelGestures, meaningOf } from "./label_input.js";
export { LabelTimeline } from "./label_timeline.js";
