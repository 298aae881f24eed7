// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/daily_window_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/thread_pool.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double triangle_h = 2.0;  ///< between the peaks, and from each peak to both ends
constexpr int triangles = 12, longest_window = 9;
constexpr double least_window_evidence = 2.0;  ///< nats
constexpr double edge_step_h = 0.25;
constexpr int edge_steps = 6;  ///< either way
constexpr double ramps_h[] = {0.25, 1.0, 2.0, 4.0};
constexpr double shortest_h = 0.5;
constexpr double edge_free_h = 0.5;         ///< one standard deviation: two of the steps
constexpr double windows_about_one = 10.0;  ///< finer ones that a record tells apart
constexpr double least_covered = 0.05;      ///< of the record that a window covers, and that it leaves

VectorXd heights(const DailyWindow& window, const VectorXd& hours) {
  return hours.unaryExpr([&](double hour) { return std::isfinite(hour) ? height(window, hour) : 0.0; });
}

/// A window that covers nothing, or all, says nothing of the time of day.
bool has_edges(const VectorXd& series) {
  const double covered = (series.array() > 0.5).cast<double>().mean();
  return covered >= least_covered && covered <= 1.0 - least_covered;
}

double log_of_sum(const VectorXd& logs) {
  const double top = logs.maxCoeff();
  return top + std::log((logs.array() - top).exp().sum());
}

struct Coarse {
  DailyWindow window;
  double evidence = -std::numeric_limits<double>::infinity();  ///< of all patches
  Index best = 0;                                              ///< column of weights
};

std::vector<Coarse> coarse_windows(const VectorXd& hours) {
  std::vector<Coarse> windows;
  for (int first = 0; first < triangles; ++first) {
    for (int count = 1; count <= longest_window; ++count) {
      const double from = triangle_h * (first - 0.5);
      const DailyWindow window{from, from + triangle_h * count, triangle_h};
      if (has_edges(heights(window, hours))) windows.push_back({window});
    }
  }
  return windows;
}

/// Moves edges and ramps of a window to where a load describes the record best.
class Edges {
public:
  Edges(const Problem& problem, const Response& response, const MachineInTime& base, const SearchData& seen,
        const VectorXd& hours, VectorXd load)
      : problem_(problem),
        response_(response),
        base_(base),
        seen_(seen),
        hours_(hours),
        load_(std::move(load)),
        whitener_(problem.fitted_covariance()) {}

  DailyWindow moved(DailyWindow window) const {
    for (int sweep = 0; sweep < 2; ++sweep) {
      for (double DailyWindow::*const edge : {&DailyWindow::from_h, &DailyWindow::to_h}) {
        std::vector<DailyWindow> tried;
        for (int step = -edge_steps; step <= edge_steps; ++step) {
          for (const double ramp : ramps_h) {
            DailyWindow other = window;
            other.*edge += edge_step_h * step;
            other.ramp_h = ramp;
            const double length = other.to_h - other.from_h;
            if (length >= std::max(shortest_h, ramp) && length <= 24.0 - ramp && has_edges(heights(other, hours_)))
              tried.push_back(other);
          }
        }
        if (!tried.empty()) window = best_of(tried);
      }
    }
    return window;
  }

private:
  DailyWindow best_of(const std::vector<DailyWindow>& tried) const {
    MatrixXd series(hours_.size(), std::ssize(tried));
    for (std::size_t i = 0; i < tried.size(); ++i) series.col(i) = heights(tried[i], hours_);
    const MatrixXd white = whitener_.whiten(problem_.fitted(response_.to_heat(base_, load_, series)));
    VectorXd evidence(white.cols());
    for (Index i = 0; i < white.cols(); ++i) evidence[i] = evidence_of(seen_, white.col(i), MatrixXd::Ones(1, 1))[0];
    Index at = 0;
    evidence.maxCoeff(&at);
    return tried[at];
  }

  const Problem& problem_;
  const Response& response_;
  const MachineInTime& base_;
  const SearchData& seen_;
  const VectorXd& hours_;
  const VectorXd load_;
  const Whitener whitener_;
};

}  // namespace

std::optional<DailySource> find_daily_source(const Problem& problem, const Response& response,
                                             const MachineInTime& base, const VectorXd& hours,
                                             const Combinations& heat) {
  std::vector<Coarse> windows = coarse_windows(hours);
  if (windows.empty()) return std::nullopt;
  MatrixXd series(hours.size(), triangles);
  for (int k = 0; k < triangles; ++k)
    series.col(k) = heights({triangle_h * (k - 0.5), triangle_h * (k + 0.5), triangle_h}, hours);
  const SearchData seen(problem, response.to_heat(base, heat.loads, series));
  const Index m = heat.loads.cols();
  core::parallel_for(0, windows.size(), [&](std::size_t i) {
    const DailyWindow& window = windows[i].window;
    const int first = std::lround(window.from_h / triangle_h + 0.5),
              count = std::lround((window.to_h - window.from_h) / triangle_h);
    MatrixXd own = MatrixXd::Zero(seen.white.rows(), m);
    for (int k = first; k < first + count; ++k) own += seen.white.middleCols(m * (k % triangles), m);
    const VectorXd evidence = evidence_of(seen, own, heat.weights);
    windows[i].evidence = log_of_sum(over_shares(evidence).col(0));
    evidence.maxCoeff(&windows[i].best);
  });
  VectorXd all(std::ssize(windows));
  for (Index i = 0; i < all.size(); ++i) all[i] = windows[i].evidence;
  Index at = 0;
  const double most = all.maxCoeff(&at), patches = heat.weights.cols() / std::ssize(spread_shares);
  if (most - std::log(patches) < least_window_evidence) return std::nullopt;
  DailySource found;
  found.log_share = log_of_sum(all) - most - std::log(windows_about_one * all.size());
  found.window = Edges(problem, response, base, seen, hours, heat.loads * heat.weights.col(windows[at].best))
                     .moved(windows[at].window);
  found.series = heights(found.window, hours);
  return found;
}

MatrixXd course_freedom(const DailyWindow& window, const VectorXd& hours) {
  MatrixXd freedom(hours.size(), 3);
  Index at = 0;
  for (double DailyWindow::*const edge : {&DailyWindow::from_h, &DailyWindow::to_h}) {
    DailyWindow early = window, late = window;
    early.*edge -= edge_free_h;
    late.*edge += edge_free_h;
    freedom.col(at++) = 0.5 * (heights(late, hours) - heights(early, hours));
  }
  DailyWindow steeper = window;
  steeper.ramp_h *= 0.5;
  freedom.col(at) = heights(steeper, hours) - heights(window, hours);
  return freedom;
}

}  // namespace thermotwin::diagnosis
