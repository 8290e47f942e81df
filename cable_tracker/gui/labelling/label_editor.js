// The window in which labels are drawn. It keeps a copy of all labels, so that drawing waits for
// no answer; the server has the labels that count, and tells every browser of every change.
import {
  FrameView,
  KEYS,
  LabelGestures,
  LabelTimeline,
  drawCable,
  fromCanvas,
  labelGeometry as geometry,
  meaningOf,
  toCanvas,
  visibleRectangle,
} from "cable-tracker-browser";

const DEGREE = Math.PI / 180;
const ZOOM_STEP = 1.25;
const FIELDS = [
  { symbol: "d", unit: "px", scale: 1, digits: 2, step: 1, words: "d, distance of the centreline from the image centre" },
  { symbol: "α", unit: "deg", scale: DEGREE, digits: 2, step: 0.5, words: "alpha, angle of the centreline from vertical" },
  { symbol: "w", unit: "px", scale: 1, digits: 2, step: 1, words: "w, width between the borders" },
  { symbol: "β", unit: "deg", scale: DEGREE, digits: 2, step: 0.5, words: "beta, skew, positive if the borders converge upwards" },
];
/** Commands of which no picture is needed. What was pressed before them is done before them. */
const UNSEEN = new Set(["next", "previous", "end", "key", "unlabelled", "save", "save_as", "open", "help"]);
/** Commands that change how the shown picture is seen. */
const VIEWS = new Set(["zoom", "pan", "hide"]);
const ADVICE = {
  proposal: "Enter accepts and goes on  ·  drag the handles or press arrow keys to correct  ·  N: no cable  ·  Esc: no proposal",
  hand: "Enter: next frame  ·  drag the handles or press arrow keys to correct  ·  C copies to the next frame",
  proposed: "Enter: next frame  ·  drag the handles or press arrow keys to correct  ·  C copies to the next frame",
  interpolated: "Enter: it is right, next frame  ·  correct it, and the interpolated frames beside follow",
  no_cable: "Enter: next frame  ·  Delete takes the mark away  ·  P proposes a cable",
};
const WORDS = {
  none: "not labelled",
  waiting: "the tracker is looking …",
  proposal: "proposal, not accepted",
  hand: "drawn by hand",
  proposed: "accepted proposal",
  interpolated: "interpolated, not looked at",
  no_cable: "no cable in view",
};

