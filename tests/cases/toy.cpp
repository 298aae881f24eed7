// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cases/toy.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <stdexcept>

namespace thermotwin::cases {

namespace fs = std::filesystem;

fs::path toy_case() { return fs::path(THERMOTWIN_CASES_DIR) / "toy"; }

Result make_toy_run() {
  fs::remove_all(THERMOTWIN_RUN_DIR);
  Surroundings surroundings;
  surroundings.display = true;
  Result result = thermotwin({"run", toy_case().string(), "--out", THERMOTWIN_RUN_DIR, "--json"}, "", surroundings);
  // The first start writes online data; later ones only read, also those of tests at the same time.
  thermotwin({"compensate", (fs::path(THERMOTWIN_RUN_DIR) / "model.rom.h5").string()}, "time_s\n0\n");
  return result;
}

const fs::path& toy_run() {
  static const fs::path folder = [] {
    const fs::path summary = fs::path(THERMOTWIN_RUN_DIR) / "summary.json";
    if (!fs::exists(summary) || fs::last_write_time(summary) < fs::last_write_time(THERMOTWIN_PROGRAM)) {
      const Result result = make_toy_run();
      if (result.status != 0) throw std::runtime_error("the toy's run failed: " + result.err);
    }
    return fs::path(THERMOTWIN_RUN_DIR);
  }();
  return folder;
}

std::string toy_model() { return (toy_run() / "model.rom.h5").string(); }

Toy::Toy() { fs::copy(toy_case(), path(), fs::copy_options::recursive); }

void Toy::edit(const std::string& name, const std::string& old, const std::string& with) const {
  std::string text = read(file(name));
  const std::size_t at = text.find(old);
  ASSERT_NE(at, std::string::npos) << name << " has no '" << old << "'";
  write(name, text.replace(at, old.size(), with));
}

void Toy::write(const std::string& name, const std::string& text) const {
  fs::create_directories(fs::path(file(name)).parent_path());
  std::ofstream(file(name), std::ios::binary) << text;
}

void Toy::take_results() const {
  for (const auto& [name, bytes] : files_in(toy_run())) {
    fs::create_directories(result(name).parent_path());
    std::ofstream(result(name), std::ios::binary) << bytes;
  }
}

Result Toy::run(std::vector<std::string> arguments, const Surroundings& surroundings) const {
  arguments.insert(arguments.end(), {"--out", out()});
  return thermotwin(arguments, "", surroundings);
}

void Toy::make_affine() const {
  edit("machine.toml", "radiation = \"exact\"", "radiation = \"linear\"");
  edit("machine.toml", "guide_sensor = \"T3\"", "guide_ambient = \"air\"");
}

void Toy::take_measurement() const {
  fs::copy(toy_run() / "measurement", file("measurement"), fs::copy_options::recursive);
}

std::string read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error("no file " + file.string());
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::map<std::string, std::string> files_in(const fs::path& folder) {
  std::map<std::string, std::string> files;
  if (!fs::exists(folder)) return files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))  // any start may write online data beside a model
    if (entry.path().extension() != ".online" && entry.is_regular_file())
      files[fs::relative(entry.path(), folder).string()] = read(entry.path());
  return files;
}

std::map<std::string, std::string> results_in(const fs::path& folder) {
  auto files = files_in(folder);
  const std::string own = folder.string();
  for (auto& [name, bytes] : files) {
    if (!name.ends_with(".html")) continue;
    for (std::size_t at = 0; (at = bytes.find(own, at)) != std::string::npos;) bytes.replace(at, own.size(), "OUT");
  }
  return files;
}

bool is_checkpoint(const std::string& name) {
  const std::string own = fs::path(name).filename().string();
  return own.starts_with("checkpoint_") || own.starts_with("snapshots_") || own.starts_with("fields_");
}

std::vector<std::string> changes(const std::map<std::string, std::string>& before,
                                 const std::map<std::string, std::string>& after) {
  std::vector<std::string> found;
  for (const auto& [name, bytes] : before) {
    const auto now = after.find(name);
    if (now == after.end())
      found.push_back("gone: " + name);
    else if (now->second != bytes)
      found.push_back("changed: " + name);
  }
  for (const auto& [name, bytes] : after)
    if (before.count(name) == 0 && !name.starts_with("cache/") && !is_checkpoint(name)) found.push_back("new: " + name);
  return found;
}

}  // namespace thermotwin::cases
