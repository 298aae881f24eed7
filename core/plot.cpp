// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/text.h"

namespace thermotwin::core {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double letter = 6.2;  ///< mean width of one at 11 pixels

struct Colour {
  const char *name, *light, *dark;
};
/// By Ink. The series also differ in lightness.
constexpr std::array<Colour, 10> colours{{{"black", "#1c2430", "#e6eaf0"},
                                          {"grey", "#5b6675", "#9aa6b5"},
                                          {"blue", "#1b6ca8", "#6bb3e8"},
                                          {"orange", "#c4552d", "#f08a5d"},
                                          {"green", "#1d7a46", "#5cc48a"},
                                          {"purple", "#7a4fa3", "#b99be0"},
                                          {"amber", "#a15c00", "#e5a84b"},
                                          {"teal", "#12828a", "#58cbd2"},
                                          {"pink", "#b0417f", "#ec8cbf"},
                                          {"olive", "#75751f", "#c4c467"}}};
constexpr std::size_t first_series = 2;

/// Colours as explicit values: readers of SVG other than browsers know no variables.
std::string scheme(bool dark) {
  std::string css =
      dark ? ".plot .paper{fill:#1c222a}.plot .grid{stroke:#313a46}.band{color:#e6eaf01c}.shade{color:#6bb3e82b}"
           : ".plot .paper{fill:#ffffff}.plot .grid{stroke:#dde2e8}.band{color:#1c243014}.shade{color:#1b6ca821}";
  const Colour &black = colours[0], &grey = colours[1];
  css += fmt::format(".plot text{{fill:{0}}}.plot .zero{{stroke:{0}}}.plot .title{{fill:{1}}}",
                     dark ? grey.dark : grey.light, dark ? black.dark : black.light);
  for (const Colour& colour : colours)
    css += fmt::format(".{}{{color:{}}}", colour.name, dark ? colour.dark : colour.light);
  return css;
}

std::string number_text(double value, double step) {
  const double shown = std::abs(value) < 1e-9 * step ? 0.0 : value;
  const bool plain = step >= 1e-6 && std::abs(shown) < 1e7;
  const int digits = plain ? std::clamp(static_cast<int>(-std::floor(std::log10(step) + 1e-9)), 0, 6) : 0;
  const std::string text = plain ? fmt::format("{:.{}f}", shown, digits) : fmt::format("{:g}", shown);
  return text.starts_with('-') ? "\u2212" + text.substr(1) : text;
}

struct Tick {
  double value;
  std::string text;
  bool zero = false;
};

std::vector<Tick> ticks_of(const Axis& axis, int count) {
  std::vector<Tick> ticks;
  if (axis.log) {
    const double last = std::floor(std::log10(axis.high) + 1e-9);
    for (double power = std::ceil(std::log10(axis.low) - 1e-9); power <= last; ++power)
      ticks.push_back({std::pow(10.0, power), fmt::format("{:g}", std::pow(10.0, power))});
    return ticks;
  }
  std::vector<double> values = axis_ticks(axis.low, axis.high, count);
  if (axis.whole) std::erase_if(values, [](double value) { return std::abs(value - std::round(value)) > 1e-6; });
  const double step = values.size() > 1 ? values[1] - values[0] : 1.0;
  for (const double value : values) ticks.push_back({value, number_text(value, step), std::abs(value) < 1e-9 * step});
  return ticks;
}

}  // namespace

Ink series_ink(std::size_t i) { return static_cast<Ink>(first_series + i % (colours.size() - first_series)); }

std::string class_of(Ink ink) { return colours[static_cast<std::size_t>(ink)].name; }

std::string plot_style() {
  return ".plot text{font:11px system-ui,\"Segoe UI\",\"DejaVu Sans\",sans-serif}.plot .title{font-size:15px;"
         "font-weight:600}.plot path{fill:none}.plot .line{stroke:currentColor;stroke-width:1.6;stroke-linejoin:round}"
         ".plot .key{stroke:currentColor;stroke-width:3}.plot .alone{stroke:currentColor;stroke-width:4}"
         ".plot .dashed{stroke-dasharray:6 4}"
         ".plot .area{fill:currentColor}" +
         scheme(false) + "@media (prefers-color-scheme:dark){" + scheme(true) + "}";
}

