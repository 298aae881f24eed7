// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Script for the view of a 3-D scene, shared by all pages that have one. It comes before the script of the scene.

namespace thermotwin::core {

inline const char* const view_script = R"JS(
// Viewing direction of a scene: azimuth about the vertical and elevation above the horizon in rad, and a zoom factor.
// Dragging turns the scene, the wheel zooms; draw() is called in the next frame.
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
// A number in the fragment of the address, such as report.html#time=0.5&turn=1.
function askedNumber(name, otherwise) {
  const asked = new URLSearchParams(location.hash.slice(1));
  return asked.has(name) ? Number(asked.get(name)) : otherwise;
}
)JS";

}  // namespace thermotwin::core
