// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/online_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <istream>
#include <iterator>
#include <utility>
#include <vector>

#include "core/error.h"
#include "mesh/machine/file.h"
#include "reduction/model/output_grid.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr char magic[] = "ttonline";  // eight letters
constexpr std::size_t word_bytes = 8;

struct Head {
  char magic[word_bytes];
  std::uint64_t version, bytes, sum;
};

constexpr Index largest_order = 10000;
constexpr std::uint64_t empty_sum = 0xCBF29CE484222325ULL;

/// FNV-1a on words, as tt_model_sum. Each step is one to one in the word and in the sum before.
std::uint64_t summed(std::uint64_t sum, const char* bytes, std::size_t size) {
  for (std::size_t at = 0; at < size; at += word_bytes) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes + at, word_bytes);
    sum = (sum ^ word) * 0x100000001B3ULL;
    sum ^= sum >> 29U;
  }
  return sum;
}

constexpr std::size_t whole_words(std::size_t bytes) { return (bytes + word_bytes - 1) / word_bytes * word_bytes; }

class Sink {
public:
  void count(std::int64_t value) { raw(&value, sizeof value); }
  template <class Value>
  void array(const Value* values, std::size_t size) {
    count(size);
    raw(values, size * sizeof(Value));
  }
  void text(const std::string& value) { array(value.data(), value.size()); }
  template <class Value>
  void list(const std::vector<Value>& values) {
    array(values.data(), values.size());
  }
  void matrix(const Eigen::Ref<const MatrixXd>& given) {
    const MatrixXd values = given;
    count(values.rows());
    array(values.data(), values.size());
  }
  void matrices(const std::vector<MatrixXd>& values) {
    count(std::ssize(values));
    for (const MatrixXd& value : values) matrix(value);
  }
  std::string with_head() const {
    Head head{};
    std::memcpy(head.magic, magic, sizeof head.magic);
    head.version = online_version;
    head.bytes = sizeof head + bytes_.size();
    head.sum = online_sum(bytes_);
    std::string whole(sizeof head, '\0');
    std::memcpy(whole.data(), &head, sizeof head);
    return whole + bytes_;
  }

private:
  void raw(const void* from, std::size_t size) {
    const std::size_t before = bytes_.size();
    bytes_.resize(before + whole_words(size), '\0');
    if (size > 0) std::memcpy(bytes_.data() + before, from, size);
  }
  std::string bytes_;
};

MatrixXd columns_of(const std::vector<mesh::Pose>& poses, std::size_t axes) {
  MatrixXd columns(axes, poses.size());
  for (Index i = 0; i < columns.cols(); ++i) columns.col(i) = poses[i];
  return columns;
}

bool is_unit(const MatrixXd& matrix) { return matrix == MatrixXd::Identity(matrix.rows(), matrix.cols()); }

/// The matrices of a block.
struct Block {
  enum Place : std::size_t {
    capacity,  ///< empty: 1
    conduction,
    inputs,
    sensors,
    one_kelvin,
    tool_poses,   ///< a column each
    table_poses,  ///< a column each
    errors,       ///< a column each, of error_numbers
    guard,        ///< largest offset and rate
    of_axes,      ///< slope and rapid, a column each
    count
  };
};
constexpr Index error_numbers = 5;

std::vector<MatrixXd> matrices_of(const OnlineData& data) {
  const reduction::ReducedModel& model = data.model;
  const std::size_t axes = model.machine.axes.size();
  std::vector<MatrixXd> all(Block::count);
  if (!is_unit(model.system.capacity)) all[Block::capacity] = model.system.capacity;
  all[Block::conduction] = model.system.conduction;
  all[Block::inputs] = model.system.inputs;
  all[Block::sensors] = model.system.sensors;
  all[Block::one_kelvin] = model.system.one_kelvin;
  all[Block::tool_poses] = columns_of(model.outputs.tool_poses, axes);
  all[Block::table_poses] = columns_of(model.outputs.table_poses, axes);
  all[Block::errors].resize(error_numbers, std::ssize(model.errors));
  for (Index i = 0; i < all[Block::errors].cols(); ++i) {
    const reduction::ReductionErrors& error = model.errors[i];
    all[Block::errors].col(i) << error.peak_um, error.max_um, error.rms_um, error.estimate_max_um, error.effectivity;
  }
  const OffsetLimits& limits = data.derived.limits;
  all[Block::guard] = Eigen::Vector2d(limits.largest_um, limits.rate_um_s);
  all[Block::of_axes].resize(limits.slope_um.size(), 2);
  all[Block::of_axes] << limits.slope_um, limits.rapid;
  return all;
}

