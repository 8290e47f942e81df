// Map and profile of a survey. All data stand in the page; nothing is fetched.
"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  if (!data.routes.length) return;
  const map = document.getElementById("map"), profile = document.getElementById("profile");
  const select = document.getElementById("route"), detail = document.getElementById("detail");
  const style = getComputedStyle(document.documentElement);
  let colours = {};
  const colour = (name) => colours[name] ??= style.getPropertyValue(name).trim();
  let pictures = null;
  const picture = (event) => {
    // Read when the first of them is looked at, so that the page opens without them.
    pictures ??= JSON.parse(document.getElementById("pictures").textContent);
    const image = document.createElement("img");
    image.src = `data:image/jpeg;base64,${pictures[event.picture]}`;
    return image;
  };
  const alarming = new Set(["crossing", "bend", "dives disagree", "navigation", "width out of the ordinary"]);
  let current = 0, view = null, chosen = -1;

  const sharpened = (canvas) => {
    const ratio = window.devicePixelRatio || 1, box = canvas.getBoundingClientRect();
    const width = Math.round(box.width * ratio), height = Math.round(box.height * ratio);
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, box.width, box.height);
    pen.font = "12px system-ui, sans-serif";
    return [pen, box.width, box.height];
  };
  const extent = (values) => {
    let least = Infinity, most = -Infinity;
    for (const value of values) {
      if (value === null) continue;
      if (value < least) least = value;
      if (value > most) most = value;
    }
    return [least, most];
  };
  const nice = (span) => {
    const power = 10 ** Math.floor(Math.log10(span));
    return [1, 2, 5, 10].map((f) => f * power).find((step) => step >= span);
  };
  const kp = (metres) => `KP ${(metres / 1000).toFixed(3)}`;

  const whole = () => {
    const route = data.routes[current], box = map.getBoundingClientRect();
    const [x0, x1] = extent(route.x), [y0, y1] = extent(route.y);
    const scale = Math.min(box.width / (x1 - x0 + 4), box.height / (y1 - y0 + 4)) * 0.92;
    view = { x: (x0 + x1) / 2, y: (y0 + y1) / 2, scale };
  };
  const toScreen = (x, y, width, height) => [
    width / 2 + (x - view.x) * view.scale, height / 2 - (y - view.y) * view.scale];

  // What as many dives see as do not is seen: one of them shows it.
  const isSeen = (share) => share >= 0.5;

  // The points that a map of this scale can show, in pieces that cross it: none nearer to the one
  // before than a pixel, unless the cable comes or goes there, and none beyond its edges.
  const level = (route, width, height) => {
    const { x, y, visible } = route, pieces = [];
    const reach = 1 / view.scale, [wide, high] = [width / 2 / view.scale + reach, height / 2 / view.scale + reach];
    const side = (k) => (x[k] < view.x - wide) | (x[k] > view.x + wide) << 1 | (y[k] < view.y - high) << 2 | (y[k] > view.y + high) << 3;
    let piece = null, before = 0, last = x.length - 1;
    for (let k = 1; k <= last; k++) {
      const near = Math.hypot(x[k] - x[before], y[k] - y[before]) < reach;
      if (near && k < last && isSeen(visible[k]) === isSeen(visible[k + 1])) continue;
      if (side(before) & side(k)) piece = null;
      else if (piece) piece.push(k);
      else pieces.push(piece = [before, k]);
      before = k;
    }
    return pieces;
  };

  // Events that would cover each other are one marker, with their number.
  const markers = (width, height) => {
    const found = [];
    data.events.forEach((event, k) => {
      if (event.route !== current) return;
      const [x, y] = toScreen(event.x, event.y, width, height);
      if (x < -20 || y < -20 || x > width + 20 || y > height + 20) return;
      const near = found[found.length - 1];
      if (near && Math.hypot(x - near.x, y - near.y) < 34) near.events.push(k);
      else found.push({ x, y, events: [k] });
    });
    return found;
  };

  const drawMap = () => {
    const [pen, width, height] = sharpened(map);
    if (!view) whole();
    const route = data.routes[current], shown = level(route, width, height);
    pen.beginPath();
    const edge = (k, side) => {
      const half = side * 1.96 * route.sigma[k];
      return toScreen(route.x[k] - half * Math.sin(route.heading[k]),
        route.y[k] + half * Math.cos(route.heading[k]), width, height);
    };
    for (const piece of shown) {
      for (let n = 0; n < piece.length; n++) pen[n ? "lineTo" : "moveTo"](...edge(piece[n], 1));
      for (let n = piece.length - 1; n >= 0; n--) pen.lineTo(...edge(piece[n], -1));
      pen.closePath();
    }
    pen.fillStyle = colour("--band");
    pen.fill();
    pen.lineWidth = 2.5;
    pen.lineJoin = "round";
    for (const seen of [true, false]) {
      pen.beginPath();
      for (const piece of shown) {
        let lifted = true;
        for (let n = 1; n < piece.length; n++) {
          if (isSeen(route.visible[piece[n]]) !== seen) { lifted = true; continue; }
          if (lifted) pen.moveTo(...toScreen(route.x[piece[n - 1]], route.y[piece[n - 1]], width, height));
          pen.lineTo(...toScreen(route.x[piece[n]], route.y[piece[n]], width, height));
          lifted = false;
        }
      }
      pen.setLineDash(seen ? [] : [5, 4]);
      pen.strokeStyle = colour(seen ? "--route" : "--buried");
      pen.stroke();
    }
    pen.setLineDash([]);
    pen.fillStyle = colour("--dim");
    const [marks, xs, ys] = route.kp;
    let last = [-1e9, -1e9];
    marks.forEach((along, k) => {
      const [x, y] = toScreen(xs[k], ys[k], width, height);
      if (Math.hypot(x - last[0], y - last[1]) < 70) return;
      last = [x, y];
      pen.beginPath();
      pen.arc(x, y, 3, 0, 7);
      pen.fill();
      pen.fillText(kp(along), x + 6, y + 24);
    });
    for (const { x, y, events } of markers(width, height)) {
      const radius = (events.length > 1 ? 9 : 5) + (events.includes(chosen) ? 3 : 0);
      pen.beginPath();
      pen.arc(x, y, radius, 0, 7);
      pen.fillStyle = colour(events.some((k) => alarming.has(data.events[k].kind)) ? "--alarm" : "--buried");
      pen.fill();
      pen.strokeStyle = colour("--paper");
      pen.lineWidth = 1.5;
      pen.stroke();
      if (events.length === 1) continue;
      pen.fillStyle = colour("--paper");
      pen.textAlign = "center";
      pen.fillText(events.length, x, y + 4);
      pen.textAlign = "start";
    }
    const bar = nice(90 / view.scale);
    pen.strokeStyle = pen.fillStyle = colour("--ink");
    pen.lineWidth = 2;
    pen.beginPath();
    pen.moveTo(14, height - 14);
    pen.lineTo(14 + bar * view.scale, height - 14);
    pen.stroke();
    pen.fillText(bar >= 1000 ? `${bar / 1000} km` : `${bar} m`, 16, height - 20);
    if (data.onEarth) pen.fillText("N ↑", width - 34, 20);
    drawLegend(pen, width, height);
  };

  const drawLegend = (pen, width, height) => {
    const kinds = [["seen", "--route", []], ["not to be seen", "--buried", [5, 4]], ["95 %", "--band", null]];
    let x = width - 14;
    for (const [words, name, dash] of kinds.reverse()) {
      x -= pen.measureText(words).width;
      pen.fillStyle = colour("--dim");
      pen.fillText(words, x, height - 12);
      x -= 28;
      if (dash === null) {
        pen.fillStyle = colour(name);
        pen.fillRect(x, height - 21, 22, 10);
      } else {
        pen.setLineDash(dash);
        pen.strokeStyle = colour(name);
        pen.lineWidth = 2.5;
        pen.beginPath();
        pen.moveTo(x, height - 16);
        pen.lineTo(x + 22, height - 16);
        pen.stroke();
        pen.setLineDash([]);
      }
      x -= 14;
    }
  };

  const rows = [
    ["diameter [m]", "diameter"], ["visible (share of dives)", "visible"],
    ["vehicle beside [m]", "aside"], ["σ across [m]", "sigma"]];
  // A line through values; of those that share a column of pixels the least and the largest.
  const trace = (pen, values, across, up) => {
    let column = NaN, least = 0, most = 0, lifted = true;
    const flush = () => {
      if (Number.isNaN(column)) return;
      if (lifted) pen.moveTo(column, up(least)); else pen.lineTo(column, up(least));
      if (most > least) pen.lineTo(column, up(most));
      lifted = false;
    };
    values.forEach((value, k) => {
      if (value === null) { flush(); column = NaN; lifted = true; return; }
      const here = Math.round(across(k));
      if (here !== column) { flush(); column = here; least = most = value; return; }
      least = Math.min(least, value);
      most = Math.max(most, value);
    });
    flush();
  };
  const drawProfile = () => {
    const [pen, width, height] = sharpened(profile);
    const route = data.routes[current], left = 60, right = width - 12;
    const end = route.along[route.along.length - 1], each = (height - 34) / rows.length;
    const x = (along) => left + (right - left) * along / end;
    const own = data.events.filter((event) => event.route === current);
    // So many would hide what they stand for: ticks above it.
    const high = own.length > (right - left) / 10 ? 6 : height - 38;
    pen.fillStyle = colour("--band");
    for (const event of own) pen.fillRect(x(event.from) - 1, 4, Math.max(2, x(event.to) - x(event.from)), high);
    if (chosen >= 0 && data.events[chosen].route === current) {
      pen.fillStyle = colour("--alarm");
      pen.fillRect(x(data.events[chosen].from) - 1, 4, 2, height - 38);
    }
    rows.forEach(([title, name], place) => {
      const values = route[name];
      const top = 20 + place * each, bottom = top + each - 26;
      const most = name === "visible" ? 1 : nice(Math.max(1e-3, extent(values)[1]));
      pen.strokeStyle = colour("--line");
      pen.lineWidth = 1;
      pen.strokeRect(left, top, right - left, bottom - top);
      pen.fillStyle = colour("--dim");
      pen.fillText(most, 8, top + 12);
      pen.fillText("0", 8, bottom);
      pen.beginPath();
      trace(pen, values, (k) => x(route.along[k]), (value) => bottom - (bottom - top) * Math.min(value / most, 1));
      pen.strokeStyle = colour("--route");
      pen.stroke();
      pen.fillStyle = colour("--ink");
      pen.fillText(title, left, top - 5);
    });
    pen.fillStyle = colour("--dim");
    const step = nice(end / Math.max(2, (right - left) / 110));
    let free = 0;
    for (let along = 0; along <= end * 1.0001; along += step) {
      const label = kp(along), size = pen.measureText(label).width;
      const start = Math.min(x(along), right - size);
      if (start < free) continue;
      pen.fillText(label, start, height - 10);
      free = start + size + 8;
    }
  };

  const draw = () => { colours = {}; drawMap(); drawProfile(); };
  const choose = (k, centre = true) => {
    const event = data.events[k];
    if (!event) return;
    chosen = k;
    if (event.route !== current) { current = event.route; select.value = String(current); view = null; whole(); }
    if (centre) {
      const box = map.getBoundingClientRect();
      view = { x: event.x, y: event.y, scale: Math.max(view.scale, Math.min(box.width, box.height) / 30) };
    }
    detail.replaceChildren();
    const add = (tag, text) => { const node = document.createElement(tag); node.textContent = text; detail.append(node); };
    add("h3", event.kind);
    add("p", event.to > event.from ? `${kp(event.from)} to ${kp(event.to)}` : kp(event.from));
    add("p", event.detail);
    add("p", event.recording);
    if (event.picture >= 0) {
      const image = picture(event);
      image.alt = `The camera's picture at the event: ${event.kind}`;
      detail.append(image);
    }
    document.querySelector("tr.chosen")?.classList.remove("chosen");
    document.querySelector(`tr.event[data-event="${k}"]`)?.classList.add("chosen");
    draw();
  };

  data.routes.forEach((route, k) => select.add(new Option(route.name, String(k))));
  select.addEventListener("change", () => { current = Number(select.value); whole(); draw(); });
  document.getElementById("whole").addEventListener("click", () => { whole(); draw(); });
  const zoom = (factor, x, y) => {
    const box = map.getBoundingClientRect(), px = x ?? box.width / 2, py = y ?? box.height / 2;
    const wx = view.x + (px - box.width / 2) / view.scale, wy = view.y - (py - box.height / 2) / view.scale;
    view.scale *= factor;
    view.x = wx - (px - box.width / 2) / view.scale;
    view.y = wy + (py - box.height / 2) / view.scale;
    drawMap();
  };
  document.getElementById("in").addEventListener("click", () => zoom(1.5));
  document.getElementById("out").addEventListener("click", () => zoom(1 / 1.5));
  map.addEventListener("wheel", (e) => { e.preventDefault(); zoom(Math.exp(-e.deltaY / 400), e.offsetX, e.offsetY); }, { passive: false });
  let drag = null;
  map.addEventListener("pointerdown", (e) => { drag = { x: e.offsetX, y: e.offsetY, moved: false }; map.setPointerCapture(e.pointerId); });
  map.addEventListener("pointermove", (e) => {
    const box = map.getBoundingClientRect();
    const wx = view.x + (e.offsetX - box.width / 2) / view.scale, wy = view.y - (e.offsetY - box.height / 2) / view.scale;
    document.getElementById("where").textContent = data.onEarth
      ? `${wx.toFixed(2)} m east, ${wy.toFixed(2)} m north` : `x ${wx.toFixed(2)} m, y ${wy.toFixed(2)} m`;
    if (!drag) return;
    const dx = e.offsetX - drag.x, dy = e.offsetY - drag.y;
    if (!drag.moved && Math.hypot(dx, dy) < 4) return;
    view.x -= dx / view.scale;
    view.y += dy / view.scale;
    drag = { x: e.offsetX, y: e.offsetY, moved: true };
    drawMap();
  });
  map.addEventListener("pointerup", (e) => {
    const clicked = drag && !drag.moved;
    drag = null;
    if (!clicked) return;
    const box = map.getBoundingClientRect();
    let best = -1, nearest = 14;
    data.events.forEach((event, k) => {
      if (event.route !== current) return;
      const [x, y] = toScreen(event.x, event.y, box.width, box.height);
      const away = Math.hypot(x - e.offsetX, y - e.offsetY);
      if (away < nearest) { nearest = away; best = k; }
    });
    if (best >= 0) choose(best, false);
  });
  profile.addEventListener("click", (e) => {
    const route = data.routes[current], box = profile.getBoundingClientRect();
    const along = (e.offsetX - 60) / (box.width - 72) * route.along[route.along.length - 1];
    let best = -1, nearest = Infinity;
    data.events.forEach((event, k) => {
      if (event.route !== current) return;
      const away = along < event.from ? event.from - along : along > event.to ? along - event.to : 0;
      if (away < nearest) { nearest = away; best = k; }
    });
    if (best >= 0) choose(best);
  });
  const table = document.getElementById("events");
  const eventOf = (node) => {
    const row = node.closest("tr.event");
    return row ? Number(row.dataset.event) : -1;
  };
  table.addEventListener("click", (e) => {
    if (eventOf(e.target) < 0) return;
    choose(eventOf(e.target));
    map.scrollIntoView({ block: "center", behavior: "smooth" });
  });
  table.addEventListener("keydown", (e) => { if (e.key === "Enter" && eventOf(e.target) >= 0) choose(eventOf(e.target)); });
  // Browsers load pictures that stand in the page at once, whatever is said of loading.
  const watcher = new IntersectionObserver((entries) => entries.forEach(({ target, isIntersecting }) => {
    if (!isIntersecting) return;
    watcher.unobserve(target);
    const image = picture(data.events[eventOf(target)]);
    image.alt = "";
    target.append(image);
  }), { scrollMargin: "200px" });
  table.querySelectorAll("td.pictured").forEach((cell) => watcher.observe(cell));
  window.addEventListener("resize", draw);
  whole();
  draw();
})();
