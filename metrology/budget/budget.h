// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// An uncertainty budget: input quantities with their distributions and correlations, and formulas of measurands.
// docs/reference/budget.md has the keys of its file.

#include <Eigen/Core>

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "metrology/budget/formula.h"

namespace thermotwin::metrology {

enum class Distribution { normal, rectangular, triangular, arcsine };

struct BudgetInput {
  std::string name, unit, says;
  Distribution distribution = Distribution::normal;
  double value = 0, std = 0;                                            ///< estimate and standard uncertainty
  double degrees_of_freedom = std::numeric_limits<double>::infinity();  ///< of std
  int group = 0;  ///< inputs that correlate, also by way of others, share it
};

struct BudgetQuantity {
  std::string name, unit, formula;
};

struct Budget {
  std::string source;  ///< file, for messages
  std::string says;
  std::vector<BudgetInput> inputs;
  Eigen::MatrixXd correlation;  ///< (inputs x inputs), positive semidefinite
  std::vector<BudgetQuantity> quantities;
  double probability = 0.95;     ///< of coverage
  std::optional<double> factor;  ///< k, in place of the probability's
  int draws = 1000000, digits = 2;
  std::uint64_t seed = 1;

  /// @throws InputError naming file, line, value and what is allowed: unknown or double names, a negative standard
  ///         uncertainty, correlations that no quantities can have, a formula that gives no finite value
  static Budget load(const std::filesystem::path& path);
  static Budget parse(const std::string& text, const std::string& source);

  /// Values of the measurands; each formula sees the inputs and the measurands before it.
  class Model {
  public:
    explicit Model(const Budget& budget);
    /// @param inputs  (inputs) @return (quantities); may be not finite
    Eigen::VectorXd operator()(const Eigen::VectorXd& inputs) const;

  private:
    std::vector<Formula> formulas_;
    Eigen::Index inputs_;
    mutable Eigen::VectorXd values_;
  };
};

}  // namespace thermotwin::metrology
