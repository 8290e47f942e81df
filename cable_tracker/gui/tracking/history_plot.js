// The last half minute: two components of the state with their bands, status and presence, N_eff, time per frame.
import { Axis, fit, keepPainted, ticks } from "cable-tracker-browser";

const INTERVAL = 150;
const SECONDS = 30;
const LONGEST_GAP = 0.6;
const USUAL_GAP = 0.04;
const LEFT = 60;
const BOTTOM = 15;
const MOST = 0.98;
const COLUMN = {
  time: 0, first: 1, second: 2, firstSigma: 3, secondSigma: 4, presence: 5, status: 6, nEff: 7, ms: 8, trueFirst: 9, trueSecond: 10,
};

export default {
  template: `
  <section class="ct-panel ct-history" aria-label="History of the last 30 seconds">
    <canvas ref="canvas" role="img" :aria-label="lanes[0][0] + ', ' + lanes[1][0] + ', presence, N_eff and time per frame over the last 30 seconds'"></canvas>
  </section>`,
  props: { channel: String, colours: Object, statuses: Array, lanes: Array },
  mounted() {
    this.rows = [];
    const [first, second] = this.lanes.map(([, span]) => new Axis(span));
    this.axes = { first, second, nEff: new Axis(10, { zero: true }), ms: new Axis(1, { zero: true }) };
    const take = (description) => this.merge(description);
    this.end = keepPainted(this.$refs.canvas, this.channel, { take, paint: () => this.paint(), interval: INTERVAL });
  },
  beforeUnmount() {
    this.end();
  },
  methods: {
    /** Rows of the packet take the place of all that are as late or later. */
    merge({ time, parts, history_is_whole: isWhole }) {
      const { rows, columns, values } = parts.history;
      const fresh = [];
      for (let row = 0; row < rows; row++) {
        const numbers = Array.from(values.subarray(row * columns, (row + 1) * columns));
        numbers[COLUMN.time] += time;
        fresh.push(numbers);
      }
      const first = fresh.length ? fresh[0][COLUMN.time] - 1e-4 : time;
      const kept = isWhole ? [] : this.rows.filter((row) => row[0] < first && row[0] > time - SECONDS);
      this.rows = kept.concat(fresh);
      this.now = time;
    },
    paint() {
      const [context, width, height] = fit(this.$refs.canvas);
      if (this.now === undefined) return;
      const strip = 16;
      const lane = (height - BOTTOM - strip - 4) / 4;
      this.at = (time) => LEFT + (1 + (time - this.now) / SECONDS) * (width - LEFT - 6);
      this.right = width - 6;
      this.paintSeconds(context, height);
      this.paintStatus(context, 2, strip - 4);
      let top = strip + 2;
      this.paintLane(context, this.lanes[0][0], "first", top, lane, this.colours.estimate, "firstSigma", "trueFirst");
      this.paintLane(context, this.lanes[1][0], "second", (top += lane), lane, this.colours.estimate, "secondSigma", "trueSecond");
      this.paintLane(context, "N_eff", "nEff", (top += lane), lane, this.colours.particles);
      this.paintLane(context, "ms", "ms", (top += lane), lane, this.colours.initialising);
    },
    paintSeconds(context, height) {
      context.fillStyle = "#93a5b1";
      context.strokeStyle = "#26323b";
      context.textBaseline = "alphabetic";
      context.beginPath();
      for (let second = 0; second <= SECONDS; second += 5) {
        const x = Math.round(this.at(this.now - second)) + 0.5;
        context.moveTo(x, 0);
        context.lineTo(x, height - BOTTOM);
        context.textAlign = second === 0 ? "right" : "center";
        context.fillText(second === 0 ? "0 s" : `−${second}`, x, height - 3);
      }
      context.stroke();
    },
    /** Colour says the status; the height of the bar is the presence. */
    paintStatus(context, top, height) {
      context.fillStyle = "#93a5b1";
      context.textAlign = "right";
      context.textBaseline = "middle";
      context.fillText("presence", LEFT - 4, top + height / 2);
      for (let row = 0; row < this.rows.length; row++) {
        const { time, status, presence } = COLUMN;
        const here = this.rows[row];
        const next = this.rows[row + 1]?.[time] ?? here[time] + USUAL_GAP;
        const wide = next - here[time] > LONGEST_GAP ? USUAL_GAP : next - here[time];
        const share = Number.isFinite(here[presence]) ? 0.25 + 0.75 * here[presence] : 1;
        context.fillStyle = this.statuses[here[status]] ?? "#aaaaaa";
        const x = Math.max(LEFT, this.at(here[time]));
        const end = Math.min(this.right, this.at(here[time] + wide));
        if (end > x) context.fillRect(x, top + height * (1 - share), Math.max(1, end - x + 0.3), height * share);
      }
    },
    paintLane(context, title, name, top, height, colour, sigma, truth) {
      const axis = this.axes[name];
      const [column, spread, real] = [COLUMN[name], COLUMN[sigma], COLUMN[truth]];
      const seen = this.rows.flatMap((row) => [row[column], row[real]]).filter((value) => Number.isFinite(value)).sort((a, b) => a - b);
      // A single slow frame must not flatten all others.
      const last = name === "ms" ? Math.floor((seen.length - 1) * MOST) : seen.length - 1;
      axis.include(seen[0], seen[last]);
      const upper = top + 3;
      const inner = height - 6;
      const y = (value) => upper + (1 - Math.min(1, Math.max(0, axis.at(value)))) * inner;
      context.fillStyle = "#0c1115";
      context.globalAlpha = 0.6;
      context.fillRect(LEFT, upper, this.right - LEFT, inner);
      context.globalAlpha = 1;
      this.paintLabels(context, title, axis, upper, inner);
      if (sigma) this.paintBand(context, column, spread, y, colour);
      if (real) this.paintLine(context, real, y, this.colours.truth, [4, 3]);
      this.paintLine(context, column, y, colour, []);
    },
    paintLabels(context, title, axis, top, height) {
      const span = axis.high - axis.low;
      context.textAlign = "right";
      context.fillStyle = "#dbe4ea";
      context.textBaseline = "middle";
      context.fillText(title, LEFT - 4, top + height / 2);
      if (height < 36 || !span) return;
      context.fillStyle = "#93a5b1";
      context.textBaseline = "top";
      context.fillText(ticks(axis.high, span), LEFT - 4, top - 1);
      context.textBaseline = "bottom";
      context.fillText(ticks(axis.low, span), LEFT - 4, top + height + 1);
    },
    *pieces(column) {
      let piece = [];
      for (const row of this.rows) {
        const isWhole = Number.isFinite(row[column]);
        const before = piece[piece.length - 1];
        if (piece.length && (!isWhole || row[0] - before[0] > LONGEST_GAP)) {
          yield piece;
          piece = [];
        }
        if (isWhole && this.at(row[0]) >= LEFT) piece.push(row);
      }
      if (piece.length) yield piece;
    },
    paintLine(context, column, y, colour, dash) {
      context.strokeStyle = colour;
      context.lineWidth = 1.5;
      context.setLineDash(dash);
      context.beginPath();
      for (const piece of this.pieces(column)) {
        context.moveTo(this.at(piece[0][0]) - 0.5, y(piece[0][column]));
        for (const row of piece) context.lineTo(this.at(row[0]), y(row[column]));
      }
      context.stroke();
      context.setLineDash([]);
      context.lineWidth = 1;
    },
    paintBand(context, column, spread, y, colour) {
      context.fillStyle = colour;
      context.globalAlpha = 0.25;
      for (const piece of this.pieces(column)) {
        context.beginPath();
        for (const row of piece) context.lineTo(this.at(row[0]), y(row[column] + 2 * row[spread]));
        for (const row of piece.toReversed()) context.lineTo(this.at(row[0]), y(row[column] - 2 * row[spread]));
        context.fill();
      }
      context.globalAlpha = 1;
    },
  },
};