/// Arrays as a block holds them, before they are compared with the machine.
struct Arrays {
  std::string machine, size;
  std::int64_t full_size = 0;
  std::vector<std::int32_t> grids;  ///< axis, periodic and number of positions of each joint's grid
  std::vector<double> positions;
  std::vector<std::string> loads;
  std::vector<MatrixXd> matrices, tool, table_axis, table_own;
};

}  // namespace

std::uint64_t online_sum(std::string_view body) {
  return summed(empty_sum, body.data(), body.size() / word_bytes * word_bytes);
}

void keep_online(reduction::ReducedModel& model) {
  model.system.terms = {};
  model.parts.reset();
  model.patches = {};
  model.trained = {};
  model.sensor_air.reset();
  model.mesh_error.reset();
}

bool can_be_stored(const OnlineData& data) {
  const auto finite = [](const auto& values) {
    return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  };
  const auto all = [&](const std::vector<MatrixXd>& matrices) {
    return std::all_of(matrices.begin(), matrices.end(), [&](const MatrixXd& matrix) { return matrix.allFinite(); });
  };
  const reduction::ReducedOutputs& outputs = data.model.outputs;
  return finite(data.derived.term_left) && finite(data.derived.term_right) && finite(data.derived.term_weight) &&
         all(matrices_of(data)) && all(outputs.tool) && all(outputs.table_axis) && all(outputs.table_own);
}

std::string online_bytes(const OnlineKey& key, const OnlineData& data) {
  const reduction::ReducedModel& model = data.model;
  Sink sink;
  sink.text(key.program);
  sink.text(key.model_line);
  for (const std::int64_t part : key.model_stamp) sink.count(part);
  sink.count(key.order);

  sink.text(model.machine.text);
  sink.text(model.size);
  sink.count(model.full_size);
  std::vector<std::int32_t> grids;
  std::vector<double> positions;
  for (const solver::JointGrid& grid : model.system.layout.grids) {
    const std::int32_t nodes = std::ssize(grid.positions);
    grids.insert(grids.end(), {grid.axis, grid.periodic ? 1 : 0, nodes});
    positions.insert(positions.end(), grid.positions.begin(), grid.positions.end());
  }
  sink.list(grids);
  sink.list(positions);
  sink.count(std::ssize(model.errors));
  for (const reduction::ReductionErrors& error : model.errors) sink.text(error.load);
  sink.matrices(matrices_of(data));
  sink.matrices(model.outputs.tool);
  sink.matrices(model.outputs.table_axis);
  sink.matrices(model.outputs.table_own);
  const DerivedData& derived = data.derived;
  sink.list(derived.term_first);
  sink.list(derived.term_right_first);
  sink.list(derived.term_weight);
  sink.list(derived.term_left);
  sink.list(derived.term_right);
  return sink.with_head();
}

/// Reads what Sink has written. Nothing is allocated that the block cannot hold.
class OnlineReader::Source {
public:
  explicit Source(OnlineReader& reader) : reader_(reader) {}

