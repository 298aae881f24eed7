// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/network.h"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <random>

#include "compensation/models/lag_bank.h"
#include "compensation/models/least_squares.h"
#include "core/error.h"
#include "core/statistics.h"
#include "core/units.h"

namespace thermotwin::compensation {
namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

constexpr Index hidden = 6, most_components = 6, most_training_blocks = 240;
constexpr int seeds = 3, most_iterations = 30, thirds = 3;

/// output = linear.x + bias + sum_j v_j tanh(w_j.x + c_j); parameters in one vector.
struct Layers {
  static Index size(Index inputs) { return inputs + 1 + hidden * (inputs + 2); }

  static double output(const VectorXd& p, const Eigen::Ref<const RowVectorXd>& x,
                       Eigen::Ref<RowVectorXd, 0, Eigen::InnerStride<>> gradient) {
    const Index n = x.size();
    double y = p.head(n).dot(x) + p[n];
    gradient.head(n) = x;
    gradient[n] = 1.0;
    for (Index j = 0; j < hidden; ++j) {
      const Index at = n + 1 + j * (n + 2);
      const double h = std::tanh(p.segment(at, n).dot(x) + p[at + n]), v = p[at + n + 1];
      y += v * h;
      gradient.segment(at, n) = v * (1.0 - h * h) * x;
      gradient[at + n] = v * (1.0 - h * h);
      gradient[at + n + 1] = h;
    }
    return y;
  }
};

VectorXd first_weights(Index inputs, int seed) {
  std::mt19937_64 engine(1000 + seed);
  VectorXd p(Layers::size(inputs));
  for (double& value : p) value = 0.6 * (core::uniform(engine) - 0.5);
  return p;
}

VectorXd trained(const MatrixXd& x, const VectorXd& z, double decay, int seed) {
  SquaresProblem problem;
  const Index n = x.rows();
  // Weight decay as residuals of their own; the bias of the output goes free.
  problem.residuals = [&](const VectorXd& p, MatrixXd* jacobian) {
    const double weight = std::sqrt(decay);
    VectorXd residual(n + p.size());
    MatrixXd rows(n, p.size());
    for (Index i = 0; i < n; ++i) residual[i] = Layers::output(p, x.row(i), rows.row(i)) - z[i];
    residual.tail(p.size()) = weight * p;
    residual[n + x.cols()] = 0.0;
    if (jacobian) {
      jacobian->setZero(residual.size(), p.size());
      jacobian->topRows(n) = rows;
      jacobian->bottomRows(p.size()).diagonal().setConstant(weight);
      (*jacobian)(n + x.cols(), x.cols()) = 0.0;
    }
    return residual;
  };
  return least_squares_search(problem, first_weights(x.cols(), seed), most_iterations).at;
}

class Network final : public ChannelModel {
public:
  explicit Network(bool memory) : memory_(memory) {}

  void fit(const TrainingData& whole) override {
    const Blocks blocks = make_blocks(whole, most_training_blocks);
    const TrainingData& data = blocks.data;
    info_ = data.info;
    tau_ = {0.0};
    const double span = data.time.size() > 0 ? data.time[data.time.size() - 1] - data.time[0] : 0.0;
    if (memory_) tau_ = {0.0, std::min(3600.0, span / 12.0), std::min(14400.0, span / 4.0)};
    if (memory_ && !(span > 0.0))
      throw InputError(data.label, fmt::format("a record of {} s", span), "a record with a duration");
    const MatrixXd all = lagged_features(data, tau_, blocks.averaged);
    std::vector<Index> rows;
    for (Index i = 0; i < all.rows(); ++i) {
      if (std::isfinite(data.target[i]) && all.row(i).allFinite()) rows.push_back(i);
    }
    const auto n = std::ssize(rows);
    constexpr Index least_rows = 30;
    if (n < least_rows)
      throw InputError(data.label, fmt::format("{} complete blocks", n), fmt::format("at least {}", least_rows));
    const MatrixXd features = all(rows, Eigen::all);
    const VectorXd target = data.target(rows);
    normalise(features, target, data.label);
    MatrixXd x(n, into_.cols());
    for (Index i = 0; i < n; ++i) x.row(i) = component_row(features.row(i));
    const VectorXd z = (target.array() - offset_) / spread_;

    double least = std::numeric_limits<double>::infinity();
    for (const double share : {0.003, 0.03, 0.3}) {
      double squares = 0.0;
      for (Index fold = 0; fold < thirds; ++fold) {
        const Index from = fold * n / thirds, to = (fold + 1) * n / thirds;
        MatrixXd kept(n - (to - from), x.cols());
        VectorXd kept_z(kept.rows());
        kept << x.topRows(from), x.bottomRows(n - to);
        kept_z << z.head(from), z.tail(n - to);
        const VectorXd p = trained(kept, kept_z, share * kept.rows() / 10.0, 0);
        RowVectorXd unused(p.size());
        for (Index i = from; i < to; ++i) squares += std::pow(Layers::output(p, x.row(i), unused) - z[i], 2);
      }
      if (squares < least) {
        least = squares;
        decay_ = share;
      }
    }
    if (!std::isfinite(least))
      throw InputError(data.label, "training that ends in weights that are not finite", "inputs of usual size");
    held_out_rms_ = spread_ * std::sqrt(least / n);
    weights_.resize(Layers::size(x.cols()), seeds);
    for (int seed = 0; seed < seeds; ++seed) weights_.col(seed) = trained(x, z, decay_ * n / 10.0, seed);
  }

