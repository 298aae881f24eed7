// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/bound_file.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/file.h"
#include "reduction/hdf5_store.h"

namespace thermotwin::reduction {
namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
namespace fs = std::filesystem;

constexpr char format_name[] = "thermotwin error bound";
constexpr Index most_columns = 100000;

}  // namespace

void write_bound(const fs::path& path, const BoundModel& bound) {
  StoreWriter writer(path.string());
  const ReducedSystem& system = bound.system;
  const Index m = system.order(), d = bound.dual, probes = bound.primal_inputs.rows();
  writer.text_attribute("/", "format", format_name);
  writer.integer_attribute("/", "version", bound_file_version);
  writer.text_attribute("/", "machine_hash", bound.machine_hash);
  writer.integer_attribute("/", "full_size", bound.full_size);
  writer.integer_attribute("/", "order", m);
  writer.integer_attribute("/", "dual_order", d);
  writer.integer_attribute("/", "probes", probes);
  writer.vector("/failure", Eigen::VectorXd::Constant(1, bound.failure));
  writer.describe("/failure", "share of draws of the probes for which one norm is seen too small; 0: exact", "1");

  writer.group("/system");
  writer.matrix("/system/conduction", system.conduction);
  writer.describe("/system/conduction", "state", "W/K");
  writer.stack("/system/terms", system.terms, m, m);
  writer.describe("/system/terms", "(term, state, state)", "W/K for a coefficient of 1 in its unit");
  writer.matrix("/system/inputs", system.inputs);
  writer.describe("/system/inputs", "input", "W for an input of 1");
  writer.vector("/system/one_kelvin", system.one_kelvin);
  writer.describe("/system/one_kelvin", "state of 1 K everywhere", "1");
  writer.vector("/system/least", bound.least);
  writer.describe("/system/least", "coefficients of the norm, one a term", "unit of the coefficient");

  writer.group("/residuals");
  writer.stack("/residuals/primal", bound.primal, probes, m);
  writer.describe("/residuals/primal", "(K0 and terms, probe, state)", "sqrt(W K) for a coefficient of 1");
  writer.matrix("/residuals/inputs", bound.primal_inputs);
  writer.describe("/residuals/inputs", "input; one row a probe", "sqrt(W K) for an input of 1");
  writer.stack("/residuals/dual", bound.dual_terms, probes, d);
  writer.describe("/residuals/dual", "(K0 and terms, probe, state of W)", "as primal");

  MatrixXd poses(static_cast<Index>(bound.poses.size()), bound.poses.front().size());
  for (Index i = 0; i < poses.rows(); ++i) poses.row(i) = bound.poses[static_cast<std::size_t>(i)].transpose();
  writer.group("/outputs");
  writer.matrix("/outputs/poses", poses);
  writer.describe("/outputs/poses", "axes of the machine in their order", "m or rad");
  writer.stack("/outputs/rows", bound.rows, 6, m);
  writer.describe("/outputs/rows", "(pose, dx dy dz ra rb rc, state)", "m, rad");
  writer.stack("/outputs/rest", bound.rest, probes, 6);
  writer.describe("/outputs/rest", "(pose, probe, dx dy dz ra rb rc)", "m or rad per sqrt(W/K)");
  core::write_file(path, writer.finish());
}

BoundModel read_bound(const fs::path& path, const ReducedModel& model) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) throw InputError(path.string(), "no such file", "bound.rom.h5 as `thermotwin reduce --bound` writes it");
  const StoreReader reader(path);
  if (!reader.has_attribute("format") || !reader.has_attribute("version") || reader.text_attribute("format") != format_name)
    reader.fail("an HDF5 file, but not a bound", "bound.rom.h5 as `thermotwin reduce --bound` writes it");
  if (const std::int64_t version = reader.integer_attribute("version"); version != bound_file_version)
    reader.fail(fmt::format("version {} of the bound's file", version), fmt::format("version {} (write it anew: thermotwin reduce --bound)", bound_file_version));
  BoundModel bound;
  bound.machine_hash = reader.text_attribute("machine_hash");
  bound.full_size = static_cast<Index>(reader.integer_attribute("full_size"));
  if (bound.machine_hash != model.machine.hash || bound.full_size != model.full_size)
    reader.fail("a bound of another machine or mesh than the model's", "bound.rom.h5 of the `thermotwin reduce --bound` that wrote the model");
  const auto m = static_cast<Index>(reader.integer_attribute("order")), probes = static_cast<Index>(reader.integer_attribute("probes"));
  bound.dual = static_cast<Index>(reader.integer_attribute("dual_order"));
  if (m < 1 || m > most_columns || probes < 1 || bound.dual < 1 || bound.dual > m)
    reader.fail(fmt::format("order {}, {} of it dual, {} probes", m, bound.dual, probes), "1 <= dual_order <= order, at least one probe");
  bound.failure = reader.vector("/failure", 1)(0);
  if (!(bound.failure >= 0.0 && bound.failure < 1.0)) reader.fail(fmt::format("/failure of {}", bound.failure), "0 .. 1");

  ReducedSystem& system = bound.system;
  system.layout = model.system.layout;
  const auto terms = static_cast<Index>(system.layout.terms.size()), inputs = static_cast<Index>(system.layout.inputs.size());
  system.capacity = MatrixXd::Identity(m, m);
  system.conduction = reader.matrix("/system/conduction", m, m);
  system.terms = reader.stack("/system/terms", terms, m, m);
  system.inputs = reader.matrix("/system/inputs", m, inputs);
  system.one_kelvin = reader.vector("/system/one_kelvin", m);
  bound.least = reader.vector("/system/least", terms);
  bound.primal = reader.stack("/residuals/primal", terms + 1, probes, m);
  bound.primal_inputs = reader.matrix("/residuals/inputs", probes, inputs);
  bound.dual_terms = reader.stack("/residuals/dual", terms + 1, probes, bound.dual);
  const MatrixXd poses = reader.matrix("/outputs/poses", StoreReader::any, static_cast<Index>(model.machine.axes.size()));
  if (poses.rows() < 1) reader.fail("/outputs/poses without a row", "at least one pose");
  for (Index i = 0; i < poses.rows(); ++i) bound.poses.push_back(poses.row(i).transpose());
  bound.rows = reader.stack("/outputs/rows", poses.rows(), 6, m);
  bound.rest = reader.stack("/outputs/rest", poses.rows(), probes, 6);
  return bound;
}

}  // namespace thermotwin::reduction
