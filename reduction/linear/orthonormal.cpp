// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/linear/orthonormal.h"

#include <Eigen/QR>

namespace thermotwin::reduction {

Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& columns, double independent) {
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  qr.setThreshold(independent);
  return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), qr.rank());
}

}  // namespace thermotwin::reduction
