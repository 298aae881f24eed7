// SPDX-License-Identifier: GPL-3.0-or-later
// An importer of its own: it unpacks the archive, loads the library and follows the standard's order of calls.
#include "compensation/control/control_fmu.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <optional>
#include <regex>
#include <stdexcept>

#include "compensation/control/control_bytes.h"
#include "compensation/control/model_bytes.h"
#include "core/file.h"
#include "tests/compensation/control/importer.h"
#include "tests/compensation/scratch.h"

namespace thermotwin::compensation {
namespace {

using Eigen::VectorXd;
namespace fs = std::filesystem;

using test::control;
using test::Importer;
using test::lumps;
using test::row_at;
using test::unpacked;

using Component = void*;
int logged = 0;
void log_line(void* /*environment*/, const char* /*instance*/, int /*status*/, const char* /*category*/,
              const char* /*message*/, ...) {
  ++logged;
}

struct Callbacks {
  void (*logger)(void*, const char*, int, const char*, const char*, ...) = log_line;
  void* (*allocate)(std::size_t, std::size_t) = std::calloc;
  void (*release)(void*) = std::free;
  void (*finished)(void*, int) = nullptr;
  void* environment = nullptr;
};

class Fmu : public ::testing::Test {
protected:
  void SetUp() override {
    write_fmu(folder_.path() / "twin.fmu", control().data(), 2);
    files_ = unpacked(core::read_file(folder_.path() / "twin.fmu"));
    for (const auto& [name, content] : files_) core::write_file(folder_.path() / "fmu" / name, content);
    importer_.emplace(folder_.path() / "fmu/binaries/linux64/thermotwin.so");
    std::smatch found;
    ASSERT_TRUE(std::regex_search(files_["modelDescription.xml"], found, std::regex("guid=\"([^\"]*)\"")));
    guid_ = found[1];
  }
  std::string resources() const { return "file://" + (folder_.path() / "fmu/resources").string(); }
  Component instantiate(const Importer& importer, const std::string& guid, int type = 1) const {
    return importer.call<Component>("fmi2Instantiate", "one", type, guid.c_str(), resources().c_str(),
                                    static_cast<const Callbacks*>(&callbacks_), 0, 0);
  }
  /// To the end of initialisation at time 0 with this row.
  Component begun(const Importer& importer, const VectorXd& row) const {
    const Component c = instantiate(importer, guid_);
    EXPECT_NE(c, nullptr);
    EXPECT_EQ(importer.call("fmi2SetupExperiment", c, 0, 0.0, 0.0, 0, 0.0), 0);
    set(importer, c, row);
    EXPECT_EQ(importer.call("fmi2EnterInitializationMode", c), 0);
    EXPECT_EQ(importer.call("fmi2ExitInitializationMode", c), 0);
    return c;
  }
  static void set(const Importer& importer, Component c, const VectorXd& row) {
    std::vector<unsigned> references(row.size());
    VectorXd values = row;
    for (unsigned k = 0; k < references.size(); ++k) {
      references[k] = k;
      if (std::isnan(values[k])) values[k] = -1e30;
    }
    const unsigned* r = references.data();
    const double* v = values.data();
    EXPECT_EQ(importer.call("fmi2SetReal", c, r, references.size(), v), 0);
  }
  /// Of the three axes, then their deviations.
  static VectorXd offsets(const Importer& importer, Component c) {
    const unsigned first = control().model().channels + control().model().sensors;
    const unsigned references[] = {first, first + 1, first + 2, first + 3, first + 4, first + 5};
    const unsigned* r = references;
    VectorXd values(6);
    EXPECT_EQ(importer.call("fmi2GetReal", c, r, std::size_t{6}, values.data()), 0);
    return values;
  }
  static VectorXd offsets(const test::Twin& twin) {
    VectorXd values(6);
    values << twin.offset_um(), twin.std_um();
    return values;
  }