  std::int64_t count() {
    std::int64_t value = 0;
    raw(&value, 1, sizeof value);
    return value;
  }
  /// @return a count of things of at least so many bytes each
  std::size_t number_of(std::size_t bytes) {
    const std::int64_t value = count();
    if (value < 0 || std::cmp_greater(value, reader_.left_ / bytes)) fail("a length beyond its end");
    return value;
  }
  std::string text() { return list<std::string>(); }
  template <class List>
  List list() {
    List values;
    values.resize(number_of(sizeof(typename List::value_type)));
    raw(values.data(), values.size(), sizeof(typename List::value_type));
    if constexpr (std::is_same_v<typename List::value_type, double>) require_finite(values);
    return values;
  }
  std::vector<double> numbers() { return list<std::vector<double>>(); }
  std::vector<std::int32_t> integers() { return list<std::vector<std::int32_t>>(); }
  MatrixXd matrix() {
    const std::size_t rows = number_of(sizeof(double)), size = number_of(sizeof(double));
    if (rows == 0 ? size != 0 : size % rows != 0) fail("a matrix with a row that is cut off");
    MatrixXd values(rows, rows == 0 ? 0 : size / rows);
    raw(values.data(), size, sizeof(double));
    require_finite(values.reshaped());
    return values;
  }
  std::vector<MatrixXd> matrices() {
    std::vector<MatrixXd> values(number_of(2 * word_bytes));
    for (MatrixXd& value : values) value = matrix();
    return values;
  }

  [[noreturn]] void fail(const std::string& found) const {
    throw core::InputError(reader_.name_, found, "online data as they were written");
  }
  void require(bool good, const char* what) const {
    if (!good) fail(fmt::format("{} other than those of its machine", what));
  }

private:
  template <class Values>
  void require_finite(const Values& values) const {
    for (const double value : values)
      if (!std::isfinite(value)) fail("a number that is not finite");
  }
  void raw(void* to, std::size_t size, std::size_t each) {
    const std::size_t bytes = size * each, rest = whole_words(bytes) - bytes;
    if (whole_words(bytes) > reader_.left_) fail("an end that is missing");
    char* const begin = static_cast<char*>(to);
    const std::size_t inside = bytes / word_bytes * word_bytes;
    if (bytes > 0 && !reader_.in_.read(begin, bytes)) fail("an end that is missing");
    reader_.sum_ = summed(reader_.sum_, begin, inside);
    if (rest > 0) {
      char last[word_bytes] = {};
      std::memcpy(last, begin + inside, bytes - inside);
      if (!reader_.in_.read(last + bytes - inside, rest)) fail("an end that is missing");
      reader_.sum_ = summed(reader_.sum_, last, word_bytes);
    }
    reader_.left_ -= whole_words(bytes);
  }

  OnlineReader& reader_;
};

OnlineReader::OnlineReader(std::istream& in, std::string name) : in_(in), name_(std::move(name)), sum_(empty_sum) {
  Source source(*this);
  in_.seekg(0, std::ios::end);
  const std::streamoff size = in_.tellg();
  in_.seekg(0);
  Head head{};
  char bytes[sizeof head];
  if (size < std::streamoff{sizeof head} || !in_.read(bytes, sizeof bytes) ||
      std::memcmp(bytes, magic, sizeof head.magic) != 0)
    source.fail("no online data");
  std::memcpy(&head, bytes, sizeof head);
  if (head.version != online_version) source.fail(fmt::format("online data of version {}", head.version));
  if (std::cmp_not_equal(head.bytes, size)) source.fail("online data that are cut off");
  left_ = head.bytes - sizeof head;
  stated_sum_ = head.sum;
  key_.program = source.text();
  key_.model_line = source.text();
  for (std::int64_t& part : key_.model_stamp) part = source.count();
  key_.order = source.count();
}

