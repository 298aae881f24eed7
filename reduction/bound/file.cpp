// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/bound/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "core/error.h"
#include "core/file.h"
#include "reduction/linear/hdf5_store.h"

namespace thermotwin::reduction {
namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
namespace fs = std::filesystem;

constexpr char format_name[] = "thermotwin error bound";
constexpr Index most_columns = 100000;

IntRows column_of(const std::vector<Index>& numbers) {
  IntRows column(std::ssize(numbers), 1);
  for (std::size_t i = 0; i < numbers.size(); ++i) column(i, 0) = numbers[i];
  return column;
}

}  // namespace

void write_bound(const fs::path& path, const BoundModel& bound) {
  StoreWriter writer(path.string());
  const BoundTerms& terms = bound.terms;
  writer.text_attribute("/", "format", format_name);
  writer.integer_attribute("/", "version", bound_file_version);
  writer.text_attribute("/", "machine_hash", bound.machine_hash);
  writer.integer_attribute("/", "full_size", bound.full_size);
  writer.integer_attribute("/", "order", terms.order());
  writer.integer_attribute("/", "dual_order", terms.dual());
  writer.integer_attribute("/", "probes", terms.probes());
  writer.vector("/failure", Eigen::VectorXd::Constant(1, bound.failure));
  writer.describe("/failure", "probability that the probes underestimate a norm; 0: exact", "1");

  writer.group("/system");
  writer.matrix("/system/inputs", bound.inputs);
  writer.describe("/system/inputs", "input", "W for an input of 1");
  writer.matrix("/system/left_by_inputs", bound.primal_inputs);
  writer.describe("/system/left_by_inputs", "input; one row a probe", "sqrt(W K) for an input of 1");
  writer.vector("/system/one_kelvin", bound.one_kelvin);
  writer.describe("/system/one_kelvin", "state of 1 K everywhere", "1");
  writer.vector("/system/least", bound.least);
  writer.describe("/system/least", "coefficients of the norm, one a term", "unit of the coefficient");

  writer.group("/terms");
  writer.matrix("/terms/base", terms.base);
  writer.describe("/terms/base", "state; rows: U^T K0 U, then the part outside of U, one per probe",
                  "W/K, then sqrt(W K)");
  writer.integers("/terms/first", column_of(terms.first));
  writer.describe("/terms/first", "column of left and right where each term begins, and their end", "1");
  writer.matrix("/terms/left", terms.left);
  writer.describe("/terms/left", "left right^T of a term's columns is as base", "as base for a coefficient of 1");
  writer.matrix("/terms/right", terms.right);
  writer.describe("/terms/right", "as left", "1");
  writer.matrix("/terms/stored", terms.stored);
  writer.describe("/terms/stored", "state beside W; one row a probe", "sqrt(W K) s");

  MatrixXd poses(std::ssize(bound.poses), bound.poses.front().size());
  for (Index i = 0; i < poses.rows(); ++i) poses.row(i) = bound.poses[i].transpose();
  writer.group("/outputs");
  writer.matrix("/outputs/poses", poses);
  writer.describe("/outputs/poses", "axes of the machine in their order", "m or rad");
  writer.stack("/outputs/rows", bound.rows, 6, terms.order());
  writer.describe("/outputs/rows", "(pose, dx dy dz ra rb rc, state)", "m, rad");
  writer.stack("/outputs/rest", bound.rest, terms.probes(), 6);
  writer.describe("/outputs/rest", "(pose, probe, dx dy dz ra rb rc)", "m or rad per sqrt(W/K)");
  core::write_file(path, writer.finish());
}

BoundModel read_bound(const fs::path& path, const ReducedModel& model) {
  std::error_code error;
  if (!fs::is_regular_file(path, error))
    throw InputError(path.string(), "no such file", "bound.rom.h5 as `thermotwin reduce --bound` writes it");
  const StoreReader reader(path);
  if (!reader.has_attribute("format") || !reader.has_attribute("version") ||
      reader.text_attribute("format") != format_name)
    reader.fail("an HDF5 file, but not a bound", "bound.rom.h5 as `thermotwin reduce --bound` writes it");
  if (const std::int64_t version = reader.integer_attribute("version"); version != bound_file_version) {
    reader.fail(fmt::format("version {} of the bound's file", version),
                fmt::format("version {} (write it anew: thermotwin reduce --bound)", bound_file_version));
  }
  BoundModel bound;
  bound.machine_hash = reader.text_attribute("machine_hash");
  bound.full_size = reader.integer_attribute("full_size");
  if (bound.machine_hash != model.machine.hash || bound.full_size != model.full_size) {
    reader.fail("a bound of another machine or mesh than the model's",
                "bound.rom.h5 of the `thermotwin reduce --bound` that wrote the model");
  }
  const Index m = reader.integer_attribute("order"), probes = reader.integer_attribute("probes"),
              dual = reader.integer_attribute("dual_order");
  if (m < 1 || m > most_columns || probes < 1 || dual < 1 || dual > m) {
    reader.fail(fmt::format("order {}, {} of it dual, {} probes", m, dual, probes),
                "1 <= dual_order <= order, at least one probe");
  }
  bound.failure = reader.vector("/failure", 1)(0);
  if (!(bound.failure >= 0.0 && bound.failure < 1.0))
    reader.fail(fmt::format("/failure of {}", bound.failure), "0 .. 1");

  bound.layout = model.system.layout;
  const auto count = bound.layout.terms.size();
  const auto inputs = std::ssize(bound.layout.inputs);
  bound.inputs = reader.matrix("/system/inputs", m, inputs);
  bound.primal_inputs = reader.matrix("/system/left_by_inputs", probes, inputs);
  bound.one_kelvin = reader.vector("/system/one_kelvin", m);
  bound.least = reader.vector("/system/least", count);
  BoundTerms& terms = bound.terms;
  terms.base = reader.matrix("/terms/base", m + probes, m);
  const IntRows first = reader.integers("/terms/first", 1);
  terms.first.assign(first.data(), first.data() + first.size());
  if (terms.first.size() != count + 1 || terms.first.front() != 0 ||
      !std::is_sorted(terms.first.begin(), terms.first.end()))
    reader.fail("/terms/first", fmt::format("{} columns that rise from 0", count + 1));
  terms.left = reader.matrix("/terms/left", m + probes, terms.first.back());
  terms.right = reader.matrix("/terms/right", m, terms.first.back());
  terms.stored = reader.matrix("/terms/stored", probes, m - dual);
  const MatrixXd poses = reader.matrix("/outputs/poses", StoreReader::any, std::ssize(model.machine.axes));
  if (poses.rows() < 1) reader.fail("/outputs/poses without a row", "at least one pose");
  for (Index i = 0; i < poses.rows(); ++i) bound.poses.push_back(poses.row(i).transpose());
  bound.rows = reader.stack("/outputs/rows", poses.rows(), 6, m);
  bound.rest = reader.stack("/outputs/rest", poses.rows(), probes, 6);
  return bound;
}

}  // namespace thermotwin::reduction
