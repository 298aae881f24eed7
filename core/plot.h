// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Plots as SVG: panels with round numbers on their axes, and in them lines, bands, bars and marks, drawn one over
// the other in the order of the calls. Colours follow light and dark schemes. A plot is a file of its own or
// stands in a page that contains plot_style().

#include <Eigen/Core>

#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace thermotwin::core {

enum class Ink { black, grey, blue, orange, green, purple, amber, teal, pink, olive };

/// Colour of the i-th series of a plot: eight that differ, then again from the first.
Ink series_ink(std::size_t i);
/// Class that gives a shape of a plot, or a text of a page, this colour.
std::string class_of(Ink ink);
/// Style sheet of all plots.
std::string plot_style();

/// Numbers for an axis from low to high: steps of 1, 2 or 5 times a power of ten, `count` steps at
/// most. Empty where high is not above low, or either is not finite.
std::vector<double> axis_ticks(double low, double high, int count);

/// A range of values and what is written beside it. High may be below low: the values then fall along the axis.
struct Axis {
  std::string title;
  bool log = false;
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  bool whole = false;  ///< counts: no numbers between whole ones are written

  /// Finite, and above 0 on a logarithmic axis.
  bool shows(double value) const;
  /// Widens the range to the values that the axis shows.
  void include(double value);
  void include(const Eigen::VectorXd& values);
  /// Gives a range without width one, and adds a share of it at both ends (logarithmic: up to powers of ten).
  void close(double margin = 0.0);
  /// 0 at low, 1 at high.
  double share(double value) const;
};

/// In pixels of the picture, y downwards.
struct Frame {
  double left = 0, top = 0, width = 0, height = 0;
  double right() const { return left + width; }
  double bottom() const { return top + height; }
};

enum class Anchor { start, middle, end };

class Plot {
public:
  /// @param name  what the picture shows, for readers who do not see it
  Plot(double width, double height, std::string name);

  void title(double x, double y, std::string_view words);
  void text(double x, double y, std::string_view words, Anchor anchor = Anchor::start);
  /// Entry of a legend: a stroke in the colour, then the words. @return about where the next may begin
  double key(double x, double y, std::string_view words, Ink ink);
  void add(std::string_view element) { body_ += element; }

  std::string file() const;   ///< stands alone
  std::string inset() const;  ///< stands in a page with plot_style()

private:
  double width_, height_;
  std::string name_, body_;
};

/// Part of a plot with an x axis and a y axis. Values outside of the axes are drawn at their ends.
class Panel {
public:
  /// @param plot  has to outlive the panel  @param x, y  closed
  Panel(Plot& plot, const Frame& frame, Axis x, Axis y);

  double x(double value) const;  ///< pixels
  double y(double value) const;

  /// Numbers and title below, short strokes or lines over the whole height.
  void x_axis(bool lines = false);
  /// Numbers and title on the left, lines over the whole width.
  void y_axis();

  /// From one x to another over the whole height.
  void shade(double from, double to);
  /// Between two curves. (n) each; values that are not finite are passed over
  void band(const Eigen::VectorXd& at, const Eigen::VectorXd& low, const Eigen::VectorXd& high);
  /// Through the points (n), no more of them than pixels; interrupted where the axes do not show one.
  void line(const Eigen::VectorXd& at, const Eigen::VectorXd& values, Ink ink);
  void dots(const Eigen::VectorXd& at, const Eigen::VectorXd& values, Ink ink);
  /// From one point straight to another.
  void stroke(double x0, double y0, double x1, double y1, Ink ink);
  void box(double x0, double x1, double y0, double y1, Ink ink, double opacity = 1.0);
  /// Dashed over the whole width, its name on the right.
  void level(double value, std::string_view name);
  /// Dashed over the whole height.
  void mark(double at);

private:
  bool shows(double at, double value) const { return x_.shows(at) && y_.shows(value); }

  Plot& plot_;
  Frame frame_;
  Axis x_, y_;
};

}  // namespace thermotwin::core
