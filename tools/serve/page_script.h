// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The script of the page of `serve`: takes the last 24 h once, then each moment as it comes.

namespace thermotwin::tools {

inline const char* const served_page_script = R"JS(
(function () {
  const $ = id => document.getElementById(id), colours = ["blue", "orange", "green"];
  const ink = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const series = colours.map(c => getComputedStyle(document.querySelector("." + c)).color);
  const number = (v, digits) => v === null || v === undefined ? "\u2013" : v.toFixed(digits).replace("-", "\u2212");
  let points = [], fields = [], sensors = [];
  const canvas = $("served-chart"), plot = canvas.getContext("2d"), day = 86400;

  function drawOffsets() {
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    const wide = Math.max(300, canvas.clientWidth || 1100), tall = 260;
    canvas.width = wide * ratio; canvas.height = tall * ratio; plot.setTransform(ratio, 0, 0, ratio, 0, 0);
    plot.clearRect(0, 0, wide, tall);
    if (!points.length) return;
    const to = points[points.length - 1].t, from = Math.min(points[0].t, to - 600), axes = points[0].o.length;
    let low = 0, high = 0;
    for (const p of points) p.o.forEach((o, i) => { const s = Math.min(p.s[i] || 0, 50);
      low = Math.min(low, o - s); high = Math.max(high, o + s); });
    const margin = 0.06 * (high - low) || 1; low -= margin; high += margin;
    const x = t => 62 + (wide - 76) * (t - from) / (to - from), y = v => 218 - 208 * (v - low) / (high - low);
    plot.font = "13px system-ui,sans-serif"; plot.fillStyle = ink("--soft"); plot.strokeStyle = ink("--line");
    const raw = (high - low) / 6, power = Math.pow(10, Math.floor(Math.log10(raw))),
      step = [1, 2, 5, 10].map(f => f * power).find(f => f >= raw * 0.999);
    plot.textAlign = "right";
    for (let v = Math.ceil(low / step) * step; v <= high; v += step) { plot.beginPath(); plot.moveTo(62, y(v));
      plot.lineTo(wide - 14, y(v)); plot.stroke();
      plot.fillText(number(Math.abs(v) < 1e-9 * step ? 0 : v, step < 1 ? 1 : 0), 55, y(v) + 4); }
    plot.textAlign = "center";
    const hours = (to - from) / 3600, each = [0.05, 0.1, 0.25, 0.5, 1, 2, 3, 6].find(h => hours / h <= 9) || 6;
    for (let h = 0; h <= hours; h += each) plot.fillText(number(-h, each < 1 ? 2 : 0), x(to - 3600 * h), 236);
    plot.fillText("time in h", wide / 2, 254);
    plot.save(); plot.translate(14, 114); plot.rotate(-Math.PI / 2); plot.fillText("offset in \u00b5m", 0, 0);
    plot.restore();
    for (let i = 0; i < axes; ++i) {
      plot.fillStyle = plot.strokeStyle = series[i]; plot.globalAlpha = 0.15; plot.beginPath();
      points.forEach((p, k) => { const v = y(p.o[i] + Math.min(p.s[i] || 0, 50));
        k ? plot.lineTo(x(p.t), v) : plot.moveTo(x(p.t), v); });
      points.slice().reverse().forEach(p => plot.lineTo(x(p.t), y(p.o[i] - Math.min(p.s[i] || 0, 50))));
      plot.fill(); plot.globalAlpha = 1; plot.lineWidth = 2; plot.beginPath();
      points.forEach((p, k) => k ? plot.lineTo(x(p.t), y(p.o[i])) : plot.moveTo(x(p.t), y(p.o[i]))); plot.stroke();
    }
    plot.lineWidth = 1;
  }

  function drawFields() {
    if (!fields.length || !window.machineScene) return;
    const first = fields[0].t;
    window.machineScene.set(fields.map(f => (f.t - first) / 3600), fields[0].modes ? fields.map(f => f.modes) : [],
      fields.map(f => f.errors_um));
  }

  function keep(list, entry, every) {
    // The newest one stands for now; it stays once it is as much later than the one before.
    if (list.length > 1 && list[list.length - 1].t - list[list.length - 2].t < every) list.pop();
    list.push(entry);
    while (list[0].t < entry.t - day) list.shift();
  }

  const words = { following: "follows the model", limited: "limits the offsets", holding: "holds the last offsets",
    returning: "returns to zero" };
  function cell(row, text) { row.insertCell().textContent = text; }
  // A page that is opened late shows old values: it says so.
  let newest = 0, between = 0;
  function age(s) { return s < 120 ? number(s, 0) + " s" : s < 7200 ? number(s / 60, 0) + " min" :
    number(s / 3600, 0) + " h"; }
  function tellAge() {
    if (!newest || document.body.dataset.link !== "up") return;
    const s = Date.now() / 1000 - newest, old = s > Math.max(10, 3 * between);
    $("served-link").textContent = old ? "no rows for " + age(s) + "; values are old" : "live";
    $("served-link").className = $("served-time").className = old ? "warned" : "";
    document.body.dataset.old = old;
  }
  setInterval(tellAge, 1000);
  function showSensors(list) {
    const table = $("served-sensors");
    while (table.rows.length > 1) table.deleteRow(1);
    for (const s of list) {
      const row = table.insertRow();
      cell(row, s.id); cell(row, number(s.reading_C, 2)); cell(row, number(s.predicted_C, 2));
      cell(row, s.reading_C === null || s.predicted_C === null ? "\u2013" : number(s.reading_C - s.predicted_C, 2));
      cell(row, s.fault || (s.reading_C === null ? "no reading" : "used"));
      if (s.fault) row.className = "warned";
    }
    const failed = list.filter(s => s.fault).map(s => s.id + " " + s.fault);
    $("served-failed").textContent = failed.length ? "Left out: " + failed.join(", ") : "No sensor is left out.";
  }
  function show(m) {
    if (m.unix_s) { between = newest ? m.unix_s - newest : 0; newest = m.unix_s; }
    $("served-status").textContent = m.status; $("served-status").className = m.status === "ok" ? "" : "warned";
    $("served-guard").textContent = words[m.guard] || m.guard;
    $("served-model").textContent = (m.model_is_up ? "runs" : "is started again") + ", restarts " + m.restarts;
    $("served-time").textContent = number(m.time_s, 1) + " s";
    (m.axes || []).forEach(axis => { const tile = $("served-" + axis); if (tile) tile.textContent =
      number(m.offset_um[axis], 2) + " \u00b1 " + number(m.std_um[axis], 2) + " \u00b5m"; });
    if (m.axes) keep(points, { t: m.time_s, o: m.axes.map(a => m.offset_um[a]), s: m.axes.map(a => m.std_um[a]) }, 60);
    if (m.errors_um) { keep(fields, { t: m.time_s, errors_um: m.errors_um, modes: m.modes }, 300); drawFields(); }
    if (m.sensors) showSensors(m.sensors);
    drawOffsets();
    document.body.dataset.time = m.time_s;
    document.body.dataset.moments = Number(document.body.dataset.moments || 0) + 1;
  }
  window.addEventListener("resize", drawOffsets);
  fetch("/history").then(r => r.json()).then(h => {
      points = h.points; fields = h.fields; drawOffsets(); drawFields();
      if (h.sensors && h.sensors.length) showSensors(h.sensors); })
    .catch(() => {}).finally(() => {
      const events = new EventSource("/events");
      events.onmessage = e => { document.body.dataset.link = "up"; show(JSON.parse(e.data)); tellAge(); };
      events.onerror = () => { document.body.dataset.link = "down";
        $("served-link").textContent = "no connection to serve; values are old"; };
    });
})();
)JS";

}  // namespace thermotwin::tools
