// The picture with everything drawn on it, and where the user wants the cable to be.
import { FrameView } from "cable-tracker-browser";

export default {
  template: `<canvas class="frame-canvas" tabindex="0" role="img"></canvas>`,
  props: { channel: String },
  mounted() {
    this.view = new FrameView(this.$el, this.channel, {
      connection: (isOpen) => this.$emit("connection", { open: isOpen }),
    });
    this.$el.frameView = this.view;
  },
  beforeUnmount() {
    this.view.close();
  },
};
