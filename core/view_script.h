// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Script that pages with a scene in space share. It stands before the script of the scene.

namespace thermotwin::core {

inline const char* const view_script = R"JS(
// Where a scene is looked at from: radians about the vertical and above the horizon, and a factor. Dragging turns,
// the wheel zooms; draw() follows in the next frame.
function sceneView(canvas, azimuth, elevation, draw) {
  const view = { azimuth, elevation, zoom: 1 }, perPixel = 0.008, steepest = 1.57;
  let last = null;
  canvas.addEventListener("pointerdown", e => { last = [e.clientX, e.clientY];
    canvas.setPointerCapture(e.pointerId); });
  canvas.addEventListener("pointerup", () => { last = null; });
  canvas.addEventListener("pointermove", e => {
    if (!last) return;
    view.azimuth -= (e.clientX - last[0]) * perPixel;
    view.elevation = Math.max(-1.5, Math.min(steepest, view.elevation + (e.clientY - last[1]) * perPixel));
    last = [e.clientX, e.clientY];
    requestAnimationFrame(draw);
  });
  canvas.addEventListener("wheel", e => { e.preventDefault(); view.zoom *= Math.exp(-e.deltaY * 0.001);
    requestAnimationFrame(draw); }, { passive: false });
  return view;
}
// A number behind the address, as in report.html#time=0.5&turn=1.
function askedNumber(name, otherwise) {
  const asked = new URLSearchParams(location.hash.slice(1));
  return asked.has(name) ? Number(asked.get(name)) : otherwise;
}
)JS";

}  // namespace thermotwin::core
