// One small plot for each component of the state: a line for each particle, as high as its weight.
import { Axis, fit, keepPainted, ticks } from "cable-tracker-browser";

// No eye follows plots any faster, and the picture needs the time.
const INTERVAL = 75;
const COLUMNS = 2;
const SIGMAS = 2;

export default {
  template: `
  <section class="ct-panel ct-particles" aria-label="Particles">
    <h2>Particles <span class="ct-key"><i class="ct-tick" :style="{ background: colours.particles }"></i>weight
      <i class="ct-tick" :style="{ background: colours.estimate }"></i>estimate
      <i class="ct-tick ct-dashed" :style="{ color: colours.truth }"></i>truth</span></h2>
    <canvas ref="canvas" role="img" aria-label="Distribution of the particles over each component of the state"></canvas>
  </section>`,
  props: { channel: String, names: Array, units: Array, spans: Array, truths: Number, colours: Object },
  mounted() {
    this.axes = this.spans.map((least) => new Axis(least));
    const take = (description) => (this.description = description);
    this.end = keepPainted(this.$refs.canvas, this.channel, { take, paint: () => this.paint(), interval: INTERVAL });
  },
  beforeUnmount() {
    this.end();
  },
  methods: {
    paint() {
      const { description } = this;
      const [context, width, height] = fit(this.$refs.canvas);
      if (!description) return;
      const rows = Math.ceil(this.names.length / COLUMNS);
      const [cellWidth, cellHeight] = [width / COLUMNS, height / rows];
      for (let column = 0; column < this.names.length; column++) {
        this.paintCell(context, column, {
          left: (column % COLUMNS) * cellWidth + 4,
          top: Math.floor(column / COLUMNS) * cellHeight + 2,
          width: cellWidth - 8,
          height: cellHeight - 6,
        });
      }
    },
    values(column) {
      const { rows, columns, values } = this.description.parts.cloud;
      const picked = new Float32Array(rows);
      for (let row = 0; row < rows; row++) picked[row] = values[row * columns + column];
      return picked;
    },
    paintCell(context, column, { left, top, width, height }) {
      const { description, colours } = this;
      const axis = this.axes[column];
      const picked = this.values(column);
      const marks = [description.state?.[column], column < this.truths ? description.truth?.[column] : null];
      this.makeRoom(axis, picked, marks);
      const [base, upper] = [top + height - 15, top + 17];
      const at = (value) => left + axis.at(value) * width;
      context.fillStyle = "#0c1115";
      context.fillRect(left, upper, width, base - upper);
      context.strokeStyle = "#2b3842";
      context.lineWidth = 1;
      context.beginPath();
      for (const share of [0, 0.25, 0.5, 0.75, 1]) {
        const x = Math.round(left + share * width) + 0.5;
        context.moveTo(x, upper);
        context.lineTo(x, base);
      }
      context.stroke();
      this.paintWeights(context, picked, at, [left, left + width], base, base - upper - 2);
      this.paintMark(context, at(marks[0]), marks[0], upper, base, colours.estimate, []);
      this.paintMark(context, at(marks[1]), marks[1], upper, base, colours.truth, [4, 3]);
      this.paintWords(context, column, axis, { left, top, width, base });
    },
    makeRoom(axis, picked, marks) {
      const { columns, values } = this.description.parts.cloud;
      // By weight: those that search elsewhere weigh little, and must not make the plot wide.
      let [total, mean, square] = [0, 0, 0];
      for (let row = 0; row < picked.length; row++) {
        const weight = values[row * columns + columns - 1];
        total += weight;
        mean += weight * picked[row];
        square += weight * picked[row] ** 2;
      }
      const shown = marks.filter((value) => value !== null && value !== undefined);
      if (total > 0) {
        mean /= total;
        const spread = SIGMAS * Math.sqrt(Math.max(0, square / total - mean ** 2));
        shown.push(mean - spread, mean + spread);
      }
      if (shown.length) axis.include(Math.min(...shown), Math.max(...shown));
    },
    paintWeights(context, picked, at, [left, right], base, height) {
      const { columns, values } = this.description.parts.cloud;
      context.beginPath();
      for (let row = 0; row < picked.length; row++) {
        const x = at(picked[row]);
        if (x < left || x > right) continue;
        context.moveTo(x, base);
        context.lineTo(x, base - height * values[row * columns + columns - 1]);
      }
      context.strokeStyle = this.colours.particles;
      context.globalAlpha = 0.45;
      context.stroke();
      context.globalAlpha = 1;
    },
    paintMark(context, x, value, upper, base, colour, dash) {
      if (value === null || value === undefined) return;
      context.strokeStyle = colour;
      context.lineWidth = 2;
      context.setLineDash(dash);
      context.beginPath();
      context.moveTo(x, upper);
      context.lineTo(x, base);
      context.stroke();
      context.setLineDash([]);
      context.lineWidth = 1;
    },
    paintWords(context, column, axis, { left, top, width, base }) {
      const span = axis.high - axis.low;
      context.textBaseline = "alphabetic";
      context.fillStyle = "#dbe4ea";
      context.textAlign = "left";
      context.fillText(this.names[column], left + 1, top + 12);
      context.fillStyle = "#93a5b1";
      context.textAlign = "right";
      context.fillText(this.units[column], left + width - 1, top + 12);
      [[0, "left"], [0.5, "center"], [1, "right"]].forEach(([share, align]) => {
        context.textAlign = align;
        context.fillText(ticks(axis.low + share * span, span), left + share * width, base + 12);
      });
    },
  },
};