namespace {

/// Terms and inputs follow from the machine and the grids.
template <class Source>
solver::Layout layout_of(const Source& source, const Arrays& arrays, const mesh::Machine& machine) {
  source.require(arrays.grids.size() == 3 * machine.joints.size(), "grids of joints");
  std::vector<solver::JointGrid> grids;
  std::size_t next = 0;
  for (std::size_t j = 0; j < machine.joints.size(); ++j) {
    const std::int32_t *given = &arrays.grids[3 * j], axis = given[0], nodes = given[2];
    source.require(axis >= -1 && axis < std::ssize(machine.axes) && nodes >= 1 &&
                       std::cmp_less_equal(nodes, arrays.positions.size() - next),
                   "grids of joints");
    const auto from = arrays.positions.begin() + next;
    grids.push_back({axis, given[1] != 0, {from, from + nodes}});
    next += nodes;
  }
  source.require(next == arrays.positions.size(), "grids of joints");
  return solver::make_layout(machine, std::move(grids));
}

std::vector<mesh::Pose> poses_of(const MatrixXd& columns) {
  std::vector<mesh::Pose> poses;
  for (Index i = 0; i < columns.cols(); ++i) poses.emplace_back(columns.col(i));
  return poses;
}

bool is_of_size(const MatrixXd& matrix, Index rows, Index columns) {
  return rows * columns == 0 ? matrix.size() == 0 : matrix.rows() == rows && matrix.cols() == columns;
}

bool all_of_size(const std::vector<MatrixXd>& matrices, std::size_t count, Index rows, Index columns) {
  return matrices.size() == count && std::all_of(matrices.begin(), matrices.end(), [&](const MatrixXd& matrix) {
           return is_of_size(matrix, rows, columns);
         });
}

/// A matrix without rows or columns has lost the other extent in the block.
MatrixXd sized(MatrixXd matrix, Index rows, Index columns) {
  return matrix.size() > 0 ? std::move(matrix) : MatrixXd(rows, columns);
}

template <class Source>
void fill_system(const Source& source, Arrays& arrays, const mesh::Machine& machine, reduction::ReducedSystem& system) {
  std::vector<MatrixXd>& m = arrays.matrices;
  const Index order = m[Block::conduction].rows(), loads = std::ssize(system.layout.inputs),
              readings = std::ssize(machine.sensors) + std::ssize(system.layout.observed);
  source.require(order >= 1 && order <= largest_order && is_of_size(m[Block::conduction], order, order),
                 "the conduction");
  source.require(m[Block::capacity].size() == 0 || is_of_size(m[Block::capacity], order, order), "the capacity");
  source.require(is_of_size(m[Block::inputs], order, loads), "inputs");
  source.require(is_of_size(m[Block::sensors], readings, order), "sensors");
  source.require(is_of_size(m[Block::one_kelvin], order, 1), "the state of one kelvin");
  system.capacity = m[Block::capacity].size() > 0 ? std::move(m[Block::capacity]) : MatrixXd::Identity(order, order);
  system.conduction = std::move(m[Block::conduction]);
  system.inputs = sized(std::move(m[Block::inputs]), order, loads);
  system.sensors = sized(std::move(m[Block::sensors]), readings, order);
  system.one_kelvin = m[Block::one_kelvin].col(0);
}

template <class Source>
void fill_outputs(const Source& source, Arrays& arrays, reduction::ReducedModel& model) {
  const mesh::Machine& machine = model.machine;
  const std::vector<MatrixXd>& m = arrays.matrices;
  reduction::ReducedOutputs& outputs = model.outputs;
  const Index order = model.system.order(), axes = std::ssize(machine.axes);
  const std::size_t tools = arrays.tool.size(), tables = arrays.table_axis.size();
  source.require(machine.has_tcp() && reduction::OutputGrid::can_store(machine, tools) &&
                     tables == reduction::OutputGrid(machine, tools).table_count(),
                 "poses");
  source.require(is_of_size(m[Block::tool_poses], axes, std::ssize(arrays.tool)) &&
                     is_of_size(m[Block::table_poses], axes, std::ssize(arrays.table_axis)),
                 "poses");
  source.require(all_of_size(arrays.tool, tools, 6, order) && all_of_size(arrays.table_axis, tables, 6, order) &&
                     all_of_size(arrays.table_own, tables, 7, order),
                 "outputs");
  outputs.tool_poses = poses_of(sized(m[Block::tool_poses], axes, std::ssize(arrays.tool)));
  outputs.table_poses = poses_of(sized(m[Block::table_poses], axes, std::ssize(arrays.table_axis)));
  outputs.tool = std::move(arrays.tool);
  outputs.table_axis = std::move(arrays.table_axis);
  outputs.table_own = std::move(arrays.table_own);
  source.require(is_of_size(m[Block::errors], error_numbers, std::ssize(arrays.loads)), "errors");
  for (Index i = 0; i < std::ssize(arrays.loads); ++i) {
    const auto error = m[Block::errors].col(i);
    model.errors.push_back({arrays.loads[i], error[0], error[1], error[2], error[3], error[4]});
  }
}

template <class Source>
void check_terms(const Source& source, const reduction::ReducedModel& model, const DerivedData& derived) {
  const std::size_t terms = model.system.layout.terms.size(), order = model.system.order();
  const std::vector<std::int32_t>& first = derived.term_first;
  source.require(first.size() == terms + 1 && first.front() == 0 && std::is_sorted(first.begin(), first.end()) &&
                     derived.term_right_first.size() == terms,
                 "terms");
  std::size_t right = 0;
  for (std::size_t j = 0; j < terms; ++j) {
    if (derived.term_right_first[j] == -1) continue;
    source.require(std::cmp_equal(derived.term_right_first[j], right), "terms");
    right += first[j + 1] - first[j];
  }
  const std::size_t columns = first.back();
  source.require(derived.term_weight.size() == columns && derived.term_left.size() == columns * order &&
                     derived.term_right.size() == right * order,
                 "terms");
}

template <class Source>
void fill_limits(const Source& source, const std::vector<MatrixXd>& m, std::size_t axes, OffsetLimits& limits) {
  const Index rows = axes;
  source.require(is_of_size(m[Block::guard], 2, 1) && is_of_size(m[Block::of_axes], rows, 2) &&
                     m[Block::guard].minCoeff() > 0.0 && (m[Block::of_axes].array() >= 0.0).all(),
                 "limits of offsets");
  const MatrixXd each = sized(m[Block::of_axes], rows, 2);
  limits.largest_um = m[Block::guard](0);
  limits.rate_um_s = m[Block::guard](1);
  limits.slope_um = each.col(0);
  limits.rapid = each.col(1);
}

}  // namespace