  std::unique_ptr<RowPredictor> start() const override { return std::make_unique<Predictor>(*this); }

  std::string explain(const std::string& unit) const override {
    std::string text = fmt::format("{} components of {} inputs", into_.cols(), info_.size());
    if (memory_)
      text += fmt::format(" with memories of {:.3g} and {:.3g} h", tau_[1] / core::units::hour,
                          tau_[2] / core::units::hour);
    return text + fmt::format(", {} tanh, {} seeds, weight decay {:g}, held-out rms {:.3g} {}", hidden, seeds, decay_,
                              held_out_rms_, unit);
  }

  void save(ParameterStore& store) const override {
    store.put("tau_s", Eigen::Map<const VectorXd>(tau_.data(), std::ssize(tau_)));
    store.put("mean", mean_);
    store.put("into", into_);
    store.put("weights", weights_);
    store.put("offset", offset_);
    store.put("spread", spread_);
    store.put("decay", decay_);
    store.put("held_out_rms", held_out_rms_);
  }

  void load(const ParameterStore& store, const std::vector<InputInfo>& info) override {
    info_ = info;
    const VectorXd tau = store.vector("tau_s");
    if (tau.size() != (memory_ ? 3 : 1) || !(tau.array() >= 0.0).all())
      throw InputError(store.place() + " tau_s", "not the model's time constants", "0, and two more with memory");
    tau_.assign(tau.begin(), tau.end());
    mean_ = store.vector("mean", info.size() * tau_.size());
    into_ = store.matrix("into", mean_.size());
    weights_ = store.matrix("weights", Layers::size(into_.cols()));
    offset_ = store.number("offset");
    spread_ = store.number("spread", 0.0);
    decay_ = store.number("decay", 0.0);
    held_out_rms_ = store.number("held_out_rms", 0.0);
  }

private:
  class Predictor final : public RowPredictor {
  public:
    explicit Predictor(const Network& model)
        : model_(model),
          bank_(model.info_, model.tau_),
          unused_(model.weights_.rows()) {}
    double step(double time, const Eigen::Ref<const RowVectorXd>& inputs) override {
      const RowVectorXd x = model_.component_row(bank_.step(time, inputs).reshaped().transpose());
      double sum = 0.0;
      for (Index seed = 0; seed < model_.weights_.cols(); ++seed)
        sum += Layers::output(model_.weights_.col(seed), x, unused_);
      return model_.offset_ + model_.spread_ * sum / model_.weights_.cols();
    }

  private:
    const Network& model_;
    LagBank bank_;
    RowVectorXd unused_;
  };

  RowVectorXd component_row(const Eigen::Ref<const RowVectorXd>& features) const {
    return (features - mean_.transpose()) * into_;
  }

  /// Main components of the features, each divided by its standard deviation.
  void normalise(const MatrixXd& features, const VectorXd& target, const std::string& label) {
    const double n = features.rows();
    mean_ = features.colwise().mean().transpose();
    const MatrixXd centred = features.rowwise() - mean_.transpose();
    VectorXd scale = (centred.colwise().squaredNorm().transpose() / n).cwiseSqrt();
    for (double& value : scale) value = value > 0.0 ? 1.0 / value : 0.0;
    const MatrixXd scaled = centred * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(MatrixXd(scaled.transpose() * scaled / n));
    const VectorXd variance = modes.eigenvalues();
    Index kept = 0;
    constexpr double least_share = 1e-4;
    while (kept < std::min(most_components, variance.size()) &&
           variance[variance.size() - 1 - kept] > least_share * variance.maxCoeff())
      ++kept;
    if (modes.info() != Eigen::Success || kept == 0)
      throw InputError(label, "inputs that are all constant", "at least one input that varies");
    into_.resize(features.cols(), kept);
    for (Index k = 0; k < kept; ++k) {
      const Index mode = variance.size() - 1 - k;
      into_.col(k) = scale.cwiseProduct(modes.eigenvectors().col(mode)) / std::sqrt(variance[mode]);
    }
    offset_ = target.mean();
    spread_ = std::sqrt((target.array() - offset_).square().mean());
    if (!(spread_ > 0.0) || !std::isfinite(spread_))
      throw InputError(label, fmt::format("a displacement that is constant at {}", offset_),
                       "a displacement that varies");
  }

  bool memory_;
  std::vector<InputInfo> info_;
  std::vector<double> tau_;
  VectorXd mean_;
  MatrixXd into_, weights_;
  double offset_ = 0, spread_ = 1, decay_ = 0, held_out_rms_ = 0;
};

}  // namespace

std::unique_ptr<ChannelModel> make_network(bool memory) { return std::make_unique<Network>(memory); }

}  // namespace thermotwin::compensation