std::vector<double> axis_ticks(double low, double high, int count) {
  const double raw = (high - low) / std::max(count, 1);
  if (!(raw > 0.0) || !std::isfinite(raw)) return {};
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10.0 * power;
  for (const double factor : {5.0, 2.0, 1.0})
    if (factor * power >= raw * (1.0 - 1e-9)) step = factor * power;
  std::vector<double> ticks;
  const double first = std::ceil(low / step - 1e-9);
  for (int i = 0; (first + i) * step <= high + 1e-9 * step; ++i) ticks.push_back((first + i) * step);
  return ticks;
}

bool Axis::shows(double value) const { return std::isfinite(value) && (!log || value > 0.0); }

void Axis::include(double value) {
  if (!shows(value)) return;
  low = std::min(low, value);
  high = std::max(high, value);
}

void Axis::include(const VectorXd& values) {
  for (const double value : values) include(value);
}

void Axis::close(double margin) {
  if (!(low <= high)) low = log ? 0.1 : 0.0, high = 1.0;
  if (log) {
    const double first = std::floor(std::log10(low) + 1e-9), last = std::ceil(std::log10(high) - 1e-9);
    const double widening = first < last ? 0.0 : 1.0;
    low = std::pow(10.0, first - widening);
    high = std::pow(10.0, last + widening);
    return;
  }
  if (high - low < 1e-12) low -= 0.5, high += 0.5;
  const double added = margin * (high - low);
  low -= added;
  high += added;
}

double Axis::share(double value) const {
  if (log) return std::log10(value / low) / std::log10(high / low);
  return (value - low) / (high - low);
}

Plot::Plot(double width, double height, std::string name) : width_(width), height_(height), name_(std::move(name)) {}

void Plot::title(double x, double y, std::string_view words) {
  add(fmt::format("<text class=\"title\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", x, y, xml_text(words)));
}

void Plot::text(double x, double y, std::string_view words, Anchor anchor) {
  constexpr std::array<const char*, 3> anchors{"", " text-anchor=\"middle\"", " text-anchor=\"end\""};
  add(fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\"{}>{}</text>\n", x, y, anchors[static_cast<std::size_t>(anchor)],
                  xml_text(words)));
}

double Plot::key(double x, double y, std::string_view words, Ink ink) {
  add(fmt::format("<path class=\"key {}\" d=\"M{:.1f} {:.1f}h20\"/>", class_of(ink), x, y));
  text(x + 26, y + 4, words);
  return x + 26 + letter * words.size() + 22;
}

std::string Plot::inset() const {
  return fmt::format("<svg class=\"plot\" viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"{}\">\n", width_,
                     height_, xml_text(name_)) +
         body_ + "</svg>\n";
}

std::string Plot::file() const {
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
             "width=\"{0:.0f}\" height=\"{1:.0f}\" role=\"img\" aria-label=\"{2}\">\n<style>{3}</style>\n"
             "<rect class=\"paper\" width=\"100%\" height=\"100%\"/>\n",
             width_, height_, xml_text(name_), plot_style()) +
         body_ + "</svg>\n";
}

Panel::Panel(Plot& plot, const Frame& frame, Axis x, Axis y)
    : plot_(plot),
      frame_(frame),
      x_(std::move(x)),
      y_(std::move(y)) {}

double Panel::x(double value) const { return frame_.left + std::clamp(x_.share(value), 0.0, 1.0) * frame_.width; }

double Panel::y(double value) const { return frame_.bottom() - std::clamp(y_.share(value), 0.0, 1.0) * frame_.height; }

void Panel::x_axis(bool lines) {
  for (const Tick& tick : ticks_of(x_, 8)) {
    plot_.add(fmt::format("<path class=\"grid{}\" d=\"M{:.1f} {:.1f}V{:.1f}\"/>", lines && tick.zero ? " zero" : "",
                          x(tick.value), lines ? frame_.top : frame_.bottom(), frame_.bottom() + 4));
    plot_.text(x(tick.value), frame_.bottom() + 16, tick.text, Anchor::middle);
  }
  if (!x_.title.empty()) plot_.text(frame_.left + 0.5 * frame_.width, frame_.bottom() + 30, x_.title, Anchor::middle);
}

void Panel::y_axis() {
  std::size_t longest = 0;
  for (const Tick& tick : ticks_of(y_, 6)) {
    plot_.add(fmt::format("<path class=\"grid{}\" d=\"M{:.1f} {:.1f}H{:.1f}\"/>", tick.zero ? " zero" : "", frame_.left,
                          y(tick.value), frame_.right()));
    plot_.text(frame_.left - 6, y(tick.value) + 3.5, tick.text, Anchor::end);
    longest = std::max(longest, tick.text.size());
  }
  if (y_.title.empty()) return;
  plot_.add(fmt::format("<text transform=\"translate({:.1f} {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                        std::max(11.0, frame_.left - 16 - letter * longest), frame_.top + 0.5 * frame_.height,
                        xml_text(y_.title)));
}

