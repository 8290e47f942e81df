// What both windows share; NiceGUI serves it as the module "cable-tracker-browser".
export { unpack } from "./packet.js";
export { FrameView } from "./frame_view.js";
export { publish, subscribe } from "./feed.js";
export { Axis } from "./axis.js";
export { fit, ticks, throttled } from "./plot.js";
