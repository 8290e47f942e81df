// Play, pause, step, seek and speed of a recording.
import { subscribe } from "cable-tracker-browser";

const ICONS = {
  start: "M4 4h2v12H4zM16 4v12L7 10z",
  back: "M12 4v12L4 10zM14 4h2v12h-2z",
  play: "M5 3l12 7-12 7z",
  pause: "M5 4h4v12H5zM11 4h4v12h-4z",
  next: "M8 4l8 6-8 6zM4 4h2v12H4z",
  end: "M14 4h2v12h-2zM4 4l9 6-9 6z",
};

/** Keys that mean something to a slider in focus. */
const OWN_KEYS = new Set(["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End", "PageUp", "PageDown", " "]);

export default {
  template: `
  <section class="ct-panel ct-transport" aria-label="Playing">
    <button v-for="button in buttons" :key="button.name" type="button" class="ct-icon" :class="{ 'ct-main': button.main }"
      :aria-label="button.title" :title="button.title + ' (' + button.key + ')'" :data-test="button.name"
      @click="$emit('command', { name: button.name })">
      <svg viewBox="0 0 20 20" width="18" height="18" aria-hidden="true"><path :d="button.icon" fill="currentColor" /></svg>
    </button>
    <input ref="slider" class="ct-slider" type="range" min="0" :max="last" step="1" aria-label="Frame" data-test="slider"
      @input="seek($event.target.value)" @keydown="keepKeys" />
    <input class="ct-short" type="text" inputmode="numeric" aria-label="Go to frame" data-test="frame-field" ref="field"
      @change="seek($event.target.value); $event.target.blur()" @keydown.escape="$event.target.blur()" />
    <span class="ct-of">/ {{ count ? last : "?" }}</span>
    <select aria-label="Speed" title="Speed (+ and −)" data-test="speed" :value="String(speed)"
      @change="$emit('command', { name: 'speed', value: $event.target.value }); $event.target.blur()">
      <option v-for="one in speeds" :key="one" :value="one">{{ one === "max" ? "as fast as can be" : one + " ×" }}</option>
    </select>
  </section>`,
  emits: ["command"],
  props: { channel: String, playing: Boolean, speed: String, speeds: Array, count: Number },
  computed: {
    last() {
      return Math.max(0, (this.count ?? 1) - 1);
    },
    buttons() {
      return [
        { name: "first", title: "First frame", key: "Home", icon: ICONS.start },
        { name: "back", title: "One frame back", key: "←", icon: ICONS.back },
        this.playing
          ? { name: "pause", title: "Pause", key: "space", icon: ICONS.pause, main: true }
          : { name: "play", title: "Play", key: "space", icon: ICONS.play, main: true },
        { name: "forward", title: "One frame on", key: "→", icon: ICONS.next },
        { name: "last", title: "Last frame", key: "End", icon: ICONS.end },
      ];
    },
  },
  mounted() {
    this.end = subscribe(this.channel, ({ frame }) => {
      if (frame === null) return;
      this.shown = frame;
      // What the user is moving stays in the user's hand.
      if (document.activeElement !== this.$refs.field) this.$refs.field.value = frame;
      if (!this.wanted || this.wanted === frame || performance.now() - this.asked > 1000) {
        this.$refs.slider.value = frame;
        this.wanted = null;
      }
    });
  },
  beforeUnmount() {
    this.end();
  },
  methods: {
    seek(text) {
      const typed = Number(text);
      const isFrame = String(text).trim() !== "" && Number.isFinite(typed);
      // What is no frame, or beyond the last one, does not stay in the field.
      const frame = isFrame ? Math.min(this.count ? this.last : Infinity, Math.max(0, Math.round(typed))) : this.shown;
      this.$refs.field.value = this.$refs.slider.value = frame;
      if (!isFrame) return;
      this.wanted = frame;
      this.asked = performance.now();
      this.$emit("command", { name: "seek", value: frame });
    },
    /** What moves the slider itself is no command; the space bar still plays. */
    keepKeys(event) {
      if (OWN_KEYS.has(event.key)) event.stopPropagation();
      if (event.key !== " ") return;
      event.preventDefault();
      this.$emit("command", { name: "toggle" });
    },
  },
};
