// SPDX-License-Identifier: GPL-3.0-or-later
// The FMU of FMI 3.0 in the standard's order of calls.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "compensation/control/control_fmu.h"
#include "core/file.h"
#include "tests/compensation/control/importer.h"
#include "tests/compensation/scratch.h"

namespace thermotwin::compensation {
namespace {

using Eigen::VectorXd;
using test::control;
using test::Importer;
using test::lumps;
using test::row_at;
using Instance = void*;

int logged3 = 0;
void log_message3(void* /*environment*/, int /*status*/, const char* /*category*/, const char* /*message*/) {
  ++logged3;
}

class Fmu3 : public ::testing::Test {
protected:
  void SetUp() override {
    write_fmu(folder_.path() / "twin.fmu", control().data(), 3);
    files_ = test::unpacked(core::read_file(folder_.path() / "twin.fmu"));
    for (const auto& [name, content] : files_) core::write_file(folder_.path() / "fmu" / name, content);
    importer_.emplace(folder_.path() / "fmu/binaries/x86_64-linux/thermotwin.so");
    std::smatch found;
    ASSERT_TRUE(
        std::regex_search(files_["modelDescription.xml"], found, std::regex("instantiationToken=\"([^\"]*)\"")));
    token_ = found[1];
  }
  Instance instantiate(const std::string& token) const {
    const std::string resources = (folder_.path() / "fmu/resources/").string();
    const unsigned* no_references = nullptr;
    void *environment = nullptr, *update = nullptr;
    return importer_->call<Instance>("fmi3InstantiateCoSimulation", "one", token.c_str(), resources.c_str(), false,
                                     true, false, false, no_references, std::size_t{0}, environment, &log_message3,
                                     update);
  }
  /// With events, and with intermediate variables.
  Instance instantiate_with(bool events, std::size_t between, bool logging) const {
    const std::string resources = (folder_.path() / "fmu/resources/").string();
    const unsigned references[] = {0};
    const unsigned* r = references;
    void *environment = nullptr, *update = nullptr;
    return importer_->call<Instance>("fmi3InstantiateCoSimulation", "one", token_.c_str(), resources.c_str(), false,
                                     logging, events, false, r, between, environment, &log_message3, update);
  }
  Instance begun(const VectorXd& row) const {
    const Instance c = instantiate(token_);
    EXPECT_NE(c, nullptr);
    EXPECT_EQ(importer_->call("fmi3EnterInitializationMode", c, false, 0.0, 0.0, false, 0.0), 0);
    set(c, row);
    EXPECT_EQ(importer_->call("fmi3ExitInitializationMode", c), 0);
    return c;
  }
  void set(Instance c, const VectorXd& row) const {
    std::vector<unsigned> references(row.size());
    VectorXd values = row;
    for (unsigned k = 0; k < references.size(); ++k) {
      references[k] = k;
      if (std::isnan(values[k])) values[k] = -1e30;
    }
    const unsigned* r = references.data();
    const double* v = values.data();
    EXPECT_EQ(importer_->call("fmi3SetFloat64", c, r, references.size(), v, references.size()), 0);
  }
  int step(Instance c, double time, double length) const {
    bool event = true, terminate = true, early = true;
    double last = -1.0;
    const int status = importer_->call("fmi3DoStep", c, time, length, true, &event, &terminate, &early, &last);
    EXPECT_TRUE(status != 0 || !(event || terminate || early));
    EXPECT_TRUE(status != 0 || last == time + length);
    return status;
  }
  static unsigned first_output() { return control().model().channels + control().model().sensors; }
  /// Offsets of the three axes, then their deviations.
  VectorXd offsets(Instance c) const {
    std::vector<unsigned> references(6);
    for (unsigned k = 0; k < 6; ++k) references[k] = first_output() + k;
    const unsigned* r = references.data();
    VectorXd values(6);
    EXPECT_EQ(importer_->call("fmi3GetFloat64", c, r, std::size_t{6}, values.data(), std::size_t{6}), 0);
    return values;
  }
  int status(Instance c) const {
    const unsigned reference = first_output() + 6;
    int value = -1;
    EXPECT_EQ(importer_->call("fmi3GetInt32", c, &reference, std::size_t{1}, &value, std::size_t{1}), 0);
    return value;
  }