  test::Scratch folder_;
  std::map<std::string, std::string> files_;
  std::optional<Importer> importer_;
  std::string guid_;
  Callbacks callbacks_;
};

TEST_F(Fmu, HasTheBitsOfTheCoreOverManySteps) {
  const solver::OperatingModel operating(lumps().machine, lumps().system.layout);
  const Importer& fmu = *importer_;
  EXPECT_STREQ(fmu.call<const char*>("fmi2GetVersion"), "2.0");
  EXPECT_STREQ(fmu.call<const char*>("fmi2GetTypesPlatform"), "default");
  test::Twin twin(control().model());
  VectorXd row = row_at(operating.channels(), 0.0);
  const Component c = begun(fmu, row);
  const Eigen::Index channels = operating.channels().size();
  twin.row(0.0, row.head(channels), row.tail(row.size() - channels));
  double time = 0.0;
  for (int i = 0; i < 100000; ++i) {
    const double step = i % 1000 < 900 ? 0.25 : 7.0;
    if (i % 20 == 0) {
      row = row_at(operating.channels(), time);
      set(fmu, c, row);
    }
    ASSERT_EQ(fmu.call("fmi2DoStep", c, time, step, 1), 0);
    time += step;
    twin.row(time, row.head(channels), row.tail(row.size() - channels));
    ASSERT_TRUE(offsets(fmu, c) == offsets(twin)) << i;
  }
  EXPECT_GT(twin.offset_um().norm(), 1.0);
  int status = -1;
  const unsigned reference = 0;
  EXPECT_EQ(fmu.call("fmi2GetInteger", c, &reference, std::size_t{1}, &status), 0);
  EXPECT_EQ(status, twin.get().now->status);
  EXPECT_EQ(fmu.call("fmi2Terminate", c), 0);
  fmu.call<void>("fmi2FreeInstance", c);
}

TEST_F(Fmu, StatesAreCopiedSerialisedAndContinuedWithTheSameBits) {
  const solver::OperatingModel operating(lumps().machine, lumps().system.layout);
  const Importer& fmu = *importer_;
  const Component one = begun(fmu, row_at(operating.channels(), 0.0));
  const Component two = begun(fmu, operating.channels().defaults());
  const auto walk = [&](Component c, double from, int steps) {
    std::vector<VectorXd> all;
    for (int i = 0; i < steps; ++i) {
      if (i % 50 == 0) set(fmu, c, row_at(operating.channels(), from));
      EXPECT_EQ(fmu.call("fmi2DoStep", c, from, 0.5, 1), 0);
      from += 0.5;
      all.push_back(offsets(fmu, c));
    }
    return all;
  };
  walk(one, 0.0, 20000 + 127);  // amid a job
  const double time = 0.5 * (20000 + 127);
  void* state = nullptr;
  ASSERT_EQ(fmu.call("fmi2GetFMUstate", one, &state), 0);
  std::size_t size = 0;
  ASSERT_EQ(fmu.call("fmi2SerializedFMUstateSize", one, state, &size), 0);
  std::vector<char> bytes(size);
  ASSERT_EQ(fmu.call("fmi2SerializeFMUstate", one, state, bytes.data(), size), 0);
  const std::vector<VectorXd> on = walk(one, time, 3000);
  ASSERT_EQ(fmu.call("fmi2SetFMUstate", one, state), 0);
  EXPECT_TRUE(walk(one, time, 3000) == on);
  void* other = nullptr;
  const char* from = bytes.data();
  ASSERT_EQ(fmu.call("fmi2DeSerializeFMUstate", two, from, size, &other), 0);
  ASSERT_EQ(fmu.call("fmi2SetFMUstate", two, other), 0);
  EXPECT_TRUE(walk(two, time, 3000) == on);
  void* damaged = nullptr;
  for (std::size_t at = 0; at < size; at += at < 400 ? 1 : size / 20) {
    bytes[at] ^= 1;
    EXPECT_EQ(fmu.call("fmi2DeSerializeFMUstate", two, from, size, &damaged), 3) << at;
    EXPECT_EQ(damaged, nullptr);
    bytes[at] ^= 1;
  }
  for (void** each : {&state, &other}) {
    EXPECT_EQ(fmu.call("fmi2FreeFMUstate", one, each), 0);
    EXPECT_EQ(*each, nullptr);
  }
  EXPECT_EQ(fmu.call("fmi2Reset", one), 0);
  EXPECT_EQ(fmu.call("fmi2DoStep", one, 0.0, 1.0, 1), 3) << "not yet initialised";
  for (const Component c : {one, two}) fmu.call<void>("fmi2FreeInstance", c);
}

TEST_F(Fmu, RefusesWhatItCannotDo) {
  const Importer& fmu = *importer_;
  logged = 0;
  EXPECT_EQ(instantiate(fmu, "{0123456789abcdef}"), nullptr);
  EXPECT_EQ(instantiate(fmu, guid_, 0), nullptr) << "model exchange";
  EXPECT_EQ(logged, 2);
  const Component c = begun(fmu, VectorXd::Constant(1, 1.0));
  EXPECT_EQ(fmu.call("fmi2DoStep", c, 0.0, 5.0, 1), 0);
  EXPECT_EQ(fmu.call("fmi2DoStep", c, 4.0, 0.5, 1), 3) << "back in time";
  const unsigned reference = 5000;
  double value = 0.0;
  const double* given = &value;
  EXPECT_EQ(fmu.call("fmi2GetReal", c, &reference, std::size_t{1}, &value), 3);
  EXPECT_EQ(fmu.call("fmi2SetReal", c, &reference, std::size_t{1}, given), 3);
  fmu.call<void>("fmi2FreeInstance", c);
  std::string model = files_["resources/model.bin"];
  model[model.size() / 2] ^= 1;
  core::write_file(folder_.path() / "fmu/resources/model.bin", model);
  EXPECT_EQ(instantiate(fmu, guid_), nullptr) << "damaged";
  core::write_file(folder_.path() / "fmu/resources/model.bin", model.substr(0, 1000));
  EXPECT_EQ(instantiate(fmu, guid_), nullptr) << "cut";
  fs::remove(folder_.path() / "fmu/resources/model.bin");
  EXPECT_EQ(instantiate(fmu, guid_), nullptr) << "missing";
}

TEST_F(Fmu, KeepsToTheTimesOfItsExperiment) {
  const Importer& fmu = *importer_;
  logged = 0;
  const Component c = instantiate(fmu, guid_);
  EXPECT_EQ(fmu.call("fmi2DoStep", c, 0.0, 1.0, 1), 3) << "not yet initialised";
  EXPECT_EQ(fmu.call("fmi2ExitInitializationMode", c), 3);
  EXPECT_EQ(fmu.call("fmi2SetupExperiment", c, 0, 0.0, 10.0, 1, 5.0), 3) << "stop before start";
  EXPECT_EQ(logged, 3);
  EXPECT_EQ(fmu.call("fmi2SetupExperiment", c, 0, 0.0, 10.0, 1, 100.0), 0);
  EXPECT_EQ(fmu.call("fmi2EnterInitializationMode", c), 0);
  EXPECT_EQ(fmu.call("fmi2ExitInitializationMode", c), 0);
  EXPECT_EQ(fmu.call("fmi2DoStep", c, 10.0, 60.0, 1), 0);
  EXPECT_EQ(fmu.call("fmi2DoStep", c, 70.0, 60.0, 1), 3) << "past the stop";
  EXPECT_EQ(fmu.call("fmi2DoStep", c, 80.0, 10.0, 1), 3) << "a step was left out";
  EXPECT_EQ(fmu.call("fmi2DoStep", c, 70.0, 30.0, 1), 0) << "to the stop";
  EXPECT_EQ(logged, 5);
  fmu.call<void>("fmi2FreeInstance", c);
  const void* nobody = fmu.call<Component>("fmi2Instantiate", "one", 1, static_cast<const char*>(nullptr),
                                           resources().c_str(), static_cast<const Callbacks*>(&callbacks_), 0, 0);
  EXPECT_EQ(nobody, nullptr) << "no guid";
  EXPECT_EQ(logged, 6);
}

TEST_F(Fmu, StartValuesAndOutputsWhileItIsInitialisedAreThoseOfTheDescription) {
  const solver::OperatingModel operating(lumps().machine, lumps().system.layout);
  const Importer& fmu = *importer_;
  const Component c = instantiate(fmu, guid_);
  const unsigned sensor = control().model().channels;
  double value = 0.0;
  EXPECT_EQ(fmu.call("fmi2GetReal", c, &sensor, std::size_t{1}, &value), 0);
  EXPECT_EQ(value, -1e30);
  EXPECT_EQ(fmu.call("fmi2EnterInitializationMode", c), 0);
  const VectorXd row = row_at(operating.channels(), 0.0);
  for (const VectorXd& each : {VectorXd(operating.channels().defaults()), row}) {
    set(fmu, c, each);
    test::Twin twin(control().model());
    VectorXd readings = VectorXd::Constant(control().model().sensors, NAN);
    if (each.size() > operating.channels().size()) readings = each.tail(readings.size());
    twin.row(0.0, each.head(operating.channels().size()), readings);
    EXPECT_TRUE(offsets(fmu, c) == offsets(twin));
  }
  const VectorXd before = offsets(fmu, c);
  EXPECT_EQ(fmu.call("fmi2ExitInitializationMode", c), 0);
  EXPECT_TRUE(offsets(fmu, c) == before);
  EXPECT_GT(before.tail(3).minCoeff(), 0.0);
  fmu.call<void>("fmi2FreeInstance", c);
}

// Nothing is connected to an input that is never set: its heat is unknown, not zero for sure.
TEST_F(Fmu, AnInputThatNobodySetsIsUncertain) {
  const solver::OperatingModel operating(lumps().machine, lumps().system.layout);
  const Importer& fmu = *importer_;
  const VectorXd row = row_at(operating.channels(), 0.0);
  const Component known = begun(fmu, row), open = instantiate(fmu, guid_), late = instantiate(fmu, guid_);
  constexpr unsigned spindle = 1;
  for (const Component c : {open, late}) {
    for (unsigned k = 0; k < row.size(); ++k) {
      const double value = std::isnan(row[k]) ? -1e30 : row[k];
      if (k != spindle) {
        EXPECT_EQ(fmu.call("fmi2SetReal", c, &k, std::size_t{1}, &value), 0);
      }
    }
    EXPECT_EQ(fmu.call("fmi2EnterInitializationMode", c), 0);
    EXPECT_EQ(fmu.call("fmi2ExitInitializationMode", c), 0);
  }
  // Importers that set the inputs just before the first step.
  const double speed = row[spindle];
  EXPECT_EQ(fmu.call("fmi2SetReal", late, &spindle, std::size_t{1}, &speed), 0);
  for (int i = 0; i < 120; ++i)
    for (const Component c : {known, open, late}) ASSERT_EQ(fmu.call("fmi2DoStep", c, 60.0 * i, 60.0, 1), 0);
  const double least = offsets(fmu, known).tail(3).maxCoeff();
  EXPECT_GT(offsets(fmu, open).tail(3).maxCoeff(), 1.5 * least);
  EXPECT_LT(offsets(fmu, late).tail(3).maxCoeff(), 1.05 * least);
  for (const Component c : {known, open, late}) fmu.call<void>("fmi2FreeInstance", c);
}

TEST_F(Fmu, ValuesThatAreRefusedChangeNothing) {
  const solver::OperatingModel operating(lumps().machine, lumps().system.layout);
  const Importer& fmu = *importer_;
  const VectorXd row = row_at(operating.channels(), 0.0);
  const Component c = begun(fmu, row);
  const unsigned references[] = {1, 5000};
  const double values[] = {row[1] + 100.0, 0.0};
  const unsigned* r = references;
  const double* v = values;
  double now = 0.0;
  EXPECT_EQ(fmu.call("fmi2SetReal", c, r, std::size_t{2}, v), 3);
  EXPECT_EQ(fmu.call("fmi2GetReal", c, r, std::size_t{1}, &now), 0);
  EXPECT_EQ(now, row[1]);
  EXPECT_EQ(fmu.call("fmi2Terminate", c), 0);
  EXPECT_EQ(fmu.call("fmi2SetReal", c, r, std::size_t{1}, v), 3) << "after the end";
  EXPECT_EQ(fmu.call("fmi2GetReal", c, r, std::size_t{1}, &now), 0);
  fmu.call<void>("fmi2FreeInstance", c);
}

// Two FMUs in one program: functions have the prefix, all other names that of the FMU.
TEST_F(Fmu, SourcesHonourThePrefixAndShareNoOtherName) {
  const std::string sources = (folder_.path() / "fmu/sources").string();
  for (const auto& [flags, shared] :
       {std::pair("", "^fmi2|^thermotwin_"), {"-DFMI2_FUNCTION_PREFIX=mill_", "^mill_fmi2|^thermotwin_"}}) {
    const std::string compile =
        fmt::format("cd {} && rm -f *.o && gcc -std=c99 -O0 -Wall -Wextra -Werror -pedantic -c {} *.c", sources, flags);
    ASSERT_EQ(std::system(compile.c_str()), 0);
    const std::string others = fmt::format(
        "cd {} && nm -g --defined-only *.o | awk 'NF == 3 {{ print $3 }}' | grep -Ev '{}'", sources, shared);
    EXPECT_NE(std::system(others.c_str()), 0) << flags;
    EXPECT_EQ(std::system(fmt::format("cd {} && nm -g --defined-only *.o | grep -q '{}fmi2DoStep$'", sources,
                                      *flags != 0 ? " mill_" : " ")
                              .c_str()),
              0);
  }
}

TEST_F(Fmu, DescriptionNamesEveryVariableWithUnitAndStart) {
  const std::string& xml = files_["modelDescription.xml"];
  const ControlData& data = control().data();
  const auto count = [&](const std::string& pattern) {
    const std::regex regex(pattern);
    return std::distance(std::sregex_iterator(xml.begin(), xml.end(), regex), std::sregex_iterator());
  };
  const int inputs = data.channels + data.sensors, outputs = 2 * data.linear_axes + 2 + data.sensors;
  EXPECT_EQ(count("<ScalarVariable "), inputs + outputs);
  EXPECT_EQ(count("causality=\"input\""), inputs);
  EXPECT_EQ(count("<Real unit=\"[^\"]+\" start=\"[-+0-9.e]+\"/>"), inputs);
  EXPECT_EQ(count("<Unknown index="), 2 * outputs);
  EXPECT_EQ(count("valueReference=\"" + std::to_string(inputs + 2 * data.linear_axes - 1) + "\""), 1);
  EXPECT_EQ(count("<BaseUnit"), 11);
  const char* spindle =
      "name=\"spindle.speed_rpm\" valueReference=\"1\" causality=\"input\" variability=\"continuous\"><Real "
      "unit=\"rpm\"";
  EXPECT_NE(xml.find(spindle), std::string::npos);
  EXPECT_NE(xml.find("<Real unit=\"degC\" start=\"20\"/>"), std::string::npos);
  for (const auto& [name, content] : files_) {
    if (name.ends_with(".c")) {
      EXPECT_NE(xml.find("<File name=\"" + name.substr(8) + "\"/>"), std::string::npos) << name;
    }
  }
  EXPECT_NE(xml.find("<Category name=\"logStatusError\""), std::string::npos);
  if (std::system("command -v unzip > /dev/null 2>&1") == 0) {
    EXPECT_EQ(std::system(("unzip -tq " + (folder_.path() / "twin.fmu").string() + " > /dev/null").c_str()), 0);
  }
}

TEST_F(Fmu, LibraryNeedsLibcAndLibmAloneAndItsSourcesBuildIt) {
  const solver::OperatingModel operating(lumps().machine, lumps().system.layout);
  const std::string folder = (folder_.path() / "fmu").string(), built = (folder_.path() / "built.so").string();
  const std::string compile = "cd " + folder +
                              "/sources && gcc -std=c99 -O0 -Wall -Wextra -Werror -pedantic -ffp-contract=off -fPIC "
                              "-shared *.c -o " +
                              built + " -lm";
  ASSERT_EQ(std::system(compile.c_str()), 0);
  for (const std::string& library : {folder + "/binaries/linux64/thermotwin.so", built}) {
    const std::string others = "readelf -d " + library + " | grep NEEDED | grep -v 'lib[cm]\\.so' > /dev/null";
    EXPECT_NE(std::system(others.c_str()), 0) << library;
    EXPECT_NE(std::system(("readelf -d " + library + " | grep -qE 'RPATH|RUNPATH'").c_str()), 0) << library;
  }
  const std::string hidden = "nm -D --defined-only " + folder + "/binaries/linux64/thermotwin.so | grep -v ' fmi2'";
  EXPECT_NE(std::system(hidden.c_str()), 0) << "only the standard's functions are visible";
  const Importer other(built);
  const VectorXd row = row_at(operating.channels(), 100.0);
  const Component one = begun(*importer_, row), two = begun(other, row);
  for (int i = 0; i < 2000; ++i) {
    importer_->call("fmi2DoStep", one, 1.0 * i, 1.0, 1);
    other.call("fmi2DoStep", two, 1.0 * i, 1.0, 1);
    ASSERT_EQ((offsets(*importer_, one) - offsets(other, two)).norm(), 0.0);
  }
  importer_->call<void>("fmi2FreeInstance", one);
  other.call<void>("fmi2FreeInstance", two);
}

TEST(ModelBytes, HoldTheWholeModel) {
  const std::string bytes = control_bytes(control().data());
  const long count = tt_model_texts(bytes.data(), bytes.size());
  ASSERT_GT(count, 0);
  std::vector<const char*> texts(count);
  tt_model read{};
  ASSERT_EQ(tt_model_read(bytes.data(), bytes.size(), texts.data(), &read), 0);
  const tt_model& model = control().model();
  EXPECT_STREQ(read.name, model.name);
  EXPECT_EQ(read.hash, model.hash);
  EXPECT_EQ(read.order, model.order);
  EXPECT_EQ(read.largest_um, model.largest_um);
  EXPECT_STREQ(read.channel_names[1], "spindle.speed_rpm");
  EXPECT_STREQ(read.sensor_names[model.sensors - 1], model.sensor_names[model.sensors - 1]);
  EXPECT_EQ(std::memcmp(read.term_left, model.term_left, 8 * control().data().term_left.size()), 0);
  EXPECT_EQ(std::memcmp(read.chain_axis, model.chain_axis, 4 * control().data().chain_axis.size()), 0);
  for (const std::size_t size : {std::size_t{0}, std::size_t{40}, bytes.size() / 2, bytes.size() - 8})
    EXPECT_EQ(tt_model_texts(bytes.data(), size), -1) << size;
}

TEST(ModelBytes, ThoseOfEarlierVersionsAreReadAndThoseOfLaterOnesAreNot) {
  std::string bytes = control_bytes(control().data());
  const auto as_version = [&](std::uint64_t version) {
    std::memcpy(bytes.data() + offsetof(tt_model_head, version), &version, sizeof version);
    return tt_model_texts(bytes.data(), bytes.size());
  };
  for (const int version : {1, 2, 3}) EXPECT_GT(as_version(version), 0) << version;
  EXPECT_EQ(as_version(0), -1);
  EXPECT_EQ(as_version(4), -1);
}

}  // namespace
}  // namespace thermotwin::compensation
