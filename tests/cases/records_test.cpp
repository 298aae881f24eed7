// SPDX-License-Identifier: GPL-3.0-or-later
// `evaluate` and `diagnose` on records without a machine: what they must not claim.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <random>
#include <regex>
#include <set>
#include <tuple>

#include "core/table.h"
#include "core/text.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

using nlohmann::json;

constexpr double interval_s = 300.0;

struct Row {
  std::vector<double> temperatures;  ///< degC
  double z = 0;                      ///< um
};

/// A record of one displacement z and temperatures T1, T2, ... each five minutes; a row without temperatures is left
/// out.
void write_record(const Toy& toy, const std::string& name, double hours,
                  const std::function<Row(double hour)>& row_at) {
  std::string data, channels = "[[channel]]\nid = \"z\"\nkind = \"displacement\"\nunit = \"um\"\nuncertainty = 0.1\n";
  for (int i = 0; i * interval_s < 3600.0 * hours; ++i) {
    const Row row = row_at(i * interval_s / 3600.0);
    if (i == 0) {
      data = "time_s,z";
      for (std::size_t k = 1; k <= row.temperatures.size(); ++k) {
        const std::string id = "T" + std::to_string(k);
        data += "," + id;
        channels += "[[channel]]\nid = \"" + id +
                    "\"\nkind = \"temperature\"\nunit = \"degC\"\nuncertainty = 0.02\nsensor = \"" + id + "\"\n";
      }
      data += "\n";
    }
    if (row.temperatures.empty()) continue;
    data += std::to_string(i * interval_s) + "," + std::to_string(row.z);
    for (const double temperature : row.temperatures) data += "," + std::to_string(temperature);
    data += "\n";
  }
  toy.write(name + "/data.csv", data);
  toy.write(name + "/channels.toml", channels);
}

std::string all(const json& texts) {
  std::string joined;
  for (const auto& text : texts) joined += text.get<std::string>() + "\n";
  return joined;
}

