// The picture with what the filter believes, what of it is shown, and where the user draws a cable, or a box.
import { FrameView, publish } from "cable-tracker-browser";

const STORE = "cable-tracker-hidden-layers";
const CLICK = 5;
const WIDTH_STEP = 1.08;
const LEAST_WIDTH = 2;

export default {
  template: `
  <section class="ct-panel ct-picture" aria-label="Picture">
    <div class="ct-stage">
      <canvas ref="canvas" tabindex="0" role="img" :aria-label="words"></canvas>
      <div class="ct-status" :style="stale ? {} : { borderColor: statusColour, color: statusColour }" data-test="status">
        {{ stale ? "NOT LIVE, last picture " + age + " s ago" : presence === null ? status : status + "  " + presence + " %" }}
      </div>
      <div v-if="reason" class="ct-reason" data-test="reason">{{ reason }}</div>
      <div v-if="!connected" class="ct-cut" role="alert" data-test="cut">
        No connection to the server. Trying again …
      </div>
      <div v-if="hint" class="ct-hint">{{ hint }}</div>
    </div>
    <div class="ct-toggles" role="group" aria-label="What is drawn">
      <label v-for="layer in layers" :key="layer.name">
        <input type="checkbox" :checked="!hidden.includes(layer.name)" :data-test="'show-' + layer.name"
          @change="toggle(layer.name)" />
        <i :style="{ background: layer.colour, opacity: layer.opacity ?? 1 }"></i>{{ layer.title }}
      </label>
      <span v-if="!widens" class="ct-right"></span>
      <label v-else class="ct-right" title="Width of a cable that you draw. Empty: that of the estimate. The wheel changes it while you draw.">
        start width
        <input type="text" inputmode="decimal" class="ct-short" v-model="startWidth" placeholder="auto"
          aria-label="Width of a cable that is drawn, px" data-test="start-width" /> px
      </label>
      <button type="button" class="ct-button" data-command="whole" @click="view.resetZoom()" title="Show the whole picture (0)">whole</button>
    </div>
  </section>`,
  emits: ["draw"],
  props: { channel: String, layers: Array, shape: String, widens: Boolean, stale: Boolean },
  data: () => ({
    connected: true, status: "", statusColour: "#aaa", presence: null, reason: "", words: "No picture yet", age: 0,
    hidden: [], startWidth: "", hint: "",
  }),
  mounted() {
    const canvas = this.$refs.canvas;
    try {
      this.hidden = JSON.parse(localStorage.getItem(STORE) ?? "[]").map(String);
    } catch {
      this.hidden = [];
    }
    this.view = new FrameView(canvas, this.channel, {
      connection: (isOpen) => (this.connected = isOpen),
      received: (description) => this.received(description),
      draw: (context, view) => this.paintDrawn(context, view),
    });
    this.view.hidden = new Set(this.hidden);
    canvas.frameView = this.view;
    canvas.addEventListener("pointerdown", (event) => this.press(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.release(event));
    canvas.addEventListener("pointercancel", () => this.cancel());
    canvas.addEventListener("wheel", (event) => this.turn(event), { passive: false });
    this.onKey = (event) => {
      if (event.key === "Escape") this.cancel();
    };
    window.addEventListener("keydown", this.onKey);
    this.clock = setInterval(() => (this.age = this.view.age), 500);
  },
  beforeUnmount() {
    window.removeEventListener("keydown", this.onKey);
    clearInterval(this.clock);
    this.view.close();
  },
  computed: {
    isBox() {
      return this.shape === "box";
    },
  },
  methods: {
    received(description) {
      this.status = description.status;
      this.statusColour = description.status_colour;
      this.presence = description.presence === null ? null : Math.round(100 * description.presence);
      this.reason = description.reason;
      this.words = `Frame ${description.frame ?? description.number}, ${description.status}`;
      if (this.drawn && this.drawn.isDone && description.number > this.drawn.number) this.drawn = null;
      publish(this.channel, description);
    },
    toggle(name) {
      this.hidden = this.hidden.includes(name) ? this.hidden.filter((other) => other !== name) : [...this.hidden, name];
      localStorage.setItem(STORE, JSON.stringify(this.hidden));
      this.view.hidden = new Set(this.hidden);
      this.view.redraw();
    },
    widthToStart() {
      const typed = Number(this.startWidth.replace(",", "."));
      const description = this.view.description;
      return typed > 0 ? typed : (description.state?.[2] ?? description.size[0] / 8);
    },
    press(event) {
      if (!this.view.description) return;
      this.$refs.canvas.focus();
      this.$refs.canvas.setPointerCapture(event.pointerId);
      if (event.button === 1 || event.shiftKey) {
        this.grasped = this.view.pointAt(event);
        event.preventDefault();
        return;
      }
      if (event.button !== 0) return;
      const point = this.view.pointAt(event);
      this.drawn = {
        start: point, end: point, width: this.widthToStart(),
        screen: [event.clientX, event.clientY], number: this.view.description.number,
      };
      const wheel = this.widens ? "the wheel changes its width, " : "";
      this.hint = this.isBox ? "Draw a box around the target; Esc cancels" : `Draw along the cable; ${wheel}Esc cancels`;
    },
    move(event) {
      if (this.grasped) {
        const [x, y] = this.view.pointAt(event);
        const [cx, cy] = this.view.middle;
        this.view.moveTo([cx + this.grasped[0] - x, cy + this.grasped[1] - y]);
      } else if (this.drawn && !this.drawn.isDone) {
        this.drawn.end = this.view.pointAt(event);
        this.view.redraw();
      }
    },
    release(event) {
      this.grasped = null;
      const { drawn } = this;
      if (!drawn || drawn.isDone) return;
      this.hint = "";
      const way = Math.hypot(event.clientX - drawn.screen[0], event.clientY - drawn.screen[1]);
      if (this.isBox && way < CLICK) return this.cancel();
      // A click moves the present line there; without one the cable is taken to run upwards.
      if (way < CLICK) drawn.end = this.acrossClick(drawn.start);
      drawn.isDone = true;
      drawn.number = this.view.description.number;
      this.view.redraw();
      this.$emit("draw", {
        start: drawn.start, end: drawn.end, width: drawn.width, size: this.view.description.size,
      });
    },
    acrossClick([x, y]) {
      const angle = ((this.view.description.state?.[1] ?? 0) * Math.PI) / 180;
      return [x - 50 * Math.sin(angle), y - 50 * Math.cos(angle)];
    },
    cancel() {
      this.drawn = this.grasped = null;
      this.hint = "";
      this.view.redraw();
    },
    turn(event) {
      event.preventDefault();
      const isUp = event.deltaY < 0;
      if (this.drawn && !this.drawn.isDone) {
        if (!this.widens) return;
        this.drawn.width = Math.max(LEAST_WIDTH, this.drawn.width * (isUp ? WIDTH_STEP : 1 / WIDTH_STEP));
        this.view.redraw();
      } else if (this.view.description) {
        this.view.zoomAbout(this.view.pointAt(event), isUp ? 1.25 : 0.8);
      }
    },
    paintDrawn(context, view) {
      const { drawn } = this;
      if (!drawn) return;
      const [dx, dy] = [drawn.end[0] - drawn.start[0], drawn.end[1] - drawn.start[1]];
      const length = Math.hypot(dx, dy);
      context.strokeStyle = "#ffffff";
      context.lineWidth = 2 * view.pixel;
      context.setLineDash([6 * view.pixel, 4 * view.pixel]);
      context.beginPath();
      if (this.isBox) {
        context.rect(...drawn.start, dx, dy);
      } else if (length > 1) {
        const reach = 2 * Math.hypot(...view.description.size);
        const [ux, uy] = [dx / length, dy / length];
        for (const side of [-0.5, 0, 0.5]) {
          const [x, y] = [drawn.start[0] - side * drawn.width * uy, drawn.start[1] + side * drawn.width * ux];
          context.moveTo(x - reach * ux, y - reach * uy);
          context.lineTo(x + reach * ux, y + reach * uy);
        }
      } else {
        context.arc(...drawn.start, drawn.width / 2, 0, 2 * Math.PI);
      }
      context.stroke();
      context.setLineDash([]);
    },
  },
};
