// SPDX-License-Identifier: GPL-3.0-or-later
#include "faulty_readings.h"

#include <algorithm>
#include <cmath>

#include "solver/operation/layout.h"

namespace thermotwin::hidden {

using diagnosis::Kind;

using Eigen::Index;
using Eigen::VectorXd;

namespace {

VectorXd follower(const VectorXd& time, const VectorXd& values, double tau) {
  VectorXd out = values;
  for (Index i = 1; i < values.size(); ++i) {
    const int parts = std::max(1, static_cast<int>(std::ceil(20.0 * (time[i] - time[i - 1]) / tau)));
    double y = out[i - 1];
    for (int k = 0; k < parts; ++k) {
      const double u = values[i - 1] + (values[i] - values[i - 1]) * (k + 0.5) / parts;
      y += (time[i] - time[i - 1]) / parts / tau * (u - y);
    }
    out[i] = y;
  }
  return out;
}

}  // namespace

VectorXd spoilt_reading(Kind kind, double value, const VectorXd& time, const VectorXd& air, VectorXd values) {
  const double length = time[time.size() - 1] - time[0];
  if (kind == Kind::sensor_lag) return follower(time, follower(time, values, 0.7 * value), 0.3 * value);
  VectorXd out = values;
  for (Index i = 0; i < values.size(); ++i) {
    const double since = time[i] - time[0], share = since / length;
    if (kind == Kind::sensor_offset) out[i] += value * (1.0 + 0.05 * std::sin(since / 9000.0));
    if (kind == Kind::sensor_drift || kind == Kind::probe_drift)
      out[i] += value * since / 3600.0 * (1.15 - 0.3 * share);
    if (kind == Kind::sensor_detached) out[i] += value * (1.0 + 0.1 * std::sin(since / 5000.0)) * (air[i] - values[i]);
    if (kind == Kind::clock_shift) {
      const double at = std::clamp(time[i] - value, time[0], time[time.size() - 1]);
      const double* next = std::lower_bound(time.data() + 1, time.data() + time.size() - 1, at);
      const Index right = next - time.data();
      out[i] = values[right - 1] +
               (values[right] - values[right - 1]) * (at - time[right - 1]) / (time[right] - time[right - 1]);
    }
  }
  return out;
}

bool concerns(const std::string& where, const compensation::MeasuredChannel& channel) {
  if (where == channel.id) return true;
  if (!channel.sensor.empty()) return where == "temperature";
  return channel.input.empty() && (where == "displacement" || where == "displacement." + channel.quantity);
}

OutsideEffect::OutsideEffect(Outside effect, std::string where, const mesh::Machine& machine,
                             const solver::Layout& layout, double duration_s, Random& random)
    : effect_(effect),
      where_(std::move(where)),
      machine_(machine),
      layout_(layout),
      random_(random) {
  if (effect_ == Outside::relubricated_bearing || effect_ == Outside::lost_preload ||
      effect_ == Outside::viscous_bearing) {
    begins_ = random.uniform(0.2, 0.6) * duration_s;
    size_ = random.uniform(1.8, 4.0);
  }
}

void OutsideEffect::act(solver::Coefficients& c, const VectorXd&, double time, double step) {
  const auto scale_terms = [&](solver::TermKind kind, int item, double factor) {
    for (std::size_t t = 0; t < layout_.terms.size(); ++t) {
      if (layout_.terms[t].kind != kind || layout_.terms[t].item != item) continue;
      c.p[t] *= factor;
      for (std::size_t k = 0; k < layout_.inputs.size(); ++k)
        if (layout_.inputs[k].term == static_cast<int>(t)) c.q[k] *= factor;
    }
  };
  const auto over_source = [&](const auto& change) {
    for (std::size_t k = 0; k < layout_.inputs.size(); ++k) {
      if (layout_.inputs[k].kind == solver::InputKind::source && layout_.inputs[k].item >= 0 &&
          machine_.sources[layout_.inputs[k].item].id == where_)
        change(c.q[k]);
    }
  };
  if (effect_ == Outside::hysteretic_joint) {
    // Conducts well once the machine has warmed up, and keeps doing so until it has stood long.
    double heat = 0.0;
    for (std::size_t k = 0; k < layout_.inputs.size(); ++k)
      if (layout_.inputs[k].kind == solver::InputKind::source) heat += c.q[k];
    last_heat_ += step / 5400.0 * (heat - last_heat_);
    if (heat > 1.3 * last_heat_) open_ = true;
    if (heat < 0.5 * last_heat_) open_ = false;
    scale_terms(solver::TermKind::contact, machine_.joint_index(where_), open_ ? 6.0 : 0.3);
  } else if (effect_ == Outside::humid_film) {
    humidity_ += -step / 7200.0 * humidity_ + std::sqrt(2.0 * step / 7200.0) * random_.normal();
    for (std::size_t f = 0; f < machine_.films.size(); ++f) {
      if (machine_.films[f].id == where_)
        scale_terms(solver::TermKind::film, f, std::exp(std::clamp(1.0 * humidity_, -2.5, 2.0)));
    }
  } else if (effect_ == Outside::jumping_bearing) {
    if (random_.uniform() < step / 4000.0)
      level_ = random_.uniform() < 0.5 ? random_.uniform(0.1, 0.5) : random_.uniform(2.0, 4.0);
    over_source([&](double& power) { power *= level_; });
  } else if (effect_ == Outside::relubricated_bearing) {
    // Fresh grease churns, and settles over half a day to a lower loss than before.
    if (time < begins_) return;
    over_source([&](double& power) { power *= size_ * (0.8 + 0.2 * std::exp((begins_ - time) / 20000.0)); });
  } else if (effect_ == Outside::lost_preload) {
    if (time >= begins_) scale_terms(solver::TermKind::contact, machine_.joint_index(where_), 1.0 / size_);
  } else if (effect_ == Outside::viscous_bearing) {
    // The loss falls with the lubricant's temperature, which follows the loss within 40 minutes.
    double given = 0.0;
    over_source([&](double& power) {
      const double most = std::max(most_, std::abs(power));
      most_ = most;
      given += power;
      power *= most > 0.0 ? size_ / (1.0 + (size_ - 0.5) * std::abs(last_heat_) / most) : 1.0;
    });
    last_heat_ += std::min(1.0, step / 2400.0) * (given - last_heat_);
  }
}

VectorXd OutsideEffect::reading(const std::string& sensor, const VectorXd& time, VectorXd values) {
  if (effect_ != Outside::slipping_cable || sensor != where_) return values;
  double offset = 0.0;
  for (Index i = 1; i < values.size(); ++i) {
    if (random_.uniform() < (time[i] - time[i - 1]) / 5000.0)
      offset = random_.uniform() < 0.35 ? 0.0 : random_.uniform(-2.5, 2.5);
    values[i] += offset;
  }
  return values;
}

}  // namespace thermotwin::hidden
