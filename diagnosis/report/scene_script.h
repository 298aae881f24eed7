// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The script of scene_html(): painter's algorithm, marked triangles shine through what hides them.
// A page opened with #turn turns itself once; data-drawn counts pictures, data-angle tells the view.

namespace thermotwin::diagnosis {

inline const char* const scene_script = R"JS(
(function () {
  const canvas = document.getElementById("machine"), context = canvas.getContext("2d");
  const scene = JSON.parse(document.getElementById("scene").textContent);
  const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer;
  const points = new Uint16Array(bytes(scene.points)), triangles = new Uint32Array(bytes(scene.triangles)),
    marks = new Uint8Array(bytes(scene.marks));
  const count = marks.length, nodes = points.length / 3, centre = scene.extent.map(e => e / 2);
  const seen = new Float32Array(3 * nodes), depth = new Float32Array(count), order = new Uint32Array(count);
  const view = sceneView(canvas, -0.9, 0.45, draw);
  const causes = scene.colours.map(c => [1, 3, 5].map(i => parseInt(c.slice(i, i + 2), 16)));
  let drawn = 0;
  const colour = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  // As wide as the page, so that labels keep their size on a narrow one.
  let w = 1100, h = 560, fit = 1, shift = [0, 0];
  function resize() {
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    w = Math.max(300, Math.round(canvas.clientWidth) || 1100); h = Math.round(Math.max(340, 0.51 * w));
    canvas.width = w * ratio; canvas.height = h * ratio;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const ce = Math.cos(view.elevation), se = Math.sin(view.elevation), span = [1e9, -1e9, 1e9, -1e9];
    for (const turn of [-0.25, 0, 0.25]) {
      const ca = Math.cos(view.azimuth + turn), sa = Math.sin(view.azimuth + turn);
      for (let n = 0; n < nodes; n += 3) {
        const [x, y, z] = centre.map((m, i) => points[3 * n + i] / 65535 - m), right = ca * x + sa * y,
          up = ce * z + se * (ca * y - sa * x);
        span[0] = Math.min(span[0], right); span[1] = Math.max(span[1], right); span[2] = Math.min(span[2], up);
          span[3] = Math.max(span[3], up);
      }
    }
    shift = [(span[0] + span[1]) / 2, (span[2] + span[3]) / 2];
    fit = 0.9 * Math.min(w / Math.max(span[1] - span[0], 1e-9), h / Math.max(span[3] - span[2], 1e-9));
  }

  function draw() {
    const scale = view.zoom * fit;
    const ca = Math.cos(view.azimuth), sa = Math.sin(view.azimuth), ce = Math.cos(view.elevation),
      se = Math.sin(view.elevation);
    const project = (x, y, z) => {
      x -= centre[0]; y -= centre[1]; z -= centre[2];
      const right = ca * x + sa * y, away = -sa * x + ca * y;
      return [w / 2 + scale * (right - shift[0]), h / 2 - scale * (ce * z + se * away - shift[1]), ce * away - se * z];
    };
    for (let n = 0; n < nodes; ++n) {
      const p = project(points[3 * n] / 65535, points[3 * n + 1] / 65535, points[3 * n + 2] / 65535);
      seen[3 * n] = p[0]; seen[3 * n + 1] = p[1]; seen[3 * n + 2] = p[2];
    }
    let visible = 0;
    for (let t = 0; t < count; ++t) {
      const a = 3 * triangles[3 * t], b = 3 * triangles[3 * t + 1], c = 3 * triangles[3 * t + 2];
      const turn = (seen[b] - seen[a]) * (seen[c + 1] - seen[a + 1]) - (seen[b + 1] - seen[a +
        1]) * (seen[c] - seen[a]);
      depth[t] = seen[a + 2] + seen[b + 2] + seen[c + 2];
      if (turn < 0) order[visible++] = t;
    }
    const front = order.subarray(0, visible).sort((i, j) => depth[j] - depth[i]);
    context.clearRect(0, 0, w, h);
    const fill = (t, style) => {
      const a = 3 * triangles[3 * t], b = 3 * triangles[3 * t + 1], c = 3 * triangles[3 * t + 2];
      context.fillStyle = context.strokeStyle = style;
      context.beginPath(); context.moveTo(seen[a], seen[a + 1]); context.lineTo(seen[b], seen[b + 1]);
        context.lineTo(seen[c], seen[c + 1]);
      context.closePath(); context.fill(); context.stroke();
    };
    context.lineWidth = 0.6;
    for (const t of front) {
      const a = 3 * triangles[3 * t], b = 3 * triangles[3 * t + 1], c = 3 * triangles[3 * t + 2];
      const u = [seen[b] - seen[a], seen[b + 1] - seen[a + 1], scale * (seen[b + 2] - seen[a + 2])],
        v = [seen[c] - seen[a], seen[c + 1] - seen[a + 1], scale * (seen[c + 2] - seen[a + 2])];
      const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]],
        length = Math.hypot(...n) || 1;
      const light = Math.round(95 + 115 * Math.abs(0.35 * n[0] / length - 0.55 * n[1] / length - 0.75 * n[2] / length));
      fill(t, marks[t] ? "rgb(" + causes[marks[t] - 1].map(c => Math.min(255, Math.round(light * c / 200))) + ")"
                       : "rgb(" + light + "," + (light + 4) + "," + (light + 10) + ")");
    }
    // Causes are often inside: they shine through, from either side.
    context.globalAlpha = 0.3;
    for (let t = 0; t < count; ++t) if (marks[t]) fill(t, scene.colours[marks[t] - 1]);
    context.globalAlpha = 1;
    context.font = "13px system-ui,sans-serif"; context.lineJoin = "round";
    const dots = scene.dots.map(([x, y, z, label, marked]) => ({ at: project(x, y, z), label, marked }));
    context.strokeStyle = colour("--card"); context.lineWidth = 3.5;
    for (const { at, marked } of dots) {
      context.fillStyle = marked ? scene.colours[marked - 1] : colour("--point");
      context.beginPath(); context.arc(at[0], at[1], marked ? 7 : 3.5, 0, 2 * Math.PI);
      context.stroke(); context.fill();
    }
    // Each label goes to the first place about its point where it covers no label before it.
    const taken = [];
    let covered = 0;
    context.fillStyle = colour("--ink");
    for (const { at, label } of dots) {
      const wide = context.measureText(label).width, tall = 16;
      const free = ([x, y]) => taken.every(([u, v, other]) =>
        x + wide + 3 < u || u + other + 3 < x || Math.abs(y - v) >= tall);
      const offered = [[9, 4], [-9 - wide, 4], [9, 20], [9, -12], [-9 - wide, 20], [-9 - wide, -12], [9, 36], [9, -28],
        [-9 - wide, 36], [-9 - wide, -28]].map(([x, y]) => [at[0] + x, at[1] + y]);
      const found = offered.find(free);
      if (!found) ++covered;
      const [x, y] = found || offered[0];
      taken.push([x, y, wide]);
      context.strokeText(label, x, y); context.fillText(label, x, y);
    }
    canvas.dataset.covered = covered;
    canvas.dataset.drawn = ++drawn;
    canvas.dataset.angle = view.azimuth.toFixed(3);
  }

  resize();
  window.addEventListener("resize", () => { resize(); draw(); });
  draw();
  if (location.hash === "#turn") { view.azimuth += 0.6; draw(); }
})();
)JS";

}  // namespace thermotwin::diagnosis
