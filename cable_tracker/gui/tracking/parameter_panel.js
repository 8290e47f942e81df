// Every parameter as a field: with unit, range and help, compared with a preset, refusals beside it.

const LARGEST_FILE = 1 << 20;

export default {
  template: `
  <section class="ct-panel ct-parameters" aria-label="Parameters">
    <h2>Parameters</h2>
    <div class="ct-tools">
      <label>compare with
        <select :value="reference" aria-label="Compare with" data-test="reference" @change="$emit('refer', { name: $event.target.value })">
          <option v-for="name in references" :key="name" :value="name">{{ name }}</option>
        </select>
      </label>
      <button type="button" class="ct-button" data-test="apply" @click="$emit('apply')"
        :title="'Set all parameters as in ' + reference">load</button>
      <span class="ct-count" data-test="differing">{{ differing.length ? differing.length + ' differ' : 'all as there' }}</span>
      <span class="ct-right"></span>
      <button type="button" class="ct-button" data-test="load-file" @click="$refs.file.click()">load file …</button>
      <input ref="file" type="file" accept=".yaml,.yml" hidden data-test="file" @change="read($event)" />
      <button type="button" class="ct-button" data-test="save" @click="$emit('save')">save …</button>
    </div>
    <div class="ct-tools">
      <input type="search" class="ct-search" v-model="sought" placeholder="search ( / )" aria-label="Search parameters"
        data-test="search" data-command="search" @keydown.escape="sought = ''; $event.target.blur()" />
      <label><input type="checkbox" v-model="onlyDiffering" data-test="only-differing" /> only differing</label>
    </div>
    <p v-if="fileTrouble" class="ct-refusal" role="alert" data-test="file-refusal">{{ fileTrouble }}
      <button type="button" class="ct-button" @click="$emit('understood')">ok</button></p>
    <div class="ct-list" data-test="parameter-list">
      <details v-for="group in shown" :key="group.title" :open="!closed.includes(group.title) || Boolean(sought) || onlyDiffering">
        <summary @click.prevent="fold(group.title)">{{ group.title }}</summary>
        <div v-for="spec in group.rows" :key="spec.name" class="ct-row" :class="{ 'ct-differs': differs(spec.name) }"
          :data-test="'row-' + spec.name">
          <label :for="'p-' + spec.name" :title="help(spec)">{{ words(spec.name) }}</label>
          <input v-if="spec.kind === 'bool'" type="checkbox" :id="'p-' + spec.name" :checked="values[spec.name]"
            :aria-describedby="'h-' + spec.name" @focus="focused = spec.name" @change="send(spec, $event.target.checked)" />
          <select v-else-if="spec.choices.length" :id="'p-' + spec.name" :value="values[spec.name]" :title="help(spec)"
            :aria-describedby="'h-' + spec.name" @focus="focused = spec.name" @change="send(spec, $event.target.value)">
            <option v-for="choice in spec.choices" :key="choice" :value="choice">{{ choice }}</option>
          </select>
          <input v-else type="text" :inputmode="spec.kind === 'str' ? 'text' : 'decimal'" :id="'p-' + spec.name" :title="help(spec)"
            autocomplete="off" spellcheck="false" :value="texts[spec.name] ?? text(values[spec.name])" :aria-describedby="'h-' + spec.name"
            :aria-invalid="Boolean(refusals[spec.name])" @focus="focused = spec.name" @input="texts[spec.name] = $event.target.value"
            @blur="commit(spec)" @keydown.enter="commit(spec)" @keydown.escape="revert(spec, $event)" />
          <span class="ct-unit">{{ spec.unit }}</span>
          <button v-if="differs(spec.name)" type="button" class="ct-reset" :data-test="'reset-' + spec.name"
            :aria-label="'Set ' + words(spec.name) + ' to ' + text(referenceValues[spec.name]) + ', as in ' + reference"
            :title="reference + ': ' + text(referenceValues[spec.name])" @click="send(spec, referenceValues[spec.name])">
            {{ text(referenceValues[spec.name]) || '""' }} ↺</button>
          <p v-if="refusals[spec.name]" class="ct-refusal" role="alert" :data-test="'refusal-' + spec.name">
            {{ refusals[spec.name] }}. In force: {{ text(values[spec.name]) }}.</p>
          <p v-show="focused === spec.name" :id="'h-' + spec.name" class="ct-help">{{ help(spec) }}</p>
        </div>
      </details>
      <p v-if="!shown.length" class="ct-help">No parameter fits.</p>
    </div>
  </section>`,
  emits: ["change", "refer", "apply", "load", "save", "understood"],
  props: {
    groups: Array, values: Object, references: Array, reference: String, referenceValues: Object, refusals: Object, fileTrouble: String,
  },
  data: () => ({ sought: "", onlyDiffering: false, texts: {}, focused: "", closed: [] }),
  computed: {
    differing() {
      return Object.keys(this.values).filter((name) => this.differs(name));
    },
    shown() {
      const sought = this.sought.trim().toLowerCase();
      return this.groups
        .map(({ title, rows }) => ({
          title,
          rows: rows.filter(
            (spec) =>
              (!sought || `${spec.name} ${this.words(spec.name)} ${spec.meaning}`.toLowerCase().includes(sought)) &&
              (!this.onlyDiffering || this.differs(spec.name)),
          ),
        }))
        .filter((group) => group.rows.length);
    },
  },
  methods: {
    words: (name) => name.replaceAll("_", " "),
    text: (value) => (value === undefined || value === null ? "" : String(value)),
    help: (spec) => `${spec.meaning} ${spec.range}${spec.unit ? " " + spec.unit : ""}; ${spec.name}`,
    differs(name) {
      return name in this.referenceValues && this.referenceValues[name] !== this.values[name];
    },
    fold(title) {
      this.closed = this.closed.includes(title) ? this.closed.filter((other) => other !== title) : [...this.closed, title];
    },
    send(spec, value) {
      delete this.texts[spec.name];
      this.$emit("change", { name: spec.name, value });
    },
    commit(spec) {
      const text = this.texts[spec.name];
      delete this.texts[spec.name];
      if (text !== undefined && text !== this.text(this.values[spec.name])) this.$emit("change", { name: spec.name, value: text });
    },
    revert(spec, event) {
      delete this.texts[spec.name];
      event.target.value = this.text(this.values[spec.name]);
      event.target.blur();
    },
    async read(event) {
      const [file] = event.target.files;
      event.target.value = "";
      if (!file) return;
      const text = file.size > LARGEST_FILE ? null : await file.text();
      this.$emit("load", { name: file.name, text });
    },
  },
};
