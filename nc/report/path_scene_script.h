// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The script of path_scene_html(): draws the path in the colours of the TCP error, and the point at the chosen time. If
// the address has a fragment (#turn=1), the attribute data-picture of the canvas gets a checksum of the pixels; tests
// compare it.

namespace thermotwin::nc {

inline const char* const path_scene_script = R"JS(
(function () {
  const $ = id => document.getElementById(id), canvas = $("path"), context = canvas.getContext("2d");
  const path = JSON.parse($("path-data").textContent);
  const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer;
  const scaled = p => Float32Array.from(new Int16Array(bytes(p.data)), v => v * p.scale);
  const place = new Float32Array(bytes(path.place)), error = scaled(path.error), deviation = scaled(path.std),
    time = new Float32Array(bytes(path.time)), line = new Uint32Array(bytes(path.line)),
    rapid = new Uint8Array(bytes(path.rapid)), count = time.length, lasts = time[count - 1] - time[0];
  const of = (list, i) => [list[3 * i], list[3 * i + 1], list[3 * i + 2]];
  const choices = [["length of the error", i => Math.hypot(...of(error, i)), false],
    ...[0, 1, 2].map(c => ["error along " + "XYZ"[c], i => error[3 * i + c], true]),
    ["standard deviation", i => Math.hypot(...of(deviation, i)), false]];
  const ink = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const rising = [[43, 83, 178], [28, 137, 160], [64, 154, 92], [168, 160, 36], [222, 124, 30], [196, 40, 38]],
    signed = [[35, 80, 190], [110, 140, 200], [140, 146, 156], [212, 132, 90], [190, 35, 40]], bins = 48;
  const colour = (stops, share) => { const s = Math.max(0, Math.min(0.9999, share)) * (stops.length - 1),
    i = Math.floor(s), r = s - i;
    return "rgb(" + stops[i].map((v, c) => Math.round(v + r * (stops[i + 1][c] - v))).join(",") + ")"; };

  // Rapid moves may lie far away: the picture is that of the cut where there is one.
  const box = [[1e9, 1e9, 1e9], [-1e9, -1e9, -1e9]], cuts = rapid.some((r, i) => i && !r);
  for (let i = 0; i < count; ++i) if (!cuts || (i && !rapid[i])) for (const n of cuts ? [i - 1, i] : [i])
    for (let c = 0; c < 3; ++c) { box[0][c] = Math.min(box[0][c], place[3 * n + c]);
      box[1][c] = Math.max(box[1][c], place[3 * n + c]); }
  const centre = [0, 1, 2].map(c => (box[0][c] + box[1][c]) / 2),
    extent = Math.hypot(...[0, 1, 2].map(c => box[1][c] - box[0][c])) || 1;
  const view = sceneView(canvas, -0.6, 0.6, draw);
  let choice = 0, low = 0, high = 1, wide = 1100, tall = 620, at = 0;

  function setRange() {
    const values = [];
    for (let i = 0; i < count; ++i) if (!rapid[i] || !cuts) values.push(choices[choice][1](i));
    low = values.reduce((a, b) => Math.min(a, b), Infinity);
    high = values.reduce((a, b) => Math.max(a, b), -Infinity);
    if (choices[choice][2]) { high = Math.max(Math.abs(low), Math.abs(high)); low = -high; }
    if (!(high > low)) { low -= 0.05; high += 0.05; }
  }
  function resize() {
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    wide = Math.max(300, Math.round(canvas.clientWidth) || 1100); tall = Math.round(Math.max(320, 0.564 * wide));
    canvas.width = wide * ratio; canvas.height = tall * ratio;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
  }
  const text = v => v.toFixed(2).replace("-", "\u2212");
  function draw() {
    const scale = view.zoom * 0.92 * Math.min(wide, tall / 0.7) / extent,
      ca = Math.cos(view.azimuth), sa = Math.sin(view.azimuth),
      ce = Math.cos(view.elevation), se = Math.sin(view.elevation), x = new Float32Array(count),
      y = new Float32Array(count);
    for (let i = 0; i < count; ++i) {
      const [u, v, w] = of(place, i).map((p, c) => p - centre[c]), away = ca * v - sa * u;
      x[i] = wide / 2 + scale * (ca * u + sa * v); y[i] = tall / 2 - scale * (ce * w + se * away);
    }
    const [, value, sign] = choices[choice], lists = Array.from({ length: bins }, () => []), quick = [];
    for (let i = 1; i < count; ++i) {
      if (rapid[i]) quick.push(i);
      else lists[Math.max(0, Math.min(bins - 1, Math.floor((value(i) - low) / (high - low) * bins)))].push(i);
    }
    const stroke = (list, style, width) => {
      if (!list.length) return;
      context.strokeStyle = style; context.lineWidth = width; context.beginPath();
      for (const i of list) { context.moveTo(x[i - 1], y[i - 1]); context.lineTo(x[i], y[i]); }
      context.stroke();
    };
    context.clearRect(0, 0, wide, tall);
    context.lineCap = "round";
    if ($("path-rapid").checked) stroke(quick, ink("--line"), 1);
    lists.forEach((list, b) => stroke(list, colour(sign ? signed : rising, (b + 0.5) / bins), 1.7));
    context.fillStyle = ink("--ink"); context.strokeStyle = ink("--card"); context.lineWidth = 2;
    context.beginPath(); context.arc(x[at], y[at], 6, 0, 2 * Math.PI); context.fill(); context.stroke();
    drawAxes(ca, sa, ce, se);
  }
  function drawAxes(ca, sa, ce, se) {
    const from = [44, tall - 44], length = 34;
    context.font = "600 13px system-ui,sans-serif"; context.textAlign = "center"; context.lineWidth = 2.5;
    [[ca, -sa * se, "blue"], [sa, ca * se, "orange"], [0, ce, "green"]].forEach((d, i) => {
      context.strokeStyle = context.fillStyle = getComputedStyle(document.querySelector(".legend ." + d[2])).color;
      context.beginPath(); context.moveTo(...from);
      context.lineTo(from[0] + length * d[0], from[1] - length * d[1]); context.stroke();
      const long = Math.hypot(d[0], d[1]);
      if (long > 0.15) context.fillText("XYZ"[i], from[0] + d[0] * (length + 12 / long),
        from[1] - d[1] * (length + 12 / long) + 5);
    });
    context.textAlign = "start";
  }
  function show() {
    const wanted = time[0] + Number($("path-time").value) / 1000 * lasts;
    at = 0;
    for (let low = 0, high = count - 1; low <= high;) { const middle = (low + high) >> 1;
      if (time[middle] <= wanted) { at = middle; low = middle + 1; } else high = middle - 1; }
    const e = of(error, at), d = of(deviation, at), stops = choices[choice][2] ? signed : rising;
    $("path-values").textContent = "line " + line[at] + ", " + time[at].toFixed(1) + " s: " + e.map((v, c) =>
      "XYZ"[c] + " " + text(v) + " \u00b1 " + text(d[c])).join(", ") + " \u00b5m; length " +
      text(Math.hypot(...e)) + " \u00b5m";
    const bar = "<i style='width:180px;height:12px;border:0;margin:0 7px;background:linear-gradient(90deg," +
      stops.map((s, i) => colour(stops, i / (stops.length - 1))).join(",") + ")'></i>";
    $("path-range").innerHTML = text(low) + " \u00b5m " + bar + text(high) + " \u00b5m";
    draw();
  }
  choices.forEach((c, i) => $("path-choice").add(new Option(c[0], i)));
  $("path-choice").addEventListener("change", e => { choice = Number(e.target.value); setRange(); show(); });
  $("path-time").addEventListener("input", show);
  $("path-rapid").addEventListener("change", draw);

  choice = Math.max(0, Math.min(askedNumber("colour", 0), choices.length - 1));
  view.azimuth += askedNumber("turn", 0);
  $("path-choice").value = choice;
  // The moment when the error is largest tells most.
  let worst = 0;
  for (let i = 0; i < count; ++i) if ((!rapid[i] || !cuts) && choices[0][1](i) > choices[0][1](worst)) worst = i;
  $("path-time").value = 1000 * askedNumber("time", (time[worst] - time[0]) / (lasts || 1));
  $("path-rapid").checked = askedNumber("rapid", 1) > 0;
  resize();
  window.addEventListener("resize", () => { resize(); draw(); });
  setRange();
  show();
  if (location.hash) canvas.dataset.picture = context.getImageData(0, 0, canvas.width,
    canvas.height).data.reduce((sum, v) => (31 * sum + v) % 2147483647, 7);
})();
)JS";

}  // namespace thermotwin::nc
