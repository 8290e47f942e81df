// Keys that work wherever no field wants them.

const TYPING = "input:not([type=checkbox]):not([type=range]), textarea, select, [contenteditable], dialog, [role=dialog]";

export default {
  template: `<span hidden></span>`,
  emits: ["command"],
  props: { keys: Object },
  mounted() {
    this.listen = (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey) return;
      if (event.target instanceof Element && event.target.closest(TYPING)) return;
      const action = this.keys[event.shiftKey ? `Shift+${event.key}` : event.key] ?? this.keys[event.key];
      if (!action) return;
      // A button in focus is pressed by the space bar; that would act twice.
      event.preventDefault();
      this.$emit("command", { name: action });
    };
    window.addEventListener("keydown", this.listen);
    this.stop = (event) => {
      if (event.key === " " && event.target instanceof HTMLButtonElement && this.keys[" "] && !event.target.closest("[role=dialog]"))
        event.preventDefault();
    };
    window.addEventListener("keyup", this.stop);
  },
  beforeUnmount() {
    window.removeEventListener("keydown", this.listen);
    window.removeEventListener("keyup", this.stop);
  },
};