OnlineData OnlineReader::read(const std::filesystem::path& model_file) {
  Source source(*this);
  Arrays arrays;
  OnlineData data;
  arrays.machine = source.text();
  arrays.size = source.text();
  arrays.full_size = source.count();
  arrays.grids = source.integers();
  arrays.positions = source.numbers();
  arrays.loads.resize(source.number_of(word_bytes));
  for (std::string& load : arrays.loads) load = source.text();
  arrays.matrices = source.matrices();
  arrays.tool = source.matrices();
  arrays.table_axis = source.matrices();
  arrays.table_own = source.matrices();
  data.derived.term_first = source.integers();
  data.derived.term_right_first = source.integers();
  data.derived.term_weight = source.numbers();
  data.derived.term_left = source.numbers();
  data.derived.term_right = source.numbers();
  if (left_ != 0) source.fail("more than its content");
  if (sum_ != stated_sum_) source.fail("a wrong checksum: the file was damaged or changed after it was written");

  data.model.machine = mesh::parse_machine(arrays.machine, model_file / "machine.toml");
  data.model.size = arrays.size;
  data.model.full_size = arrays.full_size;
  source.require(arrays.matrices.size() == Block::count, "matrices");
  data.model.system.layout = layout_of(source, arrays, data.model.machine);
  fill_system(source, arrays, data.model.machine, data.model.system);
  fill_outputs(source, arrays, data.model);
  fill_limits(source, arrays.matrices, data.model.machine.axes.size(), data.derived.limits);
  check_terms(source, data.model, data.derived);
  return data;
}

}  // namespace thermotwin::compensation
