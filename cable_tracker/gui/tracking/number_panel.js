// The estimate and the state of the filter in numbers.
import { subscribe, throttled } from "cable-tracker-browser";

const INTERVAL = 100;
const RATE_TIME = 2000;

function digits(value, count, sign = false) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const text = value.toFixed(count);
  const plain = Number(text) === 0 ? text.replace("-", "") : text;
  return (sign && Number(plain) > 0 ? "+" : "") + plain.replace("-", "−");
}

export default {
  template: `
  <section class="ct-panel ct-numbers" aria-label="Numbers">
    <table>
      <thead><tr><th scope="col">state</th><th scope="col">estimate</th><th scope="col">σ</th><th scope="col">truth</th><th></th></tr></thead>
      <tbody>
        <tr v-for="(row, index) in rows" :key="index" :data-test="'state-' + index">
          <th scope="row">{{ names[index] }}</th>
          <td class="ct-value">{{ row[0] }}</td><td>{{ row[1] }}</td><td>{{ row[2] }}</td>
          <td class="ct-unit">{{ units[index] }}</td>
        </tr>
      </tbody>
      <tbody v-if="metres">
        <tr v-for="row in metres" :key="row[0]" :data-test="'metres-' + row[0]">
          <th scope="row">{{ row[0] }}</th>
          <td class="ct-value">{{ row[1] }}</td><td>{{ row[2] }}</td><td>–</td>
          <td class="ct-unit">{{ row[3] }}</td>
        </tr>
      </tbody>
    </table>
    <p v-if="metres" class="ct-why" data-test="no-metres" :title="detail">{{ why && "no metres: " + why }}</p>
    <dl>
      <div v-for="item in items" :key="item[0]"><dt>{{ item[0] }}</dt><dd :data-test="item[2]">{{ item[1] }}</dd></div>
    </dl>
  </section>`,
  props: { channel: String, names: Array, units: Array, truths: Number, count: Number },
  data: () => ({ rows: [], items: [], metres: null, why: "", detail: "" }),
  mounted() {
    this.drawn = [];
    this.rows = this.names.map(() => ["–", "–", "–"]);
    this.ask = throttled(() => this.show(this.description), INTERVAL);
    this.end = subscribe(this.channel, (description) => {
      this.description = description;
      this.drawn.push(performance.now());
      this.ask();
    });
  },
  beforeUnmount() {
    this.end();
    this.ask.end();
  },
  methods: {
    show(description) {
      const { state, sigma, truth } = description;
      this.rows = this.names.map((_, index) => [
        digits(state?.[index], 2, true),
        digits(sigma?.[index], 2),
        index < this.truths ? digits(truth?.[index], 2, true) : "–",
      ]);
      this.showMetres(description.metres);
      const of = this.count ? ` / ${this.count - 1}` : "";
      this.items = [
        ["frame", description.frame === null ? "live" : `${description.frame}${of}`, "frame"],
        ["time", `${digits(description.time % 100000, 2)} s`, "time"],
        ["presence", description.presence === null ? "–" : `${digits(100 * description.presence, 1)} %`, "presence"],
        ...description.facts.map(([title, value, places, name]) => [title, digits(value, places, places === 2), name]),
        ["N_eff", digits(description.n_eff, 0), "n-eff"],
        ["particles N", String(description.particle_count), "particles"],
        ["per frame", `${digits(description.ms, 1)} ms`, "ms"],
        ["tracked", `${digits(description.fps, 1)} fps`, "tracked-fps"],
        ["drawn", `${digits(this.rate(), 1)} fps`, "drawn-fps"],
      ];
    },
    /** The cable beside the vehicle; nothing where a recording holds no instruments. */
    showMetres(metres) {
      this.metres = metres && metres.rows.map(([name, value, sigma, unit]) => {
        const places = unit === "m" ? 3 : 2;
        return [name, digits(value, places, true), digits(sigma, places), unit];
      });
      this.why = metres?.why ?? "";
      this.detail = metres?.detail ?? "";
    },
    /** Pictures per second that this browser draws. */
    rate() {
      const now = performance.now();
      this.drawn = this.drawn.filter((time) => now - time < RATE_TIME);
      return this.drawn.length < 3 ? null : (1000 * (this.drawn.length - 1)) / (now - this.drawn[0]);
    },
  },
};
