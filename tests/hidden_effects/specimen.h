// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A machine that is measured: the full model on a mesh, in steps and with nominal values of its own,
// with hidden effects whose footprint, law and time course are not those of the diagnosis. Heat that
// an effect adds is spread by five minutes of conduction, a film's change is uneven over its surface,
// sizes wander by 15 % in the course of hours, a slow sensor is two elements in a row.

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"
#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/causes/parameter.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"

namespace thermotwin::hidden {

/// The same numbers with every library: Box and Muller on the engine's bits.
class Random {
public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low = 0.0, double high = 1.0) {
    return low + (high - low) * ((engine_() >> 11) + 0.5) * 0x1p-53;
  }
  double normal();
  std::size_t index(std::size_t count) { return engine_() % count; }

private:
  std::mt19937_64 engine_;
};

/// What is wrong, in words of the diagnosis: what it should find.
struct Truth {
  diagnosis::Parameter parameter;  ///< of a source_missing: where it is, what it follows, no surface
  double value = 0;                ///< of a source_missing: W where its input is as large as in the record
};

/// Effects that no kind describes; the last three are changes in time and laws that other_law or a step describes.
enum class Outside {
  none,
  hysteretic_joint,
  humid_film,
  slipping_cable,
  jumping_bearing,
  relubricated_bearing,
  lost_preload,
  viscous_bearing
};

struct Draw {
  std::vector<Truth> truths;  ///< none: a clean set
  Outside outside = Outside::none;
  std::string outside_where;
  std::string load;
  std::uint64_t seed = 1;
};

/// What is recorded of a run: a measurement as it comes, or all that is true, at more poses.
enum class Recording { measured, exact };

struct Record {
  compensation::Measurement measurement;
  compensation::Measurement noiseless;  ///< the same rows and gaps without noise and without a module's steps
  std::vector<double>
      effective;  ///< (truths) what each effect amounts to against the nominal machine, in the mean over
                  ///< the record: its size wanders, and the specimen's own value is not the nominal one
};

/// An input that heat may follow, and its largest value under a load.
struct Followable {
  std::string channel;
  double most = 1;
};

/// When the record has rows. @see Specimen::record
enum class Rows {
  own,     ///< at the ends of the load's steps
  sparse,  ///< every 240 to 360 s, none at a change of the inputs but by chance
  pauses,  ///< own ones, without those of two pauses of 1.5 to 4 h
};

struct SpecimenOptions {
  double size_factor = 0.7, refine = 1.4;  ///< mesh; rows of the record relative to the load's own steps
  double tolerance_K = 0.03;               ///< of a step, largest error at any node; a few nodes at a bearing have it
  double solved_to = 1e-5;  ///< of each right-hand side: against 1e-9 a record differs by less than 0.001 um
  double noise_K = 0.05, noise_um = 0.3;
  double missing_share = 0.03;   ///< of values; half as many whole rows
  int finer_pads = 1;            ///< times as finely as stated joints are divided (mesh::with_finer_pads)
  bool exact_radiation = false;  ///< of all films that radiate, whatever is stated
  Rows rows = Rows::own;
  std::uint64_t seed = 1;  ///< of materials
  std::filesystem::path cache;

  void validate() const;  ///< @throws InputError
};

class OutsideEffect;

class Specimen {
public:
  Specimen(const solver::Case& machine_case, const SpecimenOptions& options);

  const mesh::Machine& nominal() const { return case_.machine; }
  /// A measurement that says what its channels are and holds one row: for choosing what to hide.
  compensation::Measurement blank(const std::string& load) const;
  /// @param recording  exact: without noise and gaps, at the poses of a measurement and two that none has seen
  Record record(const Draw& draw, Recording recording = Recording::measured) const;
  compensation::Measurement measure(const Draw& draw, Recording recording = Recording::measured) const {
    return record(draw, recording).measurement;
  }
  /// Speeds and states that a control sends and that change under the load, and the machine being on.
  std::vector<Followable> followable(const std::string& load) const;
  std::size_t measured_poses() const { return measured_poses_; }
  /// 1 W on the skin of a body about a place, (size)
  Eigen::VectorXd warmth_at(const std::string& body, const Eigen::Vector3d& centre) const;
  const mesh::MachineMesh& mesh() const { return full_.mesh; }
  double diagonal() const;  ///< of the box around the machine, m
  Eigen::Index nodes() const { return full_.mesh.nodes(); }

private:
  /// What is true of a machine under a load, at every end of a row.
  struct Run {
    Eigen::VectorXd time;                        ///< (n) s
    Eigen::MatrixXd rows, temperatures, errors;  ///< (n x channels), (n x sensors) degC, (n x 3 poses) um
    Eigen::MatrixXd volumes;                     ///< (n x volumes) degC
    std::optional<double> mean_size;  ///< of the first effect, weighted by what it changes; none: it never acts
  };
  /// What a logger keeps of it.
  static Run logged(Run run, Rows rows, Random& random);
  Run run(const Draw& draw, const mesh::Machine& machine, const std::vector<mesh::Pose>& poses, Random& random,
          OutsideEffect& outside) const;
  mesh::Machine machine_of(std::uint64_t seed) const;
  /// What a sensor takes on where it hangs loose: the air of the nearest film of its body, degC.
  Eigen::VectorXd air_beside(const mesh::SensorSpec& sensor, const mesh::Machine& machine, const Run& run) const;
  double effective_value(const Truth& truth, const mesh::Machine& machine,
                         const std::optional<double>& mean_size) const;
  /// Channels and their columns; values follow.
  compensation::Measurement described(const std::string& load, std::size_t poses) const;

  solver::Case case_;
  SpecimenOptions options_;
  solver::FullModel full_;
  std::vector<mesh::Pose> poses_;  ///< those of measurements first
  std::vector<solver::OutputRows> rows_;
  std::size_t measured_poses_ = 0;
};

}  // namespace thermotwin::hidden