  test::Scratch folder_;
  std::map<std::string, std::string> files_;
  std::optional<Importer> importer_;
  std::string token_;
};

TEST_F(Fmu3, WhatTheDescriptionDoesNotStateIsRefused) {
  logged3 = 0;
  EXPECT_EQ(instantiate_with(true, 0, true), nullptr) << "event mode";
  EXPECT_EQ(instantiate_with(false, 1, true), nullptr) << "intermediate variables";
  EXPECT_EQ(logged3, 2);
  EXPECT_EQ(instantiate_with(true, 0, false), nullptr);
  EXPECT_EQ(logged3, 2) << "without logging";
  const Instance c = instantiate_with(false, 0, false);
  ASSERT_NE(c, nullptr);
  EXPECT_EQ(importer_->call("fmi3ExitInitializationMode", c), 3);
  EXPECT_EQ(logged3, 2);
  EXPECT_EQ(importer_->call("fmi3SetDebugLogging", c, true, std::size_t{0}, static_cast<const char* const*>(nullptr)),
            0);
  EXPECT_EQ(importer_->call("fmi3ExitInitializationMode", c), 3);
  EXPECT_EQ(logged3, 3);
  importer_->call<void>("fmi3FreeInstance", c);
}

TEST_F(Fmu3, HasTheBitsOfTheCoreAndOfASerialisedState) {
  const solver::OperatingModel operating(lumps().machine, lumps().system.layout);
  const Eigen::Index channels = operating.channels().size();
  EXPECT_STREQ(importer_->call<const char*>("fmi3GetVersion"), "3.0");
  VectorXd row = row_at(operating.channels(), 0.0);
  const Instance one = begun(row), two = begun(row);
  test::Twin twin(control().model());
  const auto feed = [&](double time) { return twin.row(time, row.head(channels), row.tail(row.size() - channels)); };
  feed(0.0);
  std::vector<unsigned char> bytes;
  double time = 0.0;
  for (int i = 0; i < 5000; ++i) {
    const double length = i % 1000 < 900 ? 0.25 : 7.0;
    if (i % 20 == 0) {
      row = row_at(operating.channels(), time);
      set(one, row);
    }
    ASSERT_EQ(step(one, time, length), 0);
    if (!bytes.empty()) {
      set(two, row);
      ASSERT_EQ(step(two, time, length), 0);
    }
    time += length;
    ASSERT_EQ(feed(time), status(one));
    ASSERT_TRUE(offsets(one) == (VectorXd(6) << twin.offset_um(), twin.std_um()).finished()) << i;
    if (i != 3333) continue;
    void* state = nullptr;
    std::size_t size = 0;
    ASSERT_EQ(importer_->call("fmi3GetFMUState", one, &state), 0);
    ASSERT_EQ(importer_->call("fmi3SerializedFMUStateSize", one, state, &size), 0);
    bytes.resize(size);
    ASSERT_EQ(importer_->call("fmi3SerializeFMUState", one, state, bytes.data(), size), 0);
    EXPECT_EQ(importer_->call("fmi3FreeFMUState", one, &state), 0);
    EXPECT_EQ(state, nullptr);
    void* other = nullptr;
    const unsigned char* from = bytes.data();
    for (std::size_t at = 0; at < 320; ++at) {
      bytes[at] ^= 0x40;
      ASSERT_EQ(importer_->call("fmi3DeserializeFMUState", two, from, size, &other), 3) << at;
      bytes[at] ^= 0x40;
    }
    ASSERT_EQ(importer_->call("fmi3DeserializeFMUState", two, from, size, &other), 0);
    ASSERT_EQ(importer_->call("fmi3SetFMUState", two, other), 0);
    EXPECT_EQ(importer_->call("fmi3FreeFMUState", two, &other), 0);
    ASSERT_TRUE(offsets(two) == offsets(one));
  }
  EXPECT_TRUE(offsets(two) == offsets(one));
  EXPECT_GT(twin.offset_um().norm(), 1.0);
  EXPECT_EQ(importer_->call("fmi3Terminate", one), 0);
  for (const Instance c : {one, two}) importer_->call<void>("fmi3FreeInstance", c);
}

TEST_F(Fmu3, RefusesWhatItCannotDo) {
  logged3 = 0;
  EXPECT_EQ(instantiate("{0123456789abcdef}"), nullptr);
  EXPECT_EQ(logged3, 1);
  const Instance c = begun(VectorXd::Constant(1, 1.0));
  EXPECT_EQ(step(c, 0.0, 5.0), 0);
  EXPECT_EQ(step(c, 4.0, 0.5), 3) << "back in time";
  const unsigned reference = 5000;
  double value = 0.0;
  EXPECT_EQ(importer_->call("fmi3GetFloat64", c, &reference, std::size_t{1}, &value, std::size_t{1}), 3);
  const unsigned of_time = first_output() + 6 + 2 + control().model().sensors;
  EXPECT_EQ(importer_->call("fmi3GetFloat64", c, &of_time, std::size_t{1}, &value, std::size_t{1}), 0);
  EXPECT_EQ(value, 5.0);
  EXPECT_EQ(importer_->call("fmi3SetTime", c, 3.0), 3);
  EXPECT_EQ(importer_->call("fmi3Reset", c), 0);
  EXPECT_EQ(step(c, 0.0, 1.0), 3) << "not yet initialised";
  importer_->call<void>("fmi3FreeInstance", c);
}

TEST_F(Fmu3, KeepsToTheTimesOfItsExperiment) {
  logged3 = 0;
  const Instance c = instantiate(token_);
  EXPECT_EQ(step(c, 0.0, 1.0), 3);
  EXPECT_EQ(importer_->call("fmi3EnterInitializationMode", c, false, 0.0, 0.0, true, -5.0), 3);
  EXPECT_EQ(importer_->call("fmi3EnterInitializationMode", c, false, 0.0, 0.0, true, 100.0), 0);
  const unsigned sensor = control().model().channels;
  double value = 0.0;
  EXPECT_EQ(importer_->call("fmi3GetFloat64", c, &sensor, std::size_t{1}, &value, std::size_t{1}), 0);
  EXPECT_EQ(value, -1e30);
  const VectorXd before = offsets(c);
  EXPECT_GT(before.tail(3).minCoeff(), 0.0) << "deviations of the start values";
  EXPECT_EQ(importer_->call("fmi3ExitInitializationMode", c), 0);
  EXPECT_TRUE(offsets(c) == before);
  EXPECT_EQ(step(c, 0.0, 60.0), 0);
  EXPECT_EQ(step(c, 60.0, 60.0), 3) << "past the stop";
  EXPECT_EQ(step(c, 70.0, 10.0), 3) << "a step was left out";
  EXPECT_EQ(step(c, 60.0, 40.0), 0);
  EXPECT_EQ(logged3, 4);
  importer_->call<void>("fmi3FreeInstance", c);
}

TEST_F(Fmu3, SourcesHonourThePrefix) {
  const std::string sources = (folder_.path() / "fmu/sources").string();
  ASSERT_EQ(std::system(fmt::format("cd {} && gcc -std=c99 -O0 -Wall -Wextra -Werror -pedantic "
                                    "-DFMI3_FUNCTION_PREFIX=mill_ -c *.c",
                                    sources)
                            .c_str()),
            0);
  const auto names = [&](const char* filter) {
    return std::system(
        fmt::format("cd {} && nm -g --defined-only *.o | awk 'NF == 3 {{ print $3 }}' | {}", sources, filter).c_str());
  };
  EXPECT_NE(names("grep -Ev '^mill_fmi3|^thermotwin_'"), 0);
  EXPECT_EQ(names("grep -c '^mill_fmi3' | grep -q '^75$'"), 0);
}

/// All functions of the standard are there; sources build the library as the build description says.
TEST_F(Fmu3, IsDescribedAndItsSourcesBuildIt) {
  const std::string& xml = files_["modelDescription.xml"];
  const auto count = [&](const std::string& pattern) {
    const std::regex regex(pattern);
    return std::distance(std::sregex_iterator(xml.begin(), xml.end(), regex), std::sregex_iterator());
  };
  const int sensors = control().model().sensors, inputs = control().model().channels + sensors;
  EXPECT_EQ(count("<Float64 "), inputs + 6 + 1);
  EXPECT_EQ(count("<Int32 "), 2 + sensors);
  EXPECT_EQ(count("causality=\"independent\""), 1);
  EXPECT_EQ(count("<Output valueReference="), 8 + sensors);
  EXPECT_EQ(count("<InitialUnknown valueReference="), 8 + sensors);
  for (int reference = 0; reference < inputs + 9 + sensors; ++reference)
    ASSERT_EQ(count("name=\"[^\"]*\" valueReference=\"" + std::to_string(reference) + "\""), 1) << reference;
  const std::string folder = (folder_.path() / "fmu").string(), built = (folder_.path() / "built.so").string();
  std::string names;
  const std::string& build = files_["sources/buildDescription.xml"];
  const std::regex source("SourceFile name=\"([^\"]*)\"");
  for (auto at = std::sregex_iterator(build.begin(), build.end(), source); at != std::sregex_iterator(); ++at)
    names += " " + (*at)[1].str();
  ASSERT_EQ(std::system(("cd " + folder +
                         "/sources && gcc -std=c99 -O0 -Wall -Wextra -Werror -pedantic "
                         "-ffp-contract=off -fPIC -shared" +
                         names + " -o " + built + " -lm")
                            .c_str()),
            0);
  for (const std::string& library : {folder + "/binaries/x86_64-linux/thermotwin.so", built}) {
    EXPECT_NE(std::system(("readelf -d " + library + " | grep NEEDED | grep -v 'lib[cm]\\.so' > /dev/null").c_str()),
              0);
    EXPECT_EQ(std::system(("test $(nm -D --defined-only " + library + " | grep -c ' fmi3') = 75").c_str()), 0)
        << library;
  }
}

}  // namespace
}  // namespace thermotwin::compensation
