// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The script of machine_scene_html(): adds modes up, draws by the painter's algorithm, and the error over time below.
// With a view behind the address, data-picture holds a checksum of the pixels, and data-chart one of the chart's.

namespace thermotwin::solver {

inline const char* const machine_scene_script = R"JS(
(function () {
  const $ = id => document.getElementById(id);
  const canvas = $("machine"), context = canvas.getContext("2d"), chart = $("scene-chart"),
    plot = chart.getContext("2d");
  const scene = JSON.parse($("scene").textContent);
  const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer;
  const columns = p => {
    const raw = new Int16Array(bytes(p.data));
    return p.scales.map((s, c) => Float32Array.from(raw.subarray(c * p.rows, (c + 1) * p.rows), v => v * s));
  };
  const points = columns(scene.points)[0], triangles = new Uint16Array(bytes(scene.triangles)),
    bodies = new Uint8Array(bytes(scene.bodies));
  const nodes = bodies.length, count = triangles.length / 3;
  const heat = columns(scene.temperature), motion = scene.displacement.map(columns);
  const loads = scene.loads.map(l => ({ name: l.name, hours: l.hours, errors: columns(l.errors),
    states: l.coefficients ? columns(l.coefficients) : null }));
  const at = new Float32Array(3 * nodes), moved = new Float32Array(3 * nodes), seen = new Float32Array(3 * nodes),
    kelvin = new Float32Array(nodes);
  const depth = new Float32Array(count), order = new Uint32Array(count);
  const view = sceneView(canvas, -0.75, 0.35, draw);
  let hottest = 0;
  let load = 0, pose = Math.floor(scene.poses.length / 2), time = 0,
    drawn = 0, low = 0, high = 1, longest = 1, capped = false;
  const ink = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const series = ["blue", "orange", "green"].map(c => getComputedStyle(document.querySelector("." + c)).color),
    pink = getComputedStyle(document.querySelector(".pink")).color;

  // Box of all that is ever shown: the machine at its poses, the tool's points.
  const box = [[1e9, 1e9, 1e9], [-1e9, -1e9, -1e9]];
  const widen = (x, y, z) => [x, y, z].forEach((v, i) => { box[0][i] = Math.min(box[0][i], v);
    box[1][i] = Math.max(box[1][i], v); });
  const place = (frames, b, x, y, z) => { const f = 12 * b; return [0, 4,
    8].map(r => frames[f + r] * x + frames[f + r + 1] * y + frames[f + r + 2] * z + frames[f + r + 3]); };
  for (const p of scene.poses) {
    widen(...p.tool);
    for (let n = 0; n < nodes; n += 3) widen(...place(p.frames, bodies[n], points[3 * n], points[3 * n + 1],
      points[3 * n + 2]));
  }
  const centre = [0, 1, 2].map(i => (box[0][i] + box[1][i]) / 2), extent = Math.hypot(...[0, 1,
    2].map(i => box[1][i] - box[0][i])) || 1;

  // The largest scale at which the machine stays in the picture near the first view, about its middle there.
  let fit = 1, shift = [0, 0];
  function measure() {
    const ce = Math.cos(view.elevation), se = Math.sin(view.elevation), span = [1e9, -1e9, 1e9, -1e9];
    const reach = (p, ca, sa) => {
      const [x, y, z] = p.map((v, i) => v - centre[i]), right = ca * x + sa * y, up = ce * z + se * (ca * y - sa * x);
      span[0] = Math.min(span[0], right); span[1] = Math.max(span[1], right); span[2] = Math.min(span[2], up);
        span[3] = Math.max(span[3], up);
    };
    const far = scene.poses.filter((p, i, all) => i % Math.ceil(all.length / 30) === 0 || i === all.length - 1);
    for (const turn of [-0.25, 0, 0.25]) {
      const ca = Math.cos(view.azimuth + turn), sa = Math.sin(view.azimuth + turn);
      for (const p of far) {
        reach(p.tool, ca, sa);
        for (let n = 0; n < nodes; n += 3) reach(place(p.frames, bodies[n], points[3 * n], points[3 * n + 1],
          points[3 * n + 2]), ca, sa);
      }
    }
    shift = [(span[0] + span[1]) / 2, (span[2] + span[3]) / 2];
    fit = 0.9 * Math.min(wide / Math.max(span[1] - span[0], 1e-9), tall / Math.max(span[3] - span[2], 1e-9));
  }

  // Canvases as wide as the page, so that text keeps its size on a narrow one.
  const frame = { left: 62, top: 10, right: 1086, bottom: 218 }, chartTall = 260;
  let wide = 1100, tall = 620;
  function resize() {
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    wide = Math.max(300, Math.round(canvas.clientWidth) || 1100); tall = Math.round(Math.max(340, 0.564 * wide));
    frame.right = wide - 14;
    for (const [c, h, to] of [[canvas, tall, context], [chart, chartTall, plot]]) { c.width = wide * ratio;
      c.height = h * ratio; to.setTransform(ratio, 0, 0, ratio, 0, 0); }
    measure();
  }

  // Cold to hot: blue, pale yellow, red.
  const stops = [[62, 88, 170], [74, 126, 190], [112, 168, 211], [168, 211, 230], [250, 240, 176], [253, 188, 104],
    [244, 121, 72], [219, 59, 44], [176, 12, 44]];
  const colour = share => { const s = Math.max(0, Math.min(0.9999, share)) * (stops.length - 1), i = Math.floor(s),
    r = s - i; return stops[i].map((v, c) => v + r * (stops[i + 1][c] - v)); };

  function warm(state, into) {
    into.fill(0);
    for (let k = 0; k < heat.length; ++k) { const a = state[k], m = heat[k]; for (let n = 0; n < nodes;
      ++n) into[n] += a * m[n]; }
  }
  function setLoad() {
    const l = loads[load];
    low = Infinity; high = -Infinity; longest = 1e-9;
    capped = false;
    if (l.states && heat.length && nodes) {
      // A small hot spot would leave all else in one colour: the scale ends where 97 % of the skin over all times do.
      const seenHeat = [];
      l.states.forEach(s => { warm(s, kelvin); for (let n = 0; n < nodes; n += 2) seenHeat.push(kelvin[n]); });
      const sorted = Float32Array.from(seenHeat).sort(), last = sorted.length - 1;
      low = sorted[0]; hottest = sorted[last]; high = sorted[Math.floor(0.97 * last)];
      if (sorted[last] < low + 1.25 * (high - low)) high = sorted[last]; else capped = true;
    }
    if (!(high > low + 0.2)) { const m = high > -Infinity ? (low + high) / 2 : 0; low = m - 0.1; high = m + 0.1; }
    for (const e of l.errors) for (let p = 0; p < scene.poses.length; ++p) longest = Math.max(longest,
      Math.hypot(e[3 * p], e[3 * p + 1], e[3 * p + 2]));
    $("scene-time").max = l.hours.length - 1;
    time = Math.min(time, l.hours.length - 1);
  }
  function setFields() {
    const l = loads[load], state = l.states && heat.length ? l.states[time] : null,
      factor = Number($("scene-factor").value), frames = scene.poses[pose].frames;
    if (state) warm(state, kelvin);
    moved.fill(0);
    if (state && factor > 0) motion.forEach((field, j) => {
      const w = factor * scene.poses[pose].weights[j];
      if (Math.abs(w) > 1e-9) for (let k = 0; k < field.length; ++k) { const a = w * state[k], m = field[k];
        for (let i = 0; i < 3 * nodes; ++i) moved[i] += a * m[i]; }
    });
    for (let n = 0; n < nodes; ++n) {
      const f = 12 * bodies[n], x = points[3 * n] + moved[3 * n], y = points[3 * n + 1] + moved[3 * n + 1],
        z = points[3 * n + 2] + moved[3 * n + 2];
      for (let i = 0; i < 3;
        ++i) at[3 * n + i] = frames[f + 4 * i] * x + frames[f + 4 * i + 1] * y + frames[f + 4 * i + 2] * z +
          frames[f + 4 * i + 3];
    }
    return state !== null;
  }

  let coloured = false;
  function draw() {
    const w = wide, h = tall, scale = view.zoom * fit;
    const ca = Math.cos(view.azimuth), sa = Math.sin(view.azimuth), ce = Math.cos(view.elevation),
      se = Math.sin(view.elevation);
    const project = (x, y, z) => {
      x -= centre[0]; y -= centre[1]; z -= centre[2];
      const right = ca * x + sa * y, away = -sa * x + ca * y;
      return [w / 2 + scale * (right - shift[0]), h / 2 - scale * (ce * z + se * away - shift[1]), ce * away - se * z];
    };
    for (let n = 0; n < nodes; ++n) { const p = project(at[3 * n], at[3 * n + 1], at[3 * n + 2]);
      seen[3 * n] = p[0]; seen[3 * n + 1] = p[1]; seen[3 * n + 2] = p[2]; }
    let visible = 0;
    for (let t = 0; t < count; ++t) {
      const a = 3 * triangles[3 * t], b = 3 * triangles[3 * t + 1], c = 3 * triangles[3 * t + 2];
      depth[t] = seen[a + 2] + seen[b + 2] + seen[c + 2];
      if ((seen[b] - seen[a]) * (seen[c + 1] - seen[a + 1]) - (seen[b + 1] - seen[a +
        1]) * (seen[c] - seen[a]) < 0) order[visible++] = t;
    }
    const front = order.subarray(0, visible).sort((i, j) => depth[j] - depth[i]);
    context.clearRect(0, 0, w, h);
    context.lineWidth = 0.7;
    for (const t of front) {
      const i = triangles[3 * t], j = triangles[3 * t + 1], k = triangles[3 * t + 2], a = 3 * i, b = 3 * j, c = 3 * k;
      const u = [seen[b] - seen[a], seen[b + 1] - seen[a + 1], scale * (seen[b + 2] - seen[a + 2])],
        v = [seen[c] - seen[a], seen[c + 1] - seen[a + 1], scale * (seen[c + 2] - seen[a + 2])];
      const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]],
        length = Math.hypot(...n) || 1;
      const light = 0.74 + 0.3 * Math.abs(0.35 * n[0] / length - 0.55 * n[1] / length - 0.75 * n[2] / length);
      paint([seen[a], seen[a + 1], kelvin[i]], [seen[b], seen[b + 1], kelvin[j]], [seen[c], seen[c + 1], kelvin[k]],
        light, 3);
    }
    drawArrows(project);
    drawAxes(ca, sa, ce, se);
    canvas.dataset.drawn = ++drawn;
    canvas.dataset.angle = view.azimuth.toFixed(3);
  }
  // A large triangle across many colours is halved along its sides until each part has about one.
  function paint(a, b, c, light, splits) {
    const kelvins = [a[2], b[2], c[2]];
    const range = Math.min(Math.max(...kelvins), high) - Math.max(Math.min(...kelvins), low);
    if (coloured && splits > 0 && range > 0.06 * (high - low) &&
      Math.abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) > 60) {
      const half = (p, q) => [(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2], ab = half(a, b),
        bc = half(b, c), ca = half(c, a);
      for (const part of [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]) paint(...part, light, splits - 1);
      return;
    }
    const rgb = coloured ? colour(((a[2] + b[2] + c[2]) / 3 - low) / (high - low)) : [175, 180, 188];
    context.fillStyle = context.strokeStyle = "rgb(" + rgb.map(x => Math.round(Math.min(255,
      x * light))).join(",") + ")";
    context.beginPath(); context.moveTo(a[0], a[1]); context.lineTo(b[0], b[1]); context.lineTo(c[0], c[1]);
    context.closePath(); context.fill(); context.stroke();
  }
  // Directions of the axes, in the colours of the chart below.
  function drawAxes(ca, sa, ce, se) {
    const at = [46, 62], length = wide < 600 ? 28 : 40;
    context.font = "600 13px system-ui,sans-serif"; context.textAlign = "center"; context.lineWidth = 2.5;
      context.lineCap = "round";
    [[ca, -sa * se], [sa, ca * se], [0, ce]].forEach((d, i) => {
      context.strokeStyle = context.fillStyle = series[i];
      context.beginPath(); context.moveTo(...at); context.lineTo(at[0] + length * d[0], at[1] - length * d[1]);
        context.stroke();
      const long = Math.hypot(...d);
      if (long > 0.15) context.fillText("XYZ"[i], at[0] + d[0] * (length + 12 / long), at[1] - d[1] * (length +
        12 / long) + 5);
    });
    context.textAlign = "start";
  }
  function drawArrows(project) {
    const e = loads[load].errors[time], size = 0.11 * extent / longest;
    const stroke = (from, to, width, style) => {
      const angle = Math.atan2(to[1] - from[1], to[0] - from[0]), head = Math.min(5 + 1.5 * width,
        0.6 * Math.hypot(to[0] - from[0], to[1] - from[1]));
      context.lineWidth = width; context.strokeStyle = style; context.lineCap = "round";
      context.beginPath(); context.moveTo(from[0], from[1]); context.lineTo(to[0], to[1]);
      for (const side of [-0.45, 0.45]) { context.moveTo(to[0], to[1]);
        context.lineTo(to[0] - head * Math.cos(angle + side), to[1] - head * Math.sin(angle + side)); }
      context.stroke();
    };
    scene.poses.forEach((p, i) => {
      const from = project(...p.tool), to = project(...p.tool.map((v, c) => v + size * e[3 * i + c])), chosen = i ===
        pose;
      stroke(from, to, chosen ? 6.5 : 4.5, "rgba(255,255,255,0.85)");
      stroke(from, to, chosen ? 4 : 2, pink);
      context.fillStyle = chosen ? ink("--ink") : pink;
      context.beginPath(); context.arc(from[0], from[1], chosen ? 5 : 2.5, 0, 2 * Math.PI); context.fill();
    });
  }

