// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The lumped machine of five_axis.h in coordinates in which its capacity is 1, as that of a reduced model is, and
// memory for a part of the online core.

#include <Eigen/Cholesky>

#include <vector>

#include "compensation/control/arena.h"
#include "tests/machines/five_axis.h"

namespace thermotwin::compensation::test {

/// x' = L^T x with E = L L^T.
inline reduction::ReducedModel unit_capacity(reduction::ReducedModel model) {
  reduction::ReducedSystem& system = model.system;
  const Eigen::LLT<Eigen::MatrixXd> factor(system.capacity);
  const Eigen::MatrixXd lower = factor.matrixL(), identity = Eigen::MatrixXd::Identity(lower.rows(), lower.rows());
  const Eigen::MatrixXd back = lower.triangularView<Eigen::Lower>().solve(identity);  // L^-1
  const auto turn = [&](Eigen::MatrixXd& matrix) { matrix = (back * matrix * back.transpose()).eval(); };
  const auto turn_rows = [&](std::vector<Eigen::MatrixXd>& all) {
    for (Eigen::MatrixXd& rows : all) rows = (rows * back.transpose()).eval();
  };
  turn(system.conduction);
  for (Eigen::MatrixXd& term : system.terms) turn(term);
  system.capacity = identity;
  system.inputs = (back * system.inputs).eval();
  system.sensors = (system.sensors * back.transpose()).eval();
  system.one_kelvin = (lower.transpose() * system.one_kelvin).eval();
  turn_rows(model.outputs.tool);
  turn_rows(model.outputs.table_axis);
  turn_rows(model.outputs.table_own);
  return model;
}

/// A part of the core in memory of its own.
template <class Part, class Model>
class InArena {
public:
  using Lay = void (*)(Part*, const Model*, tt_arena*);
  InArena(Lay lay, const Model& model) {
    tt_arena counting{nullptr, 0};
    lay(&part_, &model, &counting);
    block_.resize(counting.used / sizeof(double));
    tt_arena arena{reinterpret_cast<unsigned char*>(block_.data()), 0};
    lay(&part_, &model, &arena);
  }
  InArena(const InArena&) = delete;
  InArena& operator=(const InArena&) = delete;
  Part* operator->() { return &part_; }
  Part* get() { return &part_; }
  std::vector<double>& block() { return block_; }

private:
  Part part_{};
  std::vector<double> block_;
};

}  // namespace thermotwin::compensation::test