TEST(EvaluateRecord, RefusesAModelThatDiverges) {
  const Toy toy;
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  // Two sensors that agree to 0.1 mK while models are fitted, and part by a kelvin later: a regression on both has
  // gains without measure.
  write_record(toy, "twins", 40, [&](double hour) {
    const double warm = 20 + 2 * std::sin(hour / 3);
    return Row{{warm, warm + (hour < 20 ? 1e-4 * normal(random) : 1.0)}, 5 * (warm - 20) + normal(random)};
  });
  const Result result = toy.run({"evaluate", "--data", toy.file("twins"), "--train-until", "20", "--models",
                                 "static_regression,first_order,selected_regression", "--cross", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const json summary = json::parse(result.out);
  EXPECT_SAYS(all(summary["notes"]), "refused: static_regression z: diverges");
  for (const json& row : summary["rows"]) EXPECT_LT(row["rms"].get<double>(), 1000.0) << row;
  const std::string models = read(toy.result("evaluation/models.toml"));
  EXPECT_EQ(models.find("static_regression"), std::string::npos);
  EXPECT_NE(models.find("selected_regression"), std::string::npos);
}

// A channel of 50 um and one of noise: half of what both remove together would be nothing.
TEST(EvaluateRecord, RanksByTheErrorThatRemainsOnTheSameRows) {
  const Toy toy;
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  std::string data = "time_s,z,x,T1,T2\n";
  double slow = 0;
  constexpr int rows = 576;
  for (int i = 0; i < rows; ++i) {
    const double hour = i * interval_s / 3600.0, warm = 5 * std::sin(hour / 4) + 2 * std::sin(hour);
    slow += (warm - slow) * interval_s / 7200.0;
    // T2 is lost for a quarter of the held-out rows.
    const std::string second = i >= rows / 2 + 72 && i < rows / 2 + 144 ? "" : std::to_string(20 + 0.5 * warm);
    data += fmt::format("{},{},{},{},{}\n", i * interval_s, 10 * slow, 0.1 * normal(random) + 0.02 * warm, 20 + warm,
                        second);
  }
  toy.write("both/data.csv", data);
  std::string channels;
  for (const char* id : {"z", "x"})
    channels +=
        fmt::format("[[channel]]\nid = \"{}\"\nkind = \"displacement\"\nunit = \"um\"\nuncertainty = 0.1\n", id);
  for (const char* id : {"T1", "T2"})
    channels += fmt::format(
        "[[channel]]\nid = \"{0}\"\nkind = \"temperature\"\nunit = \"degC\"\nuncertainty = 0.02\nsensor = \"{0}\"\n",
        id);
  toy.write("both/channels.toml", channels);
  const Result result = toy.run(
      {"evaluate", "--data", toy.file("both"), "--models", "static_regression,grey_box,selected_regression", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const json summary = json::parse(result.out);
  ASSERT_EQ(summary["leaderboard"].size(), 3U) << summary["leaderboard"];
  double last = 100.0;
  for (const json& standing : summary["leaderboard"]) {
    const std::string model = standing["model"];
    SCOPED_TRACE(model);
    // The formula of docs/explanation/models.md, from the rows of the same object. What a model skips is left as it is.
    double before = 0, after = 0;
    for (const char* channel : {"z", "x"}) {
      double square = 0, left = 0, count = 0;
      const core::Table predictions = core::read_csv(summary["predictions"].get<std::string>());
      const auto measured = predictions.column(std::string(channel) + "_measured"),
                 predicted = predictions.column(std::string(channel) + "_" + model);
      for (Eigen::Index i = rows / 2; i < rows; ++i) {
        const double error = std::isfinite(predicted[i]) ? measured[i] - predicted[i] : measured[i];
        square += measured[i] * measured[i];
        left += error * error;
        count += 1;
      }
      before += square / count;
      after += left / count;
    }
    const double removed = standing["rms_reduction_percent"];
    EXPECT_NEAR(removed, 100 * (1 - std::sqrt(after / before)), 1e-3);
    EXPECT_LE(removed, last);
    last = removed;
    if (model == "static_regression") {
      EXPECT_NEAR(standing["predicted_percent"].get<double>(), 75.0, 0.01);
    }
  }
  // Every channel alike, what is removed of z would be worth half.
  const json& best = summary["leaderboard"][0];
  EXPECT_GT(best["rms_reduction_percent"].get<double>(), best["channel_mean_percent"].get<double>() + 10.0) << best;
}

TEST(EvaluateRecord, CrossFitsNoStartThatHasRunOff) {
  const Toy toy;
  // Fitted on the third day alone, the start of the record has long run off: its size is no parameter then.
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  double slow = 0;
  write_record(toy, "days", 72, [&](double hour) {
    const double hall = 2 * std::sin(2 * std::numbers::pi * hour / 24) + std::sin(hour),
                 frame = 1.3 * std::sin(2 * std::numbers::pi * (hour - 3) / 24) + 0.3 * std::sin(hour);
    slow += (hall - slow) * interval_s / 7200.0;
    return Row{{20 + hall, 20 + frame}, 4 * slow - 2 * frame + 0.1 * normal(random)};
  });
  const Result result = toy.run(
      {"evaluate", "--data", toy.file("days"), "--models", "heating_cooling,static_regression", "--cross", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const json summary = json::parse(result.out);
  int judged = 0;
  for (const json& model : summary["cross"]["models"]) {
    for (const json& from : model["rms_reduction_percent"]) {
      for (const json& value : from) {
        if (!value.is_null()) {
          EXPECT_GT(value.get<double>(), -1e4) << model;
          ++judged;
        }
      }
    }
  }
  EXPECT_EQ(judged, 18);
}

TEST(EvaluateRecord, RanksAFitAtABoundLastAndSaysWhy) {
  const Toy toy;
  // z follows T1 by a lag of 60 h, of which 24 h show a ramp.
  double slow = 0;
  write_record(toy, "slow", 36, [&](double hour) {
    const double warm = hour < 1 ? 0.0 : 8.0 + 0.5 * std::sin(hour);
    slow += (warm - slow) * interval_s / (60 * 3600.0);
    return Row{{20 + warm, 20 + 0.5 * std::sin(1.7 * hour)}, 10 * slow};
  });
  const Result result =
      toy.run({"evaluate", "--data", toy.file("slow"), "--models", "first_order,static_regression", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const json board = json::parse(result.out)["leaderboard"];
  ASSERT_EQ(board.size(), 2U);
  EXPECT_EQ(board[1]["model"], "first_order");
  EXPECT_GT(board[1]["rms_reduction_percent"].get<double>(), board[0]["rms_reduction_percent"].get<double>())
      << "last although it is nearer";
  EXPECT_SAYS(board[1]["caution"].get<std::string>(), "at the bound of the search");
  EXPECT_EQ(board[0]["caution"], "");
  EXPECT_SAYS(read(toy.result("evaluation/tables.txt")), "first_order ranked last: z: time constant of");
  // The reason stays with the model.
  const Result carried = toy.run(
      {"evaluate", "--data", toy.file("slow"), "--fitted", toy.result("evaluation/models.toml").string(), "--json"});
  ASSERT_EQ(carried.status, 0) << carried.err;
  bool said = false;
  const json elsewhere = json::parse(carried.out);
  for (const json& standing : elsewhere["leaderboard"]) {
    said = said || (standing["model"] == "first_order_as_is" &&
                    standing["caution"].get<std::string>().find("at the bound") != std::string::npos);
  }
  EXPECT_TRUE(said) << carried.out;
}

TEST(EvaluateRecord, DrawsAndChecksStepResponses) {
  const Toy toy;
  // z follows T1 by 5 um/K with a lag of 1 h.
  double slow = 0;
  write_record(toy, "lag", 40, [&](double hour) {
    const double warm = 2 * std::sin(hour / 3) + std::sin(1.9 * hour);
    slow += (warm - slow) * interval_s / 3600.0;
    return Row{{20 + warm}, 5 * slow};
  });
  const std::vector<std::string> arguments{"evaluate", "--data", toy.file("lag"), "--models",
                                           "output_error,static_regression"};
  const Result said = toy.run(arguments);
  ASSERT_EQ(said.status, 0) << said.err;
  EXPECT_SAYS(said.out, "stability   1 of 1 step responses settle, the slowest after");
  EXPECT_SAYS(said.out, "step_response_output_error.svg");
  EXPECT_SAYS(read(toy.result("evaluation/models.txt")), "output_error z, step of T1: stable, largest pole 0.");
  const std::string picture = read(toy.result("evaluation/step_response_output_error.svg"));
  EXPECT_SAYS(picture, ">z, step of T1<");
  EXPECT_SAYS(picture, "class=\"line blue\"");
  EXPECT_FALSE(std::filesystem::exists(toy.result("evaluation/step_response_static_regression.svg")));
  std::vector<std::string> as_json = arguments;
  as_json.emplace_back("--json");
  const json steps = json::parse(toy.run(as_json).out)["step_responses"];
  ASSERT_EQ(steps.size(), 1U);
  EXPECT_EQ(steps[0]["stable"], true);
  EXPECT_NEAR(steps[0]["end"].get<double>(), 5.0, 0.2);
  EXPECT_NEAR(steps[0]["settling_h"].get<double>(), 3.0, 0.3);
  EXPECT_NEAR(steps[0]["values"].back().get<double>(), 5.0, 0.3);
}

TEST(EvaluateRecord, ASelectionWithoutInputFallsBackAndSaysSo) {
  const Toy toy;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  // z follows the difference of two sensors that move by a hundred times as much: neither helps alone.
  write_record(toy, "difference", 48, [&](double hour) {
    const double hall = 20 + 5 * normal(random), apart = 0.05 * std::sin(hour / 2);
    return Row{{hall, hall + apart}, 100 * apart};
  });
  const Result result = toy.run(
      {"evaluate", "--data", toy.file("difference"), "--models", "selected_regression,static_regression", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const json board = json::parse(result.out)["leaderboard"];
  for (const json& standing : board) {
    if (standing["model"] != "selected_regression") continue;
    EXPECT_SAYS(standing["caution"].get<std::string>(), "ridge regression on all inputs is used instead");
    EXPECT_GT(standing["rms_reduction_percent"].get<double>(), 50.0);
  }
  EXPECT_SAYS(read(toy.result("evaluation/models.txt")), "no single input improves");
}

TEST(EvaluateRecord, NamesChannelsWithoutAValueAndRefusesOneRow) {
  const Toy toy;
  write_record(toy, "blank", 30, [](double hour) {
    const double warm = 2 * std::sin(hour);
    return Row{{20 + warm, std::nan("")}, 5 * warm};
  });
  const Result blank =
      toy.run({"evaluate", "--data", toy.file("blank"), "--models", "static_regression", "--json", "--quiet"});
  ASSERT_EQ(blank.status, 0) << blank.err;
  EXPECT_SAYS(all(json::parse(blank.out)["notes"]), "without any value in the record: T2");
  write_record(toy, "one", 0.05, [](double) { return Row{{20, 21}, 5}; });
  const Result one = toy.run({"evaluate", "--data", toy.file("one"), "--quiet"});
  EXPECT_EQ(one.status, 3);
  EXPECT_SAYS(one.err, "at least two rows");
  write_record(toy, "silent", 30, [](double hour) { return Row{{20 + hour, 21}, std::nan("")}; });
  const Result silent = toy.run({"evaluate", "--data", toy.file("silent"), "--quiet"});
  EXPECT_EQ(silent.status, 3);
  EXPECT_SAYS(silent.err, "data.csv: no value of z; allowed: values of at least one displacement");
}

TEST(EvaluateRecord, ShowsTheFitWhereAllRowsTrain) {
  const Toy toy;
  write_record(toy, "short", 20, [](double hour) {
    const double warm = 2 * std::sin(hour);
    return Row{{20 + warm, 20 + std::cos(hour)}, 5 * warm};
  });
  const Result result = toy.run({"evaluate", "--data", toy.file("short"), "--train-until", "1000", "--models",
                                 "static_regression,ridge_regression", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const json summary = json::parse(result.out);
  ASSERT_EQ(summary["leaderboard"].size(), 2U);
  for (const json& standing : summary["leaderboard"]) {
    EXPECT_TRUE(standing["seen_by_fit"].get<bool>());
    EXPECT_GT(standing["rms_reduction_percent"].get<double>(), 90.0);
  }
  EXPECT_SAYS(read(toy.result("evaluation/tables.txt")), "static_regression (fit)");
  EXPECT_SAYS(read(toy.result("evaluation/leaderboard.svg")), "static_regression (fit)");
}

/// Three temperatures that hardly move and move together in the first third, and each for itself, fast and slowly,
/// later.
Row uninformative(double hour, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const auto own = [&](double rate) { return hour < 16 ? 0.0 : 2.0 * std::sin(rate * hour * (1.0 + 0.01 * hour)); };
  const double together = hour < 16 ? 0.3 * std::sin(hour) : 3.0 * std::sin(hour / 4) + own(1.3);
  const double a = together + 0.02 * normal(random),
               b = together + (hour < 16 ? 0.0 : 3.0 * std::sin(hour / 3)) + own(1.9) + 0.02 * normal(random),
               c = together + (hour < 16 ? 0.0 : 3.0 * std::cos(hour / 5) - 3.0 * std::cos(16.0 / 5)) + own(2.7) +
                   0.02 * normal(random);
  return {{20 + a, 20 + b, 20 + c}, 3 * a + 2 * b - 2 * c + 0.1 * normal(random)};
}

/// A machine that follows its motor within an hour: two programs, each from the room's temperature on.
struct Motor {
  double z = 0;
  /// Temperature and displacement after five minutes more of a program. @param heat  K above the room that the motor
  /// goes to
  Row step(std::mt19937_64& random, double heat) {
    std::normal_distribution<double> normal;
    z += (8.0 * heat - z) * (1.0 - std::exp(-interval_s / 3600.0));
    return {{20.0 + heat + 0.01 * normal(random)}, z + 0.05 * normal(random)};
  }
};
double heat_of(int program, double hour) {
  return program == 0 ? (hour < 1.0                   ? 0.0
                         : std::fmod(hour, 4.0) < 2.0 ? 4.0
                                                      : 2.0)
                      : (hour < 1.0   ? 0.0
                         : hour < 5.0 ? 3.0
                                      : 1.0);
}

/// Least reduction of RMS that a row of this model and part says, %.
double least_reduction(const json& answer, const std::string& model, const std::string& part) {
  double least = std::numeric_limits<double>::infinity();
  for (const json& row : answer["rows"]) {
    if (row["model"] == model && row["part"] == part)
      least = std::min(least, row["rms_reduction_percent"].get<double>());
  }
  return least;
}

// What a machine did two days ago is neither held over the pause nor remembered by a model.
TEST(EvaluateRecord, AProgramAfterAPauseBeginsAnew) {
  const Toy toy;
  std::mt19937_64 random(5);
  Motor motor;
  write_record(toy, "record", 72, [&](double hour) {
    if (hour >= 12.0 && hour < 60.0) return motor = {}, Row{};
    return motor.step(random, hour < 12.0 ? heat_of(0, hour) : heat_of(1, hour - 60.0));
  });
  toy.write("record/channels.toml", read(toy.file("record/channels.toml")) +
                                        "[[program]]\nname = \"first\"\nfrom_s = 0\nto_s = 43200\n[[program]]\nname = "
                                        "\"second\"\nfrom_s = 216000\nto_s = 260000\n");
  for (const auto& [train, judged] : {std::pair{"first", "second"}, {"second", "first"}}) {
    const Result result = toy.run({"evaluate", "--data", toy.file("record"), "--train-programs", train, "--models",
                                   "arx,output_error,grey_box", "--json"});
    ASSERT_EQ(result.status, 0) << result.err;
    for (const char* model : {"arx", "output_error", "grey_box"}) {
      EXPECT_GT(least_reduction(json::parse(result.out), model, train), 95.0) << model;
      EXPECT_GT(least_reduction(json::parse(result.out), model, judged), 95.0) << model << " fitted on " << train;
    }
  }
}

// A spindle that runs from the first row on: the machine was cold, it had not run at that speed through the pause
// before.
TEST(EvaluateRecord, AProgramThatBeginsAtFullSpeedBeginsAtRest) {
  const Toy toy;
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  for (const auto& [name, first, second] :
       {std::tuple{"first", 6000, 3000}, {"second", 9000, 0}, {"judged", 4000, 8000}}) {
    double z = 0.0;
    std::string data = "time_s,n,z\n";
    for (int i = 0; i < 144; ++i) {
      const int speed = i < 48 ? first : i < 96 ? 0 : second;
      data += std::to_string(i * interval_s) + "," + std::to_string(speed) + "," +
              std::to_string(z + 0.05 * normal(random)) + "\n";
      z += (4e-3 * speed - z) * (1.0 - std::exp(-interval_s / 3600.0));
    }
    toy.write(std::string(name) + "/data.csv", data);
    toy.write(std::string(name) + "/channels.toml",
              "[[channel]]\nid = \"n\"\nkind = \"speed\"\nunit = \"rpm\"\nuncertainty = 1\n"
              "[[channel]]\nid = \"z\"\nkind = \"displacement\"\nunit = \"um\"\nuncertainty = 0.1\n");
  }
  const Result result =
      toy.run({"evaluate", "--data", toy.file("judged"), "--train-data", toy.file("first") + "," + toy.file("second"),
               "--models", "output_error_activity,phenomenological", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  for (const char* model : {"output_error_activity", "phenomenological"}) {
    const double least = least_reduction(json::parse(result.out), model, "day 0");
    EXPECT_GT(least, 95.0) << model;
    EXPECT_TRUE(std::isfinite(least)) << model << " was not judged";
  }
}

TEST(EvaluateRecord, TrainsOnSeveralFolders) {
  const Toy toy;
  std::mt19937_64 random(6);
  // Neither folder alone tells both sensors apart: in each one of them stays.
  for (const char* name : {"first", "second", "both"}) {
    Motor one, other;
    write_record(toy, name, 12, [&](double hour) {
      Row a = one.step(random, name == std::string("second") ? 0.0 : heat_of(0, hour)),
          b = other.step(random, name == std::string("first") ? 0.0 : heat_of(1, hour));
      return Row{{a.temperatures[0], b.temperatures[0]}, a.z - 2.0 * b.z};
    });
  }
  // Named as a program, the judged folder is judged as a whole, from its first row on.
  toy.write("both/channels.toml",
            read(toy.file("both/channels.toml")) + "[[program]]\nname = \"judged\"\nfrom_s = 0\nto_s = 43200\n");
  const Result result = toy.run({"evaluate", "--data", toy.file("both"), "--train-data",
                                 toy.file("first") + "," + toy.file("second"), "--models", "arx", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const json answer = json::parse(result.out);
  EXPECT_GT(least_reduction(answer, "arx", "judged"), 95.0) << result.out;
  for (const char* part : {"first", "second"}) EXPECT_GT(least_reduction(answer, "arx", part), 95.0);
  for (const json& row : answer["rows"]) EXPECT_EQ(row["seen_by_fit"].get<bool>(), row["part"] != "judged") << row;
  EXPECT_NEAR(answer["training_hours"].get<double>(), 24.0, 0.5);
  // A channel of another kind in one of them.
  std::string channels = read(toy.file("second/channels.toml"));
  const std::string temperature = "\"temperature\"\nunit = \"degC\"";
  const std::string speed = "\"speed\"\nunit = \"rpm\"";
  channels.replace(channels.find(temperature), temperature.size(), speed);
  toy.write("second/channels.toml", channels);
  const Result wrong = toy.run({"evaluate", "--data", toy.file("both"), "--train-data",
                                toy.file("first") + "," + toy.file("second"), "--models", "arx"});
  EXPECT_EQ(wrong.status, 3);
  EXPECT_SAYS(wrong.err, "T1");
  // The same unit, but one of them does not say which quantity it is.
  channels.replace(channels.find(speed), speed.size(), temperature);
  const std::string displacement = "unit = \"um\"";
  channels.replace(channels.find(displacement), displacement.size(), displacement + "\nquantity = \"dz\"");
  toy.write("second/channels.toml", channels);
  const Result unnamed = toy.run({"evaluate", "--data", toy.file("both"), "--train-data",
                                  toy.file("first") + "," + toy.file("second"), "--models", "arx"});
  EXPECT_EQ(unnamed.status, 3);
  for (const char* words : {"quantity \"dz\"", "no quantity"}) EXPECT_SAYS(unnamed.err, words);
  const Result twice = toy.run({"evaluate", "--data", toy.file("both"), "--train-data",
                                toy.file("first") + "," + toy.path() + "/./first", "--models", "arx"});
  EXPECT_EQ(twice.status, 3);
  EXPECT_SAYS(twice.err, "named twice");
  const Result leaked = toy.run({"evaluate", "--data", toy.file("both"), "--train-data", toy.file("both")});
  EXPECT_EQ(leaked.status, 3);
  EXPECT_SAYS(leaked.err, "without the folders of --data and --also");
}

TEST(EvaluateRecord, ATrainingFolderOfAnotherMachineIsRefusedByBothNames) {
  const Toy toy;
  std::mt19937_64 random(9);
  for (const char* name : {"trained", "judged"}) {
    Motor motor;
    write_record(toy, name, 12, [&](double hour) { return motor.step(random, heat_of(0, hour)); });
  }
  const std::string channels = read(toy.file("judged/channels.toml"));
  const auto with = [&](const std::string& judged, const std::string& trained) {
    for (const auto& [name, machine] : {std::pair{"judged", judged}, {"trained", trained}}) {
      toy.write(std::string(name) + "/channels.toml",
                (machine.empty() ? "" : "[record]\nmachine = \"" + machine + "\"\n") + channels);
    }
    return toy.run({"evaluate", "--data", toy.file("judged"), "--train-data", toy.file("trained"), "--models", "arx"});
  };
  EXPECT_EQ(with("lathe", "lathe").status, 0);
  EXPECT_EQ(with("", "mill").status, 0) << "the judged record does not state its machine";
  EXPECT_EQ(with("lathe", "").status, 0);
  const Result refused = with("lathe", "mill");
  EXPECT_EQ(refused.status, 3);
  for (const std::string& words :
       {toy.file("trained"), toy.file("judged"), std::string("'mill'"), std::string("'lathe'")})
    EXPECT_SAYS(refused.err, words);
}

TEST(EvaluateRecord, AModelThatPredictsNothingOfTheJudgedFolderIsNoted) {
  const Toy toy;
  std::mt19937_64 random(9);
  for (const char* name : {"trained", "judged"}) {
    Motor motor;
    write_record(toy, name, 12, [&](double hour) { return motor.step(random, heat_of(0, hour)); });
  }
  std::string channels = read(toy.file("judged/channels.toml")), data = read(toy.file("judged/data.csv"));
  for (std::string* text : {&channels, &data})
    for (std::size_t at = 0; (at = text->find("T1", at)) != std::string::npos; at += 2) text->replace(at, 2, "T9");
  toy.write("judged/channels.toml", channels);
  toy.write("judged/data.csv", data);
  const Result result =
      toy.run({"evaluate", "--data", toy.file("judged"), "--train-data", toy.file("trained"), "--models", "arx"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.out, "arx cannot predict " + toy.file("judged") + ", which lacks an input");
}

// Neither the length of a pause nor the number of folders makes a fit coarser.
TEST(EvaluateRecord, PausesAndManyFoldersDoNotBlurAFit) {
  const Toy toy;
  std::mt19937_64 random(8);
  std::string folders;
  for (int k = 0; k < 25; ++k) {
    Motor motor;
    const std::string name = k == 0 ? "judged" : "f" + std::to_string(k);
    write_record(toy, name, 12, [&](double hour) { return motor.step(random, heat_of(k % 2, hour)); });
    if (k > 0) folders += (k > 1 ? "," : "") + toy.file(name);
  }
  const Result result = toy.run(
      {"evaluate", "--data", toy.file("judged"), "--train-data", folders, "--models", "arx,output_error", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  for (const char* model : {"arx", "output_error"})
    EXPECT_GT(least_reduction(json::parse(result.out), model, "day 0"), 98.5) << model;
}

/// Readings of T1 from the 100th row on, each ten rows, are fault codes.
void write_coded_record(const Toy& toy, const std::string& name, int codes, double code) {
  std::mt19937_64 random(11);
  Motor motor;
  int row = 0;
  write_record(toy, name, 48, [&](double hour) {
    Row now = motor.step(random, 2.0 + std::sin(hour));
    now.temperatures.push_back(20.0 + std::cos(hour));
    if (row >= 100 && row < 100 + 10 * codes && row % 10 == 0) now.temperatures[0] = code;
    ++row;
    return now;
  });
}

TEST(EvaluateRecord, AFewFaultCodesAreMissingReadings) {
  const Toy toy;
  write_coded_record(toy, "record", 5, std::nan(""));
  const auto evaluated = [&] {
    return toy.run({"evaluate", "--data", toy.file("record"), "--models", "first_order", "--json"});
  };
  const Result blank = evaluated();
  ASSERT_EQ(blank.status, 0) << blank.err;
  EXPECT_EQ(blank.err.find("'T1'"), std::string::npos) << blank.err;
  write_coded_record(toy, "record", 5, -127.0);  // of 576
  const Result coded = evaluated();
  ASSERT_EQ(coded.status, 0) << coded.err;
  EXPECT_EQ(json::parse(coded.out)["rows"], json::parse(blank.out)["rows"]);
  const Result diagnosed = toy.run({"diagnose", "--data", toy.file("record")});
  EXPECT_EQ(diagnosed.status, 0) << diagnosed.err;
  for (const std::string& said : {coded.err, diagnosed.err}) {
    EXPECT_SAYS(
        said,
        "record/data.csv: column 3 'T1': 5 of 576 values outside -40 to 150 degC, the first -127 degC at 30000 s "
        "(line 102)");
  }
  write_coded_record(toy, "record", 6, -127.0);
  for (const char* verb : {"evaluate", "diagnose"}) {
    const Result refused = toy.run({verb, "--data", toy.file("record")});
    EXPECT_EQ(refused.status, 3) << verb;
    EXPECT_SAYS(refused.err, "record/data.csv:102 column 3 'T1': -127 degC; allowed: -40 to 150 degC");
  }
}

TEST(DiagnoseRecord, ThatCannotTellSaysSoAndWhatToMeasure) {
  const Toy toy;
  std::mt19937_64 random(2);
  write_record(toy, "untold", 48, [&](double hour) { return uninformative(hour, random); });
  const Result result = toy.run({"diagnose", "--data", toy.file("untold"), "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const json d = json::parse(result.out);
  EXPECT_EQ(d["verdict"], "ambiguous") << result.out;
  std::set<std::string> kinds;
  for (const json& cause : d["ambiguous_set"]) kinds.insert(cause["kind"]);
  EXPECT_EQ(kinds, (std::set<std::string>{"none", "unknown"}));
  EXPECT_TRUE(d["causes"].empty());
  EXPECT_EQ(d["next_measurement"]["channel"], "z");
  EXPECT_SAYS(d["next_measurement"]["load"].get<std::string>(), "independently of the other inputs");
  EXPECT_FALSE(d["next_measurement"]["why"].get<std::string>().empty());
  const std::string page = read(toy.result("diagnosis/report.html"));
  for (const char* words : {"<p>Ambiguous: this record does not show", "To decide, measure", "none: nothing changed"})
    EXPECT_SAYS(page, words);
  // The same machine, used in the first third as later, does tell.
  std::mt19937_64 again(3);
  write_record(toy, "told", 48, [&](double hour) { return uninformative(hour + 16, again); });
  const Result told = toy.run({"diagnose", "--data", toy.file("told"), "--json"});
  EXPECT_EQ(json::parse(told.out)["verdict"], "no_discrepancy") << told.out;
}

/// A drift from the 20th hour on that no sensor follows.
Row drifting(double hour, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const double hall = 1.5 * std::sin(2 * std::numbers::pi * hour / 24) + 0.7 * std::sin(hour) +
                      0.4 * std::sin(2.7 * hour + 1),
               frame = 0.6 * std::sin(1.9 * hour) + 0.3 * hall;
  return {{20 + hall + 0.02 * normal(random), 20 + frame + 0.02 * normal(random)},
          6 * hall - 4 * frame + (hour < 20 ? 0.0 : 0.4 * (hour - 20)) + 0.1 * normal(random)};
}

TEST(DiagnoseRecord, OffersADailySwingFromThreeDaysOn) {
  const Toy toy;
  for (const double days : {2.9, 3.0}) {
    std::mt19937_64 random(4);
    write_record(toy, "drift", 24 * days, [&](double hour) { return drifting(hour, random); });
    const Result result = toy.run({"diagnose", "--data", toy.file("drift"), "--json"});
    ASSERT_EQ(result.status, 0) << result.err;
    EXPECT_EQ(result.out.find("unmeasured_temperature") != std::string::npos, days >= 3.0) << result.out;
    EXPECT_SAYS(result.out, "probe_drift");
  }
}

/// The text of the cell so many columns after the one that reads so, in a row of the page.
std::string cell(const std::string& page, const std::string& first, int after) {
  const auto row = page.find("<tr><td>" + first + "</td>");
  if (row == std::string::npos) return "no row " + first;
  const std::string text = page.substr(row, page.find("</tr>", row) - row);
  const std::regex cells("<td[^>]*>(.*?)</td>");
  auto at = std::sregex_iterator(text.begin(), text.end(), cells);
  std::advance(at, after);
  return std::regex_replace((*at)[1].str(), std::regex("<[^>]*>|&#8239;"), "");
}

TEST(DiagnoseRecord, SpeaksOfTheRecordAlone) {
  const Toy toy;
  std::mt19937_64 random(4);
  constexpr double hours = 72;
  write_record(toy, "drift", hours, [&](double hour) { return drifting(hour, random); });
  const Result result = toy.run({"diagnose", "--data", toy.file("drift")});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.out, "Explained by probe_drift of z");
  const std::string page = read(toy.result("diagnosis/report.html"));
  // diagnosis.json says what the terminal and the page say.
  const json d = json::parse(read(toy.result("diagnosis/diagnosis.json")));
  EXPECT_SAYS(result.out, d["sentence"].get<std::string>());
  ASSERT_FALSE(d["notes"].empty());
  for (const json& note : d["notes"]) EXPECT_SAYS(page, core::xml_text(note.get<std::string>()));
  const std::string body = std::regex_replace(page.substr(page.find("</style>")), std::regex("<svg[^]*?</svg>"), "");
  for (const std::string& text : {result.out, body}) {
    for (const char* words : {"TCP", "mesh", "machine.toml", "± 0 ", "stated uncertainty", "nominal"})
      EXPECT_EQ(text.find(words), std::string::npos) << words << "\n" << text;
  }
  // Both tables say the same of the drift: change of the channel's RMS on held-out time.
  const double explains = std::stod(cell(page, "probe_drift", 5)), change = std::stod(cell(page, "z", 6));
  EXPECT_GT(explains, 50.0);
  EXPECT_NEAR(explains, -change, 0.6);
  // No time that the record does not last.
  const std::regex times("in ([0-9.]+) h|\\(([0-9.]+) h\\)|within ([0-9.]+) h");
  int found = 0;
  for (auto at = std::sregex_iterator(body.begin(), body.end(), times); at != std::sregex_iterator(); ++at, ++found) {
    for (int group = 1; group <= 3; ++group) {
      if ((*at)[group].matched) {
        EXPECT_LE(std::stod((*at)[group]), hours) << at->str();
      }
    }
  }
  EXPECT_GT(found, 2);
}

}  // namespace
}  // namespace thermotwin::cases
