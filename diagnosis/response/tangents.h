// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A step of propagation.h: the nominal machine on a reduced model, and tangents beside it that share its factors. The
// thermal state can be kept and taken up again, so that several continuations of one run are compared.

#include <Eigen/Core>

#include <memory>
#include <optional>
#include <vector>

#include "diagnosis/response/propagation.h"
#include "solver/operation/chiller.h"

namespace thermotwin::diagnosis {

/// The nominal machine, step by step.
class NominalRun {
public:
  /// @param nominal  must outlive it; its observations may change between steps
  explicit NominalRun(const Nominal& nominal);
  ~NominalRun();
  NominalRun(const NominalRun&) = delete;
  NominalRun& operator=(const NominalRun&) = delete;

  /// Both stages of a step of the observations. @param columns  that are solved for beside the state, both stages
  void advance(Eigen::Index step, Eigen::Index columns);
  void finish();  ///< the state is that of the end of the step

  struct Kept {
    Eigen::VectorXd state;
    std::optional<solver::Chiller> chiller;
  };
  Kept keep() const;  ///< between two steps
  void take_up(const Kept& kept);

  const Eigen::VectorXd& state() const { return state_; }        ///< (r) at the start of the step
  const Eigen::VectorXd& last() const { return last_; }          ///< (r) at its end
  double scale() const { return scale_; }                        ///< s, gamma times the step
  Eigen::MatrixXd stored(const Eigen::MatrixXd& columns) const;  ///< capacity times columns
  /// (E + gamma h A)^-1 columns
  Eigen::MatrixXd solve(const Eigen::MatrixXd& columns) const;

private:
  friend class Tangents;
  struct Work;
  const Nominal& nominal_;
  std::unique_ptr<Work> work_;
  Eigen::VectorXd state_, sensors_;      ///< at the start of the step
  Eigen::VectorXd first_, next_, last_;  ///< stages, and what the second one starts from
  double step_ = 0, scale_ = 0;
};

/// Tangents of some variants, advanced beside a run.
class Tangents {
public:
  /// @param variants  must outlive it  @param first, last  those that it advances
  Tangents(const NominalRun& run, const std::vector<Variant>& variants, std::size_t first, std::size_t last);
  ~Tangents();

  void advance(Eigen::Index step);  ///< between advance() and finish() of the run
  /// (r x variants) in units of each variant's step
  const Eigen::MatrixXd& state() const { return state_; }
  std::size_t first() const { return first_; }

  struct Kept {
    Eigen::MatrixXd state;
    std::vector<std::optional<solver::Chiller>> chillers;
  };
  Kept keep() const;
  void take_up(const Kept& kept);

private:
  struct Drives;
  const Variant& variant(std::size_t v) const { return variants_[first_ + v]; }
  void update(Eigen::Index step);
  Eigen::MatrixXd solve(const Eigen::MatrixXd& start, const Eigen::VectorXd& nominal, const Eigen::VectorXd& before);
  bool switches_flow(const Eigen::VectorXd& p, const Eigen::VectorXd& own) const;
  Eigen::VectorXd held_exactly(std::size_t v, const Eigen::MatrixXd& start, const Eigen::VectorXd& nominal,
                               const Eigen::VectorXd& before);

  const NominalRun& run_;
  const std::vector<Variant>& variants_;
  std::size_t first_, count_;
  std::unique_ptr<Drives> drives_;
  Eigen::MatrixXd state_, heat_;        ///< (r x variants)
  std::vector<Eigen::VectorXd> image_;  ///< K_j x of the present stage, where a variant asks for it
  std::vector<char> known_;
};

/// A run with all tangents of its variants, in blocks of fixed width, so that results do not depend on the threads.
class RunWithTangents {
public:
  RunWithTangents(const Nominal& nominal, const std::vector<Variant>& variants);
  void advance(Eigen::Index step);

  const Eigen::VectorXd& state() const { return run_.state(); }
  const std::vector<std::unique_ptr<Tangents>>& blocks() const { return blocks_; }
  Eigen::MatrixXd tangents() const;  ///< (r x variants) in units of each variant's step
  bool finite() const;

  struct Kept {
    NominalRun::Kept run;
    std::vector<Tangents::Kept> blocks;
  };
  Kept keep() const;
  void take_up(const Kept& kept);

private:
  NominalRun run_;
  std::vector<std::unique_ptr<Tangents>> blocks_;
  Eigen::Index variants_;
};

}  // namespace thermotwin::diagnosis
