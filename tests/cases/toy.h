// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The toy machine of tests/cases/toy: a copy that a test may change, and the run of the whole chain
// that all tests share.

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tests/cases/program.h"
#include "tests/core/temporary_folder.h"

/// The text holds the words.
#define EXPECT_SAYS(text, words) EXPECT_PRED_FORMAT2(::testing::IsSubstring, words, text)

namespace thermotwin::cases {

/// The case as it is in the source tree.
std::filesystem::path toy_case();

/// Results of `run` on it (model.rom.h5, campaign/, measurement/, diagnosis/, ...); made by the
/// first test that asks, where the one that ctest runs first has not made them with this program.
const std::filesystem::path& toy_run();

/// The path of its model.rom.h5.
std::string toy_model();

/// Runs the chain anew. @return what the program said
Result make_toy_run();

/// A copy of the case in a folder of the test's own, with a place for results.
class Toy {
public:
  Toy();
  /// Replaces the one place that reads so; the test fails where there is none.
  void edit(const std::string& file, const std::string& old, const std::string& with) const;
  void write(const std::string& file, const std::string& text) const;
  /// Nothing follows the machine's own temperatures: no chiller with a sensor, no exact radiation.
  void make_affine() const;
  /// measurement/ of the case becomes a copy of the one that toy_run() made.
  void take_measurement() const;
  /// out() becomes a copy of the results of toy_run().
  void take_results() const;

  std::string path() const { return (folder_ / "toy").string(); }
  std::string file(const std::string& name) const { return path() + "/" + name; }
  std::string out() const { return (folder_ / "out").string(); }
  std::filesystem::path result(const std::string& name) const { return folder_ / "out" / name; }

  /// thermotwin VERB ... --out out()
  Result run(std::vector<std::string> arguments, const Surroundings& surroundings = {}) const;

private:
  core::TemporaryFolder folder_;
};

/// Bytes of all files below, by their relative names.
std::map<std::string, std::string> files_in(const std::filesystem::path& folder);
/// The same, where pages, which print commands, say OUT instead of the folder's path.
std::map<std::string, std::string> results_in(const std::filesystem::path& folder);

/// Whether the file serves to go on with a stopped campaign and is no result.
bool is_checkpoint(const std::string& name);

/// Names of the earlier files that are gone or changed, and of new ones but for meshes of the cache
/// and checkpoints.
std::vector<std::string> changes(const std::map<std::string, std::string>& before,
                                 const std::map<std::string, std::string>& after);

std::string read(const std::filesystem::path& file);

}  // namespace thermotwin::cases
