// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Springs that connect the elastic bodies: one for each direction of a joint's pad, and one for each linear scale. The
// equation of a spring is
//   gap = sum of weights times unit functionals of bodies = force / stiffness + own expansion.
// A unit functional is a linear functional of a body's displacement (functionals.h). Its K^+ (model.h) is computed
// once, before the poses. The directions of a pad are the principal directions of its stiffness per area, averaged over
// its faces:
//   k_n n n' + k_t (1 - n n' - a a'),
// with n the normal and a the free direction of a linear guide normal to n. A flat pad has its normal and tangents,
// a bearing's sector its radial, tangential and axial directions. Between two grid nodes of an axis position, the mean
// displacements at both nodes are weighted by hat weights and contact areas.
// The two sides of a contact are a short distance apart. A small couple on the master's surface, force times this
// distance, makes a common rigid motion free of strain. In the same way the bracket of a reading head, from the head's
// body to the line of the scale's tape, turns with the mean rotation of this body. A screw whose axis position comes
// from the motor's encoder is such a scale too: scales_and_screws.h.

#include <Eigen/Core>

#include <array>
#include <unordered_map>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "mesh/machine_mesh.h"
#include "solver/elastic/functionals.h"
#include "solver/elastic/scales_and_screws.h"
#include "solver/elastic/spring.h"
#include "solver/operation/layout.h"
#include "solver/operation/operating_model.h"

namespace thermotwin::solver {

class ContactSearch;

class SpringSet {
public:
  /// Adds the unit functionals of springs and scales to `units`. Joints between bodies that are not both elastic,
  /// and joints without stiffness, carry heat only.
  /// @throws InputError: linear axis that neither scale nor joint holds, scale on an inelastic body
  SpringSet(const mesh::MachineMesh& mesh, const std::vector<JointGrid>& grids, UnitFunctionals& units);

  std::vector<Spring> at(const mesh::Machine& machine, const mesh::Pose& pose) const;

private:
  struct PadNode {
    double area = 0;                            ///< m^2 in contact
    std::array<int, 3> slave{}, master{};       ///< units per direction; master of a rotary axis: x, y, z
    Eigen::Vector3d slave_point, master_point;  ///< m, mean points in their home frames
  };
  struct Pad {
    Eigen::Matrix3d directions;  ///< columns, slave's home frame
    Eigen::Vector3d stiffness;   ///< N/m^3
    int count = 0;               ///< leading directions that have stiffness
    std::vector<PadNode> nodes;
  };
  struct Joint {
    int index = -1;                      ///< into Machine::joints
    int slave = -1, master = -1;         ///< bodies; master -1: ground
    int axis = -1;                       ///< -1: none
    bool rotary = false, guide = false;  ///< guide: free along a linear axis
    JointGrid grid;
    std::array<int, 3> rotation{};  ///< units of the master surface's mean rotation
    std::vector<Pad> pads;
  };
  void add_joint(const mesh::MachineMesh& mesh, int joint, const JointGrid& grid, UnitFunctionals& units);
  /// @param guided  the linear axis along which a guide's pads are free; null: none
  /// @return the pad of each of the slave's faces
  static std::unordered_map<int, int> add_pads(const mesh::MachineMesh& mesh, const mesh::Axis* guided, Joint& joint);
  static void add_grid_node(const mesh::MachineMesh& mesh, const ContactSearch& search,
                            const std::unordered_map<int, int>& pad_of_face, std::size_t node, Joint& joint,
                            UnitFunctionals& units);
  void append(const Joint& joint, const Pad& pad, const Eigen::VectorXd& hat,
              const Eigen::Isometry3d& master_from_slave, std::vector<Spring>& springs) const;

  std::vector<Joint> joints_;
  std::vector<AxisFeedback> feedbacks_;  ///< scales and screws
};

/// Index of the body of a surface.
int body_index_of_surface(const mesh::Machine& machine, const std::string& surface);

}  // namespace thermotwin::solver
