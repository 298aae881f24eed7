// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// An importer of FMUs of its own: it unpacks the archive and calls the library's functions by their names.

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <dlfcn.h>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>

#include "tests/compensation/control/twin_of_lumps.h"
#include "tests/compensation/shift.h"

namespace thermotwin::compensation::test {

inline const reduction::ReducedModel& lumps() {
  static const reduction::ReducedModel model = lumps_with_lines();
  return model;
}
inline const ControlModel& control() {
  static const ControlModel model(lumps());
  return model;
}

/// Channels, then readings of the sensors.
inline Eigen::VectorXd row_at(const solver::Channels& channels, double time) {
  Eigen::VectorXd row(channels.size() + std::ssize(lumps().machine.sensors));
  for (Eigen::Index s = channels.size(); s < row.size(); ++s)
    row[s] = 20.0 + 0.1 * static_cast<double>(s - channels.size()) + 2.0 * std::sin(time / 7000.0);
  row.head(channels.size()) = working_row(lumps().machine, channels, shift_row(channels, std::max(1.0, time)), time);
  return row;
}

inline std::uint64_t number_at(const std::string& bytes, std::size_t at, int count) {
  std::uint64_t value = 0;
  for (int i = count; i-- > 0;) value = value << 8U | static_cast<unsigned char>(bytes.at(at + i));
  return value;
}

/// By the directory at the archive's end; files are stored.
inline std::map<std::string, std::string> unpacked(const std::string& archive) {
  std::map<std::string, std::string> files;
  const std::size_t end = archive.size() - 22;
  EXPECT_EQ(number_at(archive, end, 4), 0x06054B50U);
  std::size_t at = number_at(archive, end + 16, 4);
  for (std::uint64_t i = 0; i < number_at(archive, end + 10, 2); ++i) {
    EXPECT_EQ(number_at(archive, at, 4), 0x02014B50U);
    const std::size_t name = number_at(archive, at + 28, 2), size = number_at(archive, at + 24, 4);
    const std::size_t local = number_at(archive, at + 42, 4);
    EXPECT_EQ(number_at(archive, local, 4), 0x04034B50U);
    const std::string entry = archive.substr(at + 46, name);
    EXPECT_TRUE(files.emplace(entry, archive.substr(local + 30 + name, size)).second) << entry << " twice";
    at += 46 + name;
  }
  return files;
}

/// The library's functions by their names.
class Importer {
public:
  explicit Importer(const std::filesystem::path& library) : handle_(dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL)) {
    EXPECT_NE(handle_, nullptr) << dlerror();
  }
  ~Importer() { dlclose(handle_); }
  Importer(const Importer&) = delete;
  Importer& operator=(const Importer&) = delete;

  template <class Result = int, class... Arguments>
  Result call(const char* name, Arguments... arguments) const {
    void* found = dlsym(handle_, name);
    if (found == nullptr) throw std::runtime_error(std::string("no function ") + name);
    Result (*function)(Arguments...) = nullptr;
    std::memcpy(&function, &found, sizeof found);
    return function(arguments...);
  }

private:
  void* handle_;
};

}  // namespace thermotwin::compensation::test