  function ticks(from, to, most) {
    const raw = (to - from) / most, power = Math.pow(10, Math.floor(Math.log10(raw))), step = [1, 2, 5,
      10].map(f => f * power).find(s => s >= raw * 0.999), list = [];
    for (let v = Math.ceil(from / step - 1e-9) * step; v <= to + 1e-9 * step; v +=
      step) list.push(Math.abs(v) < 1e-9 * step ? 0 : v);
    return { list, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
  }
  let hoursTo = 1;
  function drawChart() {
    const l = loads[load], rows = l.errors.map(e => [e[3 * pose], e[3 * pose + 1], e[3 * pose + 2]]), all = rows.flat();
    let min = Math.min(0, ...all), max = Math.max(0, ...all);
    const margin = 0.06 * (max - min) || 0.5; min -= margin; max += margin;
    hoursTo = l.hours[l.hours.length - 1] || 1;
    const x = v => frame.left + (frame.right - frame.left) * v / hoursTo, y =
      v => frame.bottom - (frame.bottom - frame.top) * (v - min) / (max - min);
    plot.clearRect(0, 0, wide, chartTall);
    plot.font = "13px system-ui,sans-serif"; plot.fillStyle = ink("--soft"); plot.lineWidth = 1;
    const vertical = ticks(min, max, 6), across = ticks(0, hoursTo, Math.max(3, Math.min(12, wide / 85)));
    plot.textAlign = "right";
    for (const v of vertical.list) { plot.strokeStyle = v === 0 ? ink("--soft") : ink("--line"); plot.beginPath();
      plot.moveTo(frame.left, y(v)); plot.lineTo(frame.right, y(v)); plot.stroke();
      plot.fillText(v.toFixed(vertical.digits).replace("-", "\u2212"), frame.left - 7, y(v) + 4); }
    plot.textAlign = "center";
    for (const v of across.list) plot.fillText(v.toFixed(across.digits), x(v), frame.bottom + 18);
    plot.fillText("time in h", (frame.left + frame.right) / 2, frame.bottom + 36);
    plot.save(); plot.translate(14, (frame.top + frame.bottom) / 2); plot.rotate(-Math.PI / 2);
      plot.fillText("TCP error in \u00b5m", 0, 0); plot.restore();
    plot.lineWidth = 2;
    for (let c = 0; c < 3; ++c) { plot.strokeStyle = series[c]; plot.beginPath(); rows.forEach((r, i) => i ?
      plot.lineTo(x(l.hours[i]), y(r[c])) : plot.moveTo(x(l.hours[i]), y(r[c]))); plot.stroke(); }
    plot.lineWidth = 1; plot.strokeStyle = ink("--ink"); plot.setLineDash([5, 4]); plot.beginPath();
      plot.moveTo(x(l.hours[time]), frame.top); plot.lineTo(x(l.hours[time]), frame.bottom); plot.stroke();
      plot.setLineDash([]);
    for (let c = 0; c < 3; ++c) { plot.fillStyle = series[c]; plot.beginPath(); plot.arc(x(l.hours[time]),
      y(rows[time][c]), 4, 0, 2 * Math.PI); plot.fill(); }
  }

  function show() {
    const l = loads[load], e = l.errors[time], here = [0, 1, 2].map(c => e[3 * pose + c]);
    coloured = setFields();
    $("scene-time").value = time;
    $("scene-hour").textContent = "after " + l.hours[time].toFixed(2) + " h";
    const bar = "<i style='width:180px;height:12px;border:0;margin:0 7px;background:linear-gradient(90deg," +
      stops.map(s => "rgb(" + s.join(",") + ")").join(",") + ")'></i>";
    $("scene-range").innerHTML = coloured ? (scene.reference + low).toFixed(1) + " \u00b0C " + bar + (capped ?
      "above " : "") + (scene.reference + high).toFixed(1) + " \u00b0C" + (capped ? ", hottest " + (scene.reference +
      hottest).toFixed(1) + " \u00b0C" : "")
                                          : "no temperature field of this load is at hand";
    $("scene-longest").textContent = "longest arrow of this load " + longest.toFixed(1) + " \u00b5m";
    $("scene-values").textContent = scene.poses[pose].name + ", after " + l.hours[time].toFixed(2) + " h: " +
      here.map((v, c) => "XYZ"[c] + " " + v.toFixed(1).replace("-", "\u2212")).join(", ") + " \u00b5m; length " +
      Math.hypot(...here).toFixed(1) + " \u00b5m";
    draw();
    drawChart();
  }

  const options = (list, names) => names.forEach((name, i) => list.add(new Option(name, i)));
  options($("scene-load"), loads.map(l => l.name));
  options($("scene-pose"), scene.poses.map(p => p.name));
  for (const f of [0, 0.2, 1, 3]) if (f === 0 || scene.factor > 0) $("scene-factor").add(new Option(f ? "\u00d7 " +
    Math.round(f * scene.factor) : "not shown", f * scene.factor, f === 1, f === 1));
  $("scene-load").addEventListener("change", e => { load = Number(e.target.value); time = 1e9; setLoad(); show(); });
  $("scene-pose").addEventListener("change", e => { pose = Number(e.target.value); show(); });
  $("scene-time").addEventListener("input", e => { time = Number(e.target.value); show(); });
  $("scene-factor").addEventListener("change", show);
  let playing = null;
  $("scene-play").addEventListener("click", () => {
    if (playing) { clearInterval(playing); playing = null; }
    else {
      if (time >= loads[load].hours.length - 1) time = -1;
      playing = setInterval(() => { if (time >= loads[load].hours.length - 1) { clearInterval(playing); playing =
        null; } else { ++time; show(); } $("scene-play").textContent = playing ? "stop" : "play"; }, 90);
    }
    $("scene-play").textContent = playing ? "stop" : "play";
  });
  chart.addEventListener("pointerdown", e => {
    const box = chart.getBoundingClientRect(), hour =
      ((e.clientX - box.left) * wide / box.width - frame.left) / (frame.right - frame.left) * hoursTo;
    time = loads[load].hours.reduce((best, h, i, all) => Math.abs(h - hour) < Math.abs(all[best] - hour) ? i : best, 0);
    show();
  });

  load = Math.min(askedNumber("load", scene.first), loads.length - 1);
  pose = Math.min(askedNumber("pose", pose), scene.poses.length - 1);
  view.azimuth += askedNumber("turn", 0);
  time = 1e9;
  resize();
  window.addEventListener("resize", () => { resize(); draw(); drawChart(); });
  setLoad();
  // The moment when the error is largest tells most.
  const share = askedNumber("time", null);
  if (share !== null) time = Math.round(share * (loads[load].hours.length - 1));
  else time = loads[load].errors.map(e => Math.hypot(e[3 * pose], e[3 * pose + 1], e[3 * pose + 2])).reduce((best, v,
    i, all) => v > all[best] ? i : best, 0);
  $("scene-load").value = load; $("scene-pose").value = pose;
  show();
  // For a page that follows a machine: its fields replace those of the first load; the last time stays the last.
  window.machineScene = { set(hours, states, errors) {
    const newest = time >= loads[0].hours.length - 1;
    Object.assign(loads[0], { hours, errors, states: states.length ? states : null });
    load = 0;
    setLoad();
    if (newest) time = hours.length - 1;
    show();
  } };
  if (location.hash) {
    const checksum = (c, of) => of.getImageData(0, 0, c.width, c.height).data.reduce((sum, v) => (31 * sum +
      v) % 2147483647, 7);
    canvas.dataset.picture = checksum(canvas, context); chart.dataset.picture = checksum(chart, plot);
  }
})();
)JS";

}  // namespace thermotwin::solver
