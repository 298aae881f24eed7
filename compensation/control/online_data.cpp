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

#include "compensation/control/online_arrays.h"
#include "mesh/machine/file.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr char magic[] = "ttonline";  // eight letters
constexpr std::size_t word_bytes = 8;

struct Head {
  char magic[word_bytes];
  std::uint64_t version, bytes, sum;
};

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

  [[noreturn]] void fail(const std::string& found) const { refuse_online_data(reader_.name_, found); }

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
      if (!reader_.in_.read(last + (bytes - inside), rest)) fail("an end that is missing");
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

OnlineData OnlineReader::read(const std::filesystem::path& model_file) {
  Source source(*this);
  OnlineArrays arrays;
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
  fill_from(std::move(arrays), name_, data);
  return data;
}

}  // namespace thermotwin::compensation
