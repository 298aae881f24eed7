// SPDX-License-Identifier: GPL-3.0-or-later
// What changes in the course of a record, from files to diagnosis.json.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "reduction/model/model_file.h"
#include "tests/cases/toy.h"
#include "tests/machines/rods_record.h"

namespace thermotwin::cases {
namespace {

TEST(ChangingRecord, AStepInFrictionIsNamedWithItsTime) {
  const core::TemporaryFolder folder;
  const std::string model = (folder.path() / "rods.rom.h5").string(), data = (folder.path() / "record").string();
  reduction::write_model(model, lumped::model(lumped::machine(), 9));
  compensation::write_measurement(
      data, lumped::measure({}, {.seed = 91, .spread = 0.7, .changing = "motor", .factor = [](double hour) {
                                   return hour < 14.2 ? 1.0 : 1.9;
                                 }}));
  const Result result = thermotwin({"diagnose", "--model", model, "--data", data, "--temperature-error", "3", "--out",
                                    (folder.path() / "out").string(), "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const nlohmann::json d = nlohmann::json::parse(result.out);
  ASSERT_EQ(d["verdict"], "explained") << d["sentence"];
  EXPECT_EQ(d["causes"][0]["kind"], "source_step") << d["sentence"];
  EXPECT_EQ(d["causes"][0]["where"], "motor");
  EXPECT_NEAR(d["causes"][0]["parameters"]["factor"]["value"].get<double>(), 1.9, 0.4);
  EXPECT_NEAR(d["causes"][0]["since_h"]["value"].get<double>(), 14.2, 1.0);
  EXPECT_SAYS(d["sentence"].get<std::string>(), "since ");
  const std::string extended = read(folder.path() / "out/diagnosis/extended/machine.toml");
  EXPECT_SAYS(extended, "# diagnosis: source_step factor 1.");
}

}  // namespace
}  // namespace thermotwin::cases
