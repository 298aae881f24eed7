// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/tests/test_estimate.h"

#include <Eigen/Cholesky>

#include <algorithm>

#include "core/error.h"

namespace thermotwin::study {

using compensation::MeasuredChannel;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double least_ratio = 0.05;

/// The values of the channels that a test reads, at any time.
class Record {
public:
  Record(const compensation::Measurement& measured, const mesh::Machine& machine, const TestSetup& setup)
      : time_(measured.time()) {
    for (const int sensor : setup.sensors) {
      const std::string& id = machine.sensors[sensor].id;
      sensors_.push_back(
          measured.values(channel(measured, id, [&](const MeasuredChannel& c) { return c.sensor == id; })));
      sensors_.back().array() -= machine.reference_C;
    }
    for (const mesh::Pose& pose : setup.probes) {
      const std::string at = mesh::format_pose(machine, pose);
      for (const char* quantity : {"dx", "dy", "dz"}) {
        probes_.push_back(measured.values(channel(measured, std::string(quantity) + " at " + at, [&](const auto& c) {
          return c.quantity == quantity && c.pose_text == at;
        })));
        probes_.back().array() -= probes_.back()[0];
      }
    }
  }

  VectorXd at(const TestReadings& readings) const {
    const std::vector<VectorXd>& channels = readings.probe ? probes_ : sensors_;
    VectorXd values(std::ssize(channels));
    const Index last = time_.size() - 1;
    const Index after =
        std::clamp<Index>(std::lower_bound(time_.begin(), time_.end(), readings.time - 1e-6) - time_.begin(), 1, last);
    const double share = std::clamp((readings.time - time_[after - 1]) / (time_[after] - time_[after - 1]), 0.0, 1.0);
    for (Index i = 0; i < values.size(); ++i)
      values[i] = (1.0 - share) * channels[i][after - 1] + share * channels[i][after];
    return values;
  }

private:
  template <class Is>
  static const MeasuredChannel& channel(const compensation::Measurement& measured, const std::string& name,
                                        const Is& is) {
    const auto found = std::find_if(measured.channels.begin(), measured.channels.end(), is);
    if (found == measured.channels.end())
      throw core::InputError(measured.folder.string(), "no channel of " + name, "all that the test reads");
    return *found;
  }

  VectorXd time_;
  std::vector<VectorXd> sensors_, probes_;
};

}  // namespace

VectorXd estimate(const reduction::ReducedModel& model, const TestSetup& setup, const TestBlock& test,
                  const compensation::Measurement& measured, int rounds) {
  const Record record(measured, model.machine, setup);
  const Index count = std::ssize(setup.parameters);
  VectorXd nominal(count), std(count);
  for (Index p = 0; p < count; ++p) {
    nominal[p] = setup.parameters[p].parameter.nominal;
    std[p] = setup.parameters[p].std;
  }
  VectorXd values = nominal;
  for (int round = 0; round < rounds; ++round) {
    const VectorXd here = (values - nominal).cwiseQuotient(std);
    VectorXd right = VectorXd::Zero(setup.unknowns());
    TestRun run(model, values, setup);
    MatrixXd posterior = run.run(test, [&](const TestReadings& readings) {
      const VectorXd off = record.at(readings) - readings.predicted + readings.rows.leftCols(count) * here;
      right += readings.rows.transpose() * off.cwiseQuotient(readings.std.cwiseAbs2());
    });
    posterior.diagonal().array() += 1.0;
    const VectorXd found = posterior.llt().solve(right);
    values = nominal + std.cwiseProduct(found.head(count));
    for (Index p = 0; p < count; ++p)
      if (setup.parameters[p].parameter.ratio) values[p] = std::max(values[p], least_ratio);
  }
  return values;
}

}  // namespace thermotwin::study