void Panel::shade(double from, double to) {
  const double left = x(from), right = x(to);
  if (!(right > left)) return;
  plot_.add(fmt::format("<rect class=\"area shade\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>\n",
                        left, frame_.top, right - left, frame_.height));
}

void Panel::band(const VectorXd& at, const VectorXd& low, const VectorXd& high) {
  const Index stride = std::max<Index>(1, at.size() / std::lround(frame_.width));
  std::string upper, lower;
  for (Index i = 0; i < at.size(); i += stride) {
    if (!shows(at[i], low[i]) || !shows(at[i], high[i])) continue;
    upper += fmt::format("{}{:.1f} {:.1f}", upper.empty() ? "M" : "L", x(at[i]), y(high[i]));
    lower = fmt::format("L{:.1f} {:.1f}", x(at[i]), y(low[i])) + lower;
  }
  if (!upper.empty()) plot_.add(fmt::format("<path class=\"area band\" d=\"{}{}Z\"/>\n", upper, lower));
}

void Panel::line(const VectorXd& at, const VectorXd& values, Ink ink) {
  const Index stride = std::max<Index>(1, at.size() / std::lround(frame_.width));
  std::string path, alone;
  bool pen_up = true;
  const auto first_shown = [&](Index from) {  // of a stretch of values; -1: none
    for (Index i = from; i < std::min(from + stride, at.size()); ++i)
      if (shows(at[i], values[i])) return i;
    return Index{-1};
  };
  for (Index from = 0; from < at.size(); from += stride) {
    const Index i = first_shown(from);
    if (i >= 0) {
      const bool next = from + stride < at.size() && first_shown(from + stride) >= 0;
      path += fmt::format("{}{:.1f} {:.1f}", pen_up ? "M" : "L", x(at[i]), y(values[i]));
      if (pen_up && !next) alone += fmt::format("M{:.1f} {:.1f}h4", x(at[i]) - 2.0, y(values[i]));  // no line meets it
    }
    pen_up = i < 0;
  }
  if (!path.empty()) plot_.add(fmt::format("<path class=\"line {}\" d=\"{}\"/>\n", class_of(ink), path));
  if (!alone.empty()) plot_.add(fmt::format("<path class=\"alone {}\" d=\"{}\"/>\n", class_of(ink), alone));
}

void Panel::dots(const VectorXd& at, const VectorXd& values, Ink ink) {
  for (Index i = 0; i < at.size(); ++i) {
    if (!shows(at[i], values[i])) continue;
    plot_.add(fmt::format("<circle class=\"area {}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\"/>", class_of(ink), x(at[i]),
                          y(values[i])));
  }
  plot_.add("\n");
}

void Panel::stroke(double x0, double y0, double x1, double y1, Ink ink) {
  plot_.add(fmt::format("<path class=\"line {}\" d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\"/>\n", class_of(ink), x(x0), y(y0),
                        x(x1), y(y1)));
}

void Panel::box(double x0, double x1, double y0, double y1, Ink ink, double opacity) {
  const auto [left, right] = std::minmax({x(x0), x(x1)});
  const auto [top, bottom] = std::minmax({y(y0), y(y1)});
  plot_.add(fmt::format("<rect class=\"area {}\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.2f}\" height=\"{:.2f}\"{}/>\n",
                        class_of(ink), left, top, right - left, bottom - top,
                        opacity < 1.0 ? fmt::format(" fill-opacity=\"{:.2f}\"", opacity) : ""));
}

void Panel::level(double value, std::string_view name) {
  if (!y_.shows(value)) return;
  plot_.add(fmt::format("<path class=\"line dashed black\" d=\"M{:.1f} {:.1f}H{:.1f}\"/>", frame_.left, y(value),
                        frame_.right()));
  plot_.text(frame_.right() + 8, y(value) + 4, name);
}

void Panel::mark(double at) {
  if (!x_.shows(at)) return;
  plot_.add(fmt::format("<path class=\"line dashed grey\" d=\"M{:.1f} {:.1f}V{:.1f}\"/>\n", x(at), frame_.top,
                        frame_.bottom()));
}

}  // namespace thermotwin::core