export default {
  template: `
<div class="label-editor">
  <header>
    <strong class="file" :title="status.path">{{ status.name }}</strong>
    <span class="saved" :class="{ unsaved: status.changed }" data-test="saved">{{ status.changed ? "● not saved" : "saved" }}</span>
    <span class="spacer"></span>
    <button @click="press($event, 'open')" title="Ctrl O">Open…</button>
    <button @click="press($event, 'save')" title="Ctrl S">Save</button>
    <button @click="press($event, 'save_as')" title="Ctrl Shift S">Save as…</button>
    <span class="gap"></span>
    <button @click="press($event, 'undo')" :disabled="!status.can_undo" title="Ctrl Z">Undo</button>
    <button @click="press($event, 'redo')" :disabled="!status.can_redo" title="Ctrl Y">Redo</button>
    <span class="gap"></span>
    <button @click="press($event, 'help')" title="H">Keys <kbd>H</kbd></button>
  </header>
  <main>
    <div class="picture">
      <canvas ref="canvas" class="frame-canvas" tabindex="0" role="img" :aria-label="spoken"></canvas>
      <p class="badge" v-if="flag === 'no_cable'">NO CABLE</p>
      <p class="hint" v-if="hint">{{ hint }}</p>
      <p class="hint trouble" v-if="trouble">{{ trouble }}</p>
    </div>
    <aside>
      <section class="what">
        <h2>frame <b data-test="frame">{{ frame }}</b> of 0–{{ lastFrame }}</h2>
        <p>{{ seconds }}</p>
        <p class="kind" :class="flag" data-test="kind"><i></i>{{ words }}</p>
        <p class="how">{{ how }}</p>
      </section>
      <section class="fields" aria-label="numbers of the label">
        <label v-for="(field, i) in fields" :key="field.symbol" :title="field.words">
          <span>{{ field.symbol }}</span>
          <input type="number" :step="field.step" :value="texts[i] ?? values[i]" :disabled="!shown" :aria-label="field.words + ', ' + field.unit"
            :data-test="field.symbol" @input="texts[i] = $event.target.value" @change="type(i, $event)" @keydown.enter.stop="enter($event)" />
          <small>{{ field.unit }}</small>
        </label>
      </section>
      <section class="actions">
        <button class="main" @click="press($event, 'accept')"><span>Accept, next</span><kbd>Enter</kbd></button>
        <button @click="press($event, 'propose')"><span>Propose</span><kbd>P</kbd></button>
        <button @click="press($event, 'copy')"><span>Copy to next</span><kbd>C</kbd></button>
        <button @click="press($event, 'interpolate')"><span>Interpolate</span><kbd>I</kbd></button>
        <button @click="press($event, 'none')"><span>No cable</span><kbd>N</kbd></button>
        <button @click="press($event, 'clear')"><span>Clear</span><kbd>Del</kbd></button>
        <label class="check"><input type="checkbox" v-model="automatic" @change="automaticChanged" /> propose automatically</label>
      </section>
      <section class="counts" aria-label="progress">
        <p v-for="kind in ['hand', 'proposed', 'interpolated', 'no_cable', 'none']" :key="kind" class="kind" :class="kind">
          <i></i>{{ wordsOf(kind) }}<b>{{ counts[kind] }}</b>
        </p>
      </section>
    </aside>
  </main>
  <p class="message" :class="message.kind" role="status" aria-live="polite" data-test="message">
    {{ message.text }}<span v-if="!message.text" class="advice">{{ advice }}</span>
  </p>
  <footer>
    <button @click="press($event, 'previous')" aria-label="frame before" title="PageUp">◀</button>
    <canvas ref="timeline" class="timeline" tabindex="0" role="slider" aria-label="frame" aria-valuemin="0"
      :aria-valuemax="lastFrame" :aria-valuenow="frame" @keydown="slide"></canvas>
    <button @click="press($event, 'next')" aria-label="next frame" title="PageDown">▶</button>
  </footer>
  <dialog ref="help" class="help" @click="closeHelp($event)">
    <h2>Keys</h2>
    <div class="groups">
      <section v-for="group in groups" :key="group">
        <h3>{{ group }}</h3>
        <dl><template v-for="row in keysOf(group)" :key="row.keys"><dt><kbd v-for="key in row.keys">{{ key }}</kbd></dt><dd>{{ row.words }}</dd></template></dl>
      </section>
      <section>
        <h3>Mouse, pen, fingers</h3>
        <dl>
          <dt>drag on the cable</dt><dd>move it</dd>
          <dt>○</dt><dd>turn</dd>
          <dt>◇</dt><dd>move one border (Shift: both)</dd>
          <dt>△</dt><dd>skew</dd>
          <dt>drag where no label is</dt><dd>draw the centreline</dd>
          <dt>drag beside the cable</dt><dd>move the zoomed picture</dd>
          <dt>wheel, two fingers</dt><dd>zoom</dd>
        </dl>
      </section>
    </div>
    <form method="dialog"><button autofocus>Close</button></form>
  </dialog>
</div>`,
  props: { channel: String, recording: String, colours: Object },
  data: () => ({
    frame: 0,
    stamp: null,
    trouble: "",
    count: 1,
    shown: null,
    flag: "none",
    how: "",
    automatic: true,
    message: { text: "", kind: "" },
    status: { path: "", name: "", changed: false, can_undo: false, can_redo: false },
    counts: { hand: 0, proposed: 0, interpolated: 0, no_cable: 0, none: 0 },
    fields: FIELDS,
    // What is being typed: news from the server must not take it away.
    texts: {},
  }),
  computed: {
    lastFrame() {
      return this.count - 1;
    },
    seconds() {
      return this.stamp === null ? "" : `${this.stamp.slice(0, -6)} s`;
    },
    words() {
      return WORDS[this.flag];
    },
    values() {
      return FIELDS.map(({ scale, digits }, i) => (this.shown ? String(+(this.shown[i] / scale).toFixed(digits)) : ""));
    },
    spoken() {
      const numbers = FIELDS.map(({ symbol, unit }, i) => `${symbol} ${this.values[i]} ${unit}`).join(", ");
      return `frame ${this.frame}, ${this.words}${this.shown ? `, ${numbers}` : ""}`;
    },
    hint() {
      if (this.flag !== "none" || this.trouble) return "";
      return "Drag along the cable to draw it  ·  P proposes  ·  N: there is no cable";
    },
    advice() {
      return ADVICE[this.flag] ?? "";
    },
    groups() {
      return [...new Set(KEYS.map(({ group }) => group))];
    },
  },
  created() {
    // Not watched by Vue: it would cost time at every stroke.
    this.labels = new Map();
    this.outstanding = new Map();
    this.serial = 0;
    this.wanted = 0;
    this.request = 0;
    this.hasPicture = false;
    this.proposal = null;
    this.asked = null;
    this.drag = null;
    this.queue = [];
    this.ledTo = null;
    this.isHidden = false;
    this.places = `cable_tracker.label ${this.recording}`;
  },
  mounted() {
    this.automatic = sessionStorage.getItem(`${this.places} automatic`) !== "no";
    this.view = new FrameView(this.$refs.canvas, this.channel, {
      draw: (context, view) => this.draw(context, view),
      received: (description) => this.received(description),
    });
    this.gestures = new LabelGestures(this.view, {
      find: (point, reach) => this.find(this.inImage(point), reach),
      begin: (found, point) => this.beginDrag(found, this.inImage(point)),
      move: (point, both) => this.moveDrag(this.inImage(point), both),
      end: () => this.endDrag(),
      cancel: () => this.cancelDrag(),
    });
    this.timeline = new LabelTimeline(this.$refs.timeline, this.colours, (frame) => this.go(frame));
    this.onKey = (event) => this.keyDown(event);
    this.onKeyUp = () => this.isHidden && this.hide(false);
    window.addEventListener("keydown", this.onKey);
    window.addEventListener("keyup", this.onKeyUp);
    window.addEventListener("blur", this.onKeyUp);
    this.$el.editor = this;
    const remembered = Number(sessionStorage.getItem(this.places));
    // Of how many frames it is, the server says before it sends the picture.
    this.wanted = Number.isSafeInteger(remembered) ? Math.max(0, remembered) : 0;
    this.$refs.canvas.focus();
    this.$emit("ready", { frame: this.wanted, request: this.request });
  },
  beforeUnmount() {
    window.removeEventListener("keydown", this.onKey);
    window.removeEventListener("keyup", this.onKeyUp);
    window.removeEventListener("blur", this.onKeyUp);
    this.timeline.close();
    this.view.close();
  },
  methods: {
    // ---------------------------------------------------------------- what the server says
    /** All labels, and how things stand. */
    load({ labels, ...news }) {
      this.labels = new Map();
      this.outstanding.clear();
      this.proposal = this.asked = null;
      this.update({ labels, serial: this.serial, ...news });
    },
    /** Changed labels as [frame, flag, state]; without a flag a label is gone. */
    update({ labels, serial, count, ...status }) {
      for (const [frame, flag, state] of labels) {
        // A change of this browser's own that is still on its way is newer than this.
        if ((this.outstanding.get(frame) ?? 0) > serial) continue;
        if (flag) this.labels.set(frame, { flag, state });
        else this.labels.delete(frame);
        if (frame === this.frame && flag && !this.outstanding.has(frame)) this.proposal = this.asked = null;
      }
      for (const [frame, last] of this.outstanding) if (last <= serial) this.outstanding.delete(frame);
      this.setCount(count);
      this.status = { ...this.status, ...status, changed: status.changed || this.outstanding.size > 0 };
      this.showLabel();
      if (this.flag === "none") this.proposeByItself();
    },
    /** The number of frames. A frame that the recording no longer has is wanted no more. */
    setCount(count) {
      this.count = count;
      const last = Math.max(0, this.lastFrame);
      if (this.wanted <= last) return;
      this.dropWaiting();
      this.wanted = last;
      if (this.hasPicture) this.go(this.wanted);
    },
    /** Another frame, as the server wants it. */
    goTo(frame) {
      if (frame !== this.wanted) this.dropWaiting();
      this.ledTo = frame;
      this.go(frame);
    },
    /** Strokes that wait were meant for the frame that was wanted, and for no other. */
    dropWaiting() {
      if (!this.queue.length) return;
      this.queue = [];
      // Why the server shows another frame is told already, or will be.
      if (this.message.kind === "error") return;
      this.say({ text: `frame ${this.wanted} is not shown: what was pressed for it is not done`, kind: "warning" });
    },
    /** The newest request is answered, perhaps by another frame than the one that was asked for. */
    settle(frame) {
      if (frame === this.wanted) return;
      this.dropWaiting();
      this.wanted = frame;
    },
    proposed({ frame, state, message }) {
      const isWanted = this.asked === frame && frame === this.frame;
      if (this.asked === frame) this.asked = null;
      if (!isWanted || this.drag) return;
      this.proposal = state ? { state, message } : null;
      if (!state) this.say({ text: message, kind: "warning" });
      this.showLabel();
    },
    say(message) {
      this.message = message;
    },
    received(description) {
      const isOther = !this.hasPicture || description.frame !== this.frame;
      this.hasPicture = true;
      // The same picture comes again after a reconnection: the hand on it goes on.
      if (isOther) this.cancelDrag();
      this.frame = description.frame;
      this.stamp = description.stamp;
      this.trouble = description.trouble;
      sessionStorage.setItem(this.places, String(this.frame));
      if (isOther) {
        this.proposal = this.asked = null;
        this.dismissed = false;
        this.texts = {};
        // Why the server has led here must be read first.
        const isExplained = this.ledTo === this.frame && this.message.kind === "error";
        if (!isExplained) this.message = { text: description.note, kind: "warning" };
      }
      this.ledTo = null;
      if (description.request === this.request) this.settle(this.frame);
      this.showLabel();
      this.executeQueue();
      this.proposeByItself();
    },
    // ---------------------------------------------------------------- what is shown
    /** Bring numbers, colours and the picture up to date with the label of this frame. */
    showLabel() {
      const label = this.labels.get(this.frame);
      const without = this.asked === this.frame ? "waiting" : "none";
      this.flag = this.proposal ? "proposal" : label?.flag ?? without;
      this.shown = this.drag?.state ?? this.proposal?.state ?? label?.state ?? null;
      this.how = this.proposal?.message ?? "";
      if (!this.drag) this.showCounts();
      this.view.redraw();
    },
    showCounts() {
      const counts = { hand: 0, proposed: 0, interpolated: 0, no_cable: 0 };
      for (const { flag } of this.labels.values()) counts[flag] += 1;
      this.counts = { ...counts, none: Math.max(0, this.count - this.labels.size) };
      this.timeline.show({ labels: this.labels, count: this.count, frame: this.frame });
    },
    wordsOf: (kind) => WORDS[kind].split(",")[0],
    keysOf: (group) => KEYS.filter((row) => row.group === group),
    draw(context, view) {
      if (!this.shown || this.isHidden) return;
      const colour = this.colours[this.drag ? "hand" : this.flag] ?? this.colours.hand;
      const dash = this.flag === "proposal" && !this.drag ? [9, 6] : [];
      const width = this.flag === "interpolated" && !this.drag ? 1.5 : 2;
      drawCable(context, view, this.shown, { colour, width, dash }, this.drag?.handle);
    },
    inImage(point) {
      return fromCanvas(point, this.view.description.size);
    },
    // ---------------------------------------------------------------- edits
    get() {
      return this.labels.get(this.frame);
    },
    /** Label a frame here and now, and tell the server. */
    commit(label, { merges = false, frame = this.frame } = {}) {
      if (label) this.labels.set(frame, label);
      else this.labels.delete(frame);
      this.proposal = this.asked = null;
      this.message = { text: "", kind: "" };
      this.status.changed = true;
      this.serial += 1;
      this.outstanding.set(frame, this.serial);
      this.$emit("commit", { serial: this.serial, frame, label, merges });
      this.showLabel();
    },
    commitState(state, merges = false) {
      this.commit({ flag: "hand", state }, { merges });
    },
    /** What an edit starts from: this label, the proposal, the last label before, or the middle. */
    startState() {
      return this.shown ?? this.stateBefore() ?? [0, 0, this.usualWidth(), 0];
    },
    stateBefore() {
      const frames = [...this.labels.keys()].filter((frame) => frame < this.frame && this.labels.get(frame).state);
      return frames.length ? this.labels.get(frames.reduce((a, b) => Math.max(a, b))).state : null;
    },
    usualWidth() {
      return this.stateBefore()?.[2] ?? Math.round(this.view.description.size[0] / 8);
    },
    middleOf(state) {
      return geometry.handlesOf(state, visibleRectangle(this.view)).along;
    },
    find(point, reach) {
      if (!this.shown) return this.get() || this.trouble ? null : { kind: "draw" };
      const { along, points } = geometry.handlesOf(this.shown, visibleRectangle(this.view));
      const away = ({ at }) => Math.hypot(at[0] - point[0], at[1] - point[1]);
      const nearest = points.reduce((a, b) => (away(b) < away(a) ? b : a));
      if (away(nearest) <= reach) return { ...nearest, along };
      return geometry.isOn(this.shown, point, reach / 3) ? { kind: "move", along } : null;
    },
    beginDrag(handle, from) {
      this.drag = { handle, from, start: this.shown, state: this.shown };
    },
    moveDrag(to, both) {
      if (!this.drag) return; // cancelled while the button is still down
      const { handle, from, start } = this.drag;
      this.drag.state =
        handle.kind === "draw"
          ? geometry.cableThrough(from, to, this.usualWidth())
          : geometry.dragged(start, handle, handle.along, from, to, both);
      this.shown = this.drag.state;
      this.view.redraw();
    },
    endDrag() {
      if (!this.drag) return;
      const { state, start } = this.drag;
      this.drag = null;
      if (state && state !== start) this.commitState(state);
      else this.showLabel();
    },
    cancelDrag() {
      if (!this.drag) return;
      this.drag = null;
      this.showLabel();
    },
    type(i, event) {
      // The browser takes a number that another frame has put there for a change, too.
      if (!(i in this.texts)) return;
      delete this.texts[i];
      const value = Number(event.target.value) * FIELDS[i].scale;
      if (!this.shown || event.target.value === "" || !Number.isFinite(value)) {
        event.target.value = this.values[i];
        return;
      }
      const state = [...this.shown];
      state[i] = value;
      const limited = geometry.limitState(state);
      // d and alpha have other names for one line; a width and a skew are what they are.
      if (i > 1 && Math.abs(limited[i] - value) > 1e-9) {
        this.say({ text: `${FIELDS[i].symbol} cannot be ${event.target.value} ${FIELDS[i].unit}`, kind: "warning" });
        event.target.value = this.values[i];
        return;
      }
      this.commitState(limited);
      this.$nextTick(() => (event.target.value = this.values[i]));
    },
    /** Take the number that stands in a field for the frame that is shown; the field stays in use. */
    takeTyped(field) {
      field.blur();
      field.focus();
    },
    enter(event) {
      event.target.blur();
      this.$refs.canvas.focus();
    },
    // ---------------------------------------------------------------- commands
    go(frame) {
      const wanted = Math.min(this.lastFrame, Math.max(0, frame));
      if (wanted !== this.wanted) this.finishWaiting();
      this.wanted = wanted;
      this.request += 1;
      this.timeline.show({ frame: this.wanted });
      this.$emit("go", { frame: this.wanted, request: this.request });
    },
    press(event, name) {
      this.command({ does: name, key: "", large: event.shiftKey });
      // Keys belong to the picture again; who came here by the keyboard stays.
      if (event.detail && name !== "help") this.$refs.canvas.focus();
    },
    keyDown(event) {
      if (event.defaultPrevented || this.$refs.help.open || document.querySelector(".q-dialog")) return;
      const { target } = event;
      const types = target.matches?.("input[type=number], textarea, input[type=text]");
      const presses = target.matches?.("button") && ["Enter", " "].includes(event.key);
      const meaning = meaningOf(event);
      if (!meaning || presses || (types && !event.ctrlKey && !event.metaKey && !event.key.startsWith("Page"))) return;
      event.preventDefault();
      if (types) this.takeTyped(target);
      this.command({ ...meaning, isRepeated: event.repeat });
    },
    slide(event) {
      const steps = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 };
      if (!(event.key in steps) || event.altKey) return;
      event.preventDefault();
      this.go(this.wanted + steps[event.key] * (event.shiftKey ? 10 : 1));
    },
    /** Do something now, or when the frame that it is meant for is shown. */
    command(wanted) {
      if (UNSEEN.has(wanted.does)) {
        this.finishWaiting();
        this.execute(wanted);
        return;
      }
      if (!this.hasPicture) return;
      const isOnItsWay = this.wanted !== this.frame;
      // What was not seen is not accepted.
      if (isOnItsWay && wanted.does === "accept" && !this.queue.length) return;
      if (isOnItsWay && !VIEWS.has(wanted.does)) this.queue.push(wanted);
      else this.execute(wanted);
    },
    executeQueue() {
      while (this.queue.length && this.wanted === this.frame) this.execute(this.queue.shift());
    },
    /** Do what waits for a frame before that is left or saved, shown or not: the hand is faster than pictures. */
    finishWaiting() {
      if (!this.queue.length) return;
      this.cancelDrag();
      const { frame, proposal, asked } = this;
      const strokes = this.queue;
      this.queue = [];
      for (const stroke of strokes) {
        this.frame = this.wanted;
        this.proposal = this.asked = null;
        this.showLabel();
        this.execute(stroke);
      }
      Object.assign(this, { frame, proposal, asked });
      this.showLabel();
    },
    execute({ does, key, large, isRepeated = false }) {
      const step = large ? 10 : 1;
      const local = {
        accept: () => isRepeated || this.accept(),
        next: () => this.go(this.wanted + step),
        previous: () => this.go(this.wanted - step),
        end: () => this.go(key === "Home" ? 0 : this.lastFrame),
        key: () => this.goToKey(key === "j" ? -1 : 1),
        unlabelled: () => this.goToUnlabelled(),
        move: () => this.move(key, step, isRepeated),
        turn: () => this.step({ turn: (key === "q" ? 1 : -1) * step * 0.5 * DEGREE }, isRepeated),
        skew: () => this.step({ skew: (key === "d" ? 1 : -1) * step * 0.5 * DEGREE }, isRepeated),
        none: () => this.commit({ flag: "no_cable", state: null }),
        clear: () => this.get() && this.commit(null),
        dismiss: () => this.dismiss(),
        propose: () => this.propose(),
        copy: () => this.copy(),
        hide: () => this.hide(true),
        zoom: () => this.zoom(key),
        pan: () => this.pan(key),
        help: () => this.$refs.help.showModal(),
      }[does];
      if (local) local();
      else this.$emit("command", { name: does, frame: this.frame, everywhere: large });
    },
    step(change, isRepeated) {
      const state = this.startState();
      if (!this.shown) this.commitState(state);
      else this.commitState(geometry.stepped(state, change, this.middleOf(state)), isRepeated);
    },
    /** Arrows across the cable move it, along it make it wider. */
    move(key, step, isRepeated) {
      const [, alpha] = this.startState();
      const isUpright = Math.abs(alpha) <= Math.PI / 4;
      const sign = key === "ArrowRight" || key === "ArrowUp" ? 1 : -1;
      const isAcross = isUpright === (key === "ArrowLeft" || key === "ArrowRight");
      const towards = isUpright ? 1 : Math.sign(Math.sin(alpha));
      this.step(isAcross ? { across: sign * step * towards } : { wider: sign * step }, isRepeated);
    },
    /** Take what is drawn for the label of this frame, and go on. What was not shown is not taken. */
    accept() {
      const label = this.get();
      if (!label && !this.proposal) {
        const text = this.flag === "waiting" ? "the proposal is on its way" : "nothing is drawn here yet";
        this.say({ text, kind: "warning" });
        return;
      }
      if (this.proposal) this.commit({ flag: "proposed", state: this.proposal.state });
      else if (label.flag === "interpolated") this.commitState(label.state);
      this.go(this.frame + 1);
    },
    copy() {
      const label = this.get();
      const next = this.frame + 1;
      if (!label || next >= this.count) {
        this.say({ text: label ? "this is the last frame" : "this frame has no label to copy", kind: "warning" });
        return;
      }
      this.commit({ flag: label.state ? "hand" : "no_cable", state: label.state }, { frame: next });
      this.go(next);
    },
    dismiss() {
      this.cancelDrag();
      this.proposal = this.asked = null;
      this.dismissed = true;
      this.showLabel();
    },
    propose() {
      this.asked = this.frame;
      this.$emit("command", { name: "propose", frame: this.frame, everywhere: false });
      this.showLabel();
    },
    proposeByItself() {
      const wants = this.automatic && !this.dismissed && !this.trouble && !this.drag;
      const isFree = !this.get() && !this.proposal && this.asked !== this.frame;
      if (wants && isFree && this.hasPicture) this.propose();
    },
    automaticChanged() {
      sessionStorage.setItem(`${this.places} automatic`, this.automatic ? "yes" : "no");
      this.dismissed = false;
      this.proposeByItself();
    },
    goToKey(direction) {
      const keys = [...this.labels].filter(([, { flag }]) => flag !== "interpolated").map(([frame]) => frame);
      const beyond = keys.filter((frame) => (frame - this.wanted) * direction > 0);
      const nearer = direction > 0 ? Math.min : Math.max;
      // Not handed over one by one: there may be more labels than a function can have arguments.
      if (beyond.length) this.go(beyond.reduce((a, b) => nearer(a, b)));
    },
    goToUnlabelled() {
      for (let i = 1; i <= this.count; i++) {
        const frame = (this.wanted + i) % this.count;
        if (!this.labels.has(frame)) return this.go(frame);
      }
      return this.say({ text: "every frame has a label", kind: "" });
    },
    zoom(key) {
      if (key === "0") return this.view.resetZoom();
      const centre = this.shown && geometry.handlesOf(this.shown, visibleRectangle(this.view)).points[0].at;
      const about = centre ? toCanvas(centre, this.view.description.size) : this.view.middle;
      return this.view.zoomAbout(about, key === "-" ? 1 / ZOOM_STEP : ZOOM_STEP);
    },
    hide(isHidden) {
      this.isHidden = isHidden;
      this.view.redraw();
    },
    pan(key) {
      const [x, y] = this.view.middle;
      const step = 60 / this.view.scale;
      const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
      this.view.moveTo([x + ways[key][0] * step, y + ways[key][1] * step]);
    },
    closeHelp(event) {
      if (event.target === this.$refs.help) this.$refs.help.close();
    },
  },
};
