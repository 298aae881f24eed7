// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What ties the elastic bodies together: springs between the mean displacements of a joint's pads
// and linear scales. Each is the gap
//   sum of weights times unit functionals of bodies  (= force / stiffness + own expansion),
// unit functionals being those whose K^+ is solved for beforehand. A pad has the principal
// directions of its mean stiffness per area, mean over its faces of
//   k_n n n' + k_t (1 - n n' - a a'),  a the free direction of a linear guide across n:
// normal and tangents of a flat pad, radial, tangential and axial of a bearing's sector.
// Between grid nodes the two nodes' mean displacements are weighted by hat weights and contact
// areas. A small couple on the master's surface carries the lever between the two sides of the
// contact, so that a common rigid motion never strains a joint. In the same way the reading head's
// bracket, from the body to the tape's line, turns with the mean rotation of the head's body. Screws with
// the position from the motor's encoder are such scales too: elastic_feedback.cpp.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "mesh/machine_mesh.h"
#include "solver/elastic_functionals.h"
#include "solver/operating_model.h"

namespace thermotwin::solver {

/// One unit functional of one body in a sum.
struct UnitTerm {
  int body;       ///< index into Machine::bodies
  int unit;       ///< index into UnitFunctionals of the body
  double weight;
};
using Combination = std::vector<UnitTerm>;

/// Unit functionals per body, collected before the factors are made.
class UnitFunctionals {
 public:
  explicit UnitFunctionals(std::size_t bodies) : of_body_(bodies) {}
  int add(int body, Functional functional);
  const std::vector<Functional>& of(int body) const { return of_body_[static_cast<std::size_t>(body)]; }

 private:
  std::vector<std::vector<Functional>> of_body_;
};

struct Spring {
  Combination gap;            ///< slave minus master; scale: head minus place of the tape's end
  double flexibility = 0;     ///< m/N; 0: constraint
  int expansion_body = -1;    ///< scale, screw: body whose temperature stretches it
  int screw = -1;             ///< the pull of a stretched screw: index into Machine::screws
  int joint = -1;             ///< whose stiffness it has: index into Machine::joints
  int expands_scale = -1, expands_screw = -1;  ///< what expands: index into Machine::scales, screws
  std::vector<std::pair<Eigen::Index, double>> expansion;  ///< (node of that body, m/K)
};

class SpringSet {
 public:
  /// Adds to units what springs and scales need. Joints between bodies that are not both elastic,
  /// and joints without stiffness, carry heat only.
  /// @throws InputError: linear axis that neither scale nor joint holds, scale on an inelastic body
  SpringSet(const mesh::MachineMesh& mesh, const std::vector<JointGrid>& grids,
            UnitFunctionals& units);

  std::vector<Spring> at(const mesh::Machine& machine, const mesh::Pose& pose) const;

 private:
  struct PadNode {
    double area = 0;                       ///< m^2 in contact
    std::array<int, 3> slave{}, master{};  ///< units per direction; master of a rotary axis: x, y, z
    Eigen::Vector3d slave_point, master_point;  ///< m, mean points in their home frames
  };
  struct Pad {
    Eigen::Matrix3d directions;            ///< columns, slave's home frame
    Eigen::Vector3d stiffness;             ///< N/m^3
    int count = 0;                         ///< leading directions that have stiffness
    std::vector<PadNode> nodes;
  };
  struct Joint {
    int index = -1;                        ///< into Machine::joints
    int slave = -1, master = -1;           ///< bodies; master -1: ground
    bool rotary = false, guide = false;    ///< guide: free along a linear axis
    JointGrid grid;
    std::array<int, 3> rotation{};         ///< units of the master surface's mean rotation
    std::vector<Pad> pads;
  };
  /// Temperature along a tape or screw: the mean over points of its skin, linear between stations.
  struct Station { double at; std::vector<SkinPoint> points; };
  /// Mean displacement of points of a body's skin along the axis, carried to the line of the tape.
  struct End {
    int body = -1, unit = -1;
    std::array<int, 3> rotation{-1, -1, -1};  ///< units of the body's mean rotation
    Eigen::Vector3d bracket = Eigen::Vector3d::Zero();  ///< m, times the rotation
  };
  /// A linear scale, or a screw whose motor has the encoder.
  struct Scale {
    int carrier, head;
    Eigen::Vector3d direction, start, fixed, head_point;
    double expansion;
    bool constrains = true;                ///< holds the axis; false: a stretched screw under a scale
    End fixed_end, head_end, far_end;      ///< far_end: of a screw that is stretched between two bearings
    int body = -1;                         ///< whose temperature counts: the carrier's, or the screw's
    int scale = -1, screw = -1;            ///< index into Machine::scales or screws, whichever it is
    double far = 0;                        ///< m along direction from the fixed end to the far one
    double compliance = 0, bearing_compliance = 0;  ///< 1/N of the screw a metre; m/N of one bearing
    std::vector<Station> stations;         ///< along direction from start, m, rising
  };
  void add_joint(const mesh::MachineMesh& mesh, int joint, const JointGrid& grid, UnitFunctionals& units);
  void add_scale(const mesh::MachineMesh& mesh, int scale, UnitFunctionals& units);
  void add_screw(const mesh::MachineMesh& mesh, int screw, UnitFunctionals& units);
  void require_drives(const mesh::Machine& machine) const;
  void append(const Joint& joint, const Pad& pad, const Eigen::VectorXd& hat,
              const Eigen::Isometry3d& master_from_slave, std::vector<Spring>& springs) const;
  void append(const Scale& scale, const mesh::Machine& machine, const mesh::Pose& pose, std::vector<Spring>& springs) const;

  std::vector<Joint> joints_;
  std::vector<Scale> scales_;
};

/// Index of the body of a surface.
int body_index_of_surface(const mesh::Machine& machine, const std::string& surface);

}  // namespace thermotwin::solver
