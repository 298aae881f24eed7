// SPDX-License-Identifier: GPL-3.0-or-later
// A short selection of the bank, on the toy machine of tests/cases.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "bank.h"
#include "baselines.h"
#include "compensation/measurement/virtual_measurement.h"
#include "core/error.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/offered_causes.h"
#include "diagnosis/causes/parameter.h"
#include "faulty_readings.h"
#include "reduction/basis/reduce.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"
#include "wrong_parts.h"

namespace {

using namespace thermotwin;
using diagnosis::Kind;

struct Bench {
  solver::Case machine_case = solver::read_case(THERMOTWIN_SOURCE_DIR "/tests/cases/toy");
  reduction::ReducedModel model;
  hidden::Specimen specimen{machine_case, other_mesh()};

  static hidden::SpecimenOptions other_mesh() {
    hidden::SpecimenOptions options;
    options.size_factor = 0.7;
    return options;
  }

  Bench() : model(reduced(machine_case, 1.0, 80)) {}

  static reduction::ReducedModel reduced(const solver::Case& machine_case, double size_factor, int order) {
    const solver::FullModel full = solver::build_full_model(machine_case.machine, {size_factor, {}});
    std::vector<solver::LoadProgram> loads;
    for (const std::string& name : machine_case.train) loads.push_back(machine_case.load(name));
    solver::CampaignOptions with_snapshots;
    with_snapshots.keep_snapshots = true;
    reduction::ReduceOptions options;
    options.order = order;
    return reduction::reduce(full, loads, solver::run_campaign(full, loads, with_snapshots), options);
  }
};

Bench& bench() {
  static Bench one;
  return one;
}

hidden::Line run(hidden::Group group, const hidden::Draw& draw) {
  return hidden::diagnose_set("test", group, draw, bench().specimen.measure(draw), bench().model);
}

TEST(HiddenEffects, CleanMachinesRaiseNoAlarm) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    hidden::Draw draw;
    draw.load = "mixed";
    draw.seed = seed;
    const hidden::Line line = run(hidden::Group::clean, draw);
    EXPECT_EQ(line.verdict, diagnosis::Verdict::no_discrepancy) << line.text();
  }
}

TEST(HiddenEffects, WhatSeveralParametersDoTogetherIsNoCause) {
  // Coupling, bearings and friction two stated deviations off: about nominal, a heat capacity describes how they act
  // together.
  hidden::SpecimenOptions options = Bench::other_mesh();
  options.size_factor = 0.5;
  options.seed = 937;
  const hidden::Specimen specimen(bench().machine_case, options);
  const reduction::ReducedModel model = Bench::reduced(bench().machine_case, 0.6, 120);
  hidden::Draw draw;
  draw.load = "day_and_night";
  draw.seed = 93700135;
  const hidden::Line line = hidden::diagnose_set("test", hidden::Group::clean, draw, specimen.measure(draw), model);
  EXPECT_EQ(line.verdict, diagnosis::Verdict::no_discrepancy) << line.text();
}

hidden::Truth truth(Kind kind, const std::string& where, double value) {
  for (const diagnosis::Parameter& p :
       diagnosis::candidate_parameters(bench().specimen.nominal(), bench().specimen.blank("mixed"), true))
    if (p.kind == kind && p.where == where) return {p, value};
  throw std::runtime_error("no " + name_of(kind) + " of " + where);
}

TEST(HiddenEffects, WhatIsHiddenIsNamed) {
  std::uint64_t seed = 30;
  for (const hidden::Truth& t :
       {truth(Kind::source_power, "spindle.bearings", 2.0), truth(Kind::ambient_offset, "air", 2.2),
        truth(Kind::sensor_offset, "T3", -1.5), truth(Kind::expansion_coefficient, "z_slide", 1.3)}) {
    hidden::Draw draw;
    draw.load = "mixed";
    draw.seed = ++seed;
    draw.truths = {t};
    const hidden::Line line = run(hidden::Group::single, draw);
    EXPECT_TRUE(line.identifiable()) << line.text();
    EXPECT_TRUE(line.verdict == diagnosis::Verdict::explained ||
                (line.verdict == diagnosis::Verdict::ambiguous && line.named_probability > 0.9))
        << line.text();
    EXPECT_EQ(line.named_kind + " of " + line.named_where, name_of(t.parameter)) << line.text();
  }
}

hidden::Truth heat_on(const std::string& body, const Eigen::Vector3d& centre, const std::string& follows, double at,
                      double power_W) {
  hidden::Truth t{diagnosis::make_parameter(Kind::source_missing, body), power_W};
  auto source = std::make_shared<diagnosis::MissingSource>();
  source->body = body;
  source->centre = centre;
  source->follows = follows;
  source->at = source->most = at;
  t.parameter.missing = std::move(source);
  return t;
}

TEST(HiddenEffects, EveryFaultyReadingIsInAChannel) {
  const compensation::Measurement blank = bench().specimen.blank("mixed");
  int all_alike = 0;
  for (const diagnosis::Parameter& p : diagnosis::candidate_parameters(bench().specimen.nominal(), blank, true)) {
    if (!diagnosis::acts_on_readings(p.kind)) continue;
    const auto count = std::count_if(blank.channels.begin(), blank.channels.end(),
                                     [&](const auto& channel) { return hidden::concerns(p.where, channel); });
    EXPECT_GE(count, 1) << name_of(p);
    all_alike += p.where.starts_with("displacement.") && count > 1;
  }
  EXPECT_GE(all_alike, 1);
}

TEST(HiddenEffects, HeatThatNoSourceHasIsFoundWhereItIs) {
  hidden::Draw draw;
  draw.load = "mixed";
  draw.seed = 41;
  draw.truths = {heat_on("post", {-0.06, 0.23, -0.07}, "axis.X.feed_mm_min", 8000.0, 120.0)};
  hidden::Beside beside;
  beside.inputs = bench().specimen.followable("mixed");
  const hidden::Record record = bench().specimen.record(draw);
  ASSERT_EQ(record.effective.size(), 1U);
  EXPECT_NEAR(record.effective[0], 120.0, 0.25 * 120.0);
  const hidden::Line line = hidden::diagnose_set("test", hidden::Group::single, draw, record.measurement, bench().model,
                                                 beside, record.effective);
  EXPECT_TRUE(line.identifiable()) << line.text();
  EXPECT_EQ(line.verdict, diagnosis::Verdict::explained) << line.text();
  EXPECT_EQ(line.named_kind, "source_missing") << line.text();
  EXPECT_LE(line.place_error, 100.0) << line.text();
  EXPECT_EQ(line.follows_right, 1.0) << line.text();
}

TEST(HiddenEffects, ACauseIsHarderToTellBesideOneLikeIt) {
  hidden::Draw draw;
  draw.load = "mixed";
  draw.seed = 6;
  const hidden::Seen seen(bench().model, bench().specimen.measure(draw), {});
  const hidden::Truth offset = truth(Kind::sensor_offset, "T3", -1.5), drift = truth(Kind::sensor_drift, "T3", 0.2),
                      elsewhere = truth(Kind::sensor_offset, "T1", 1.5);
  const hidden::Factors alone = seen.factors(offset), beside = seen.factors_beside(offset, elsewhere),
                        by_its_like = seen.factors_beside(offset, drift);
  EXPECT_GT(alone.against_none, 20.0);
  EXPECT_NEAR(beside.against_none, alone.against_none, 0.03 * alone.against_none);
  EXPECT_LT(by_its_like.against_none, 0.95 * alone.against_none);
  EXPECT_LE(beside.against_rival, beside.against_none);
  EXPECT_EQ(seen.factors_beside(offset, offset).against_none, 0.0);
}

TEST(HiddenEffects, WhatIsExpectedOfATruthIsWhatItDoes) {
  // A power that is off by twice as much shows twice as much, a film less than that.
  hidden::Draw clean;
  clean.load = "day_and_night";
  const hidden::Seen seen(bench().model, bench().specimen.measure(clean), {});
  const auto ratio = [&](const hidden::Truth& half, const hidden::Truth& whole) {
    return seen.factors(whole).against_none / seen.factors(half).against_none;
  };
  EXPECT_GT(
      ratio(truth(Kind::source_power, "spindle.bearings", 2.0), truth(Kind::source_power, "spindle.bearings", 3.0)),
      3.9);
  EXPECT_LT(ratio(truth(Kind::film_coefficient, "swivel", 3.0), truth(Kind::film_coefficient, "swivel", 5.0)), 3.0);
}

TEST(HiddenEffects, RecordsAreAsGoodAsTheirToleranceSays) {
  // Temperatures in K and displacements in um, which are of one size here.
  const auto recorded = [](double tolerance_K, double solved_to) {
    hidden::SpecimenOptions options = Bench::other_mesh();
    options.tolerance_K = tolerance_K;
    options.solved_to = solved_to;
    const hidden::Specimen specimen(bench().machine_case, options);
    hidden::Draw draw;
    draw.load = "mixed";
    draw.seed = 61;
    draw.truths = {truth(Kind::source_power, "spindle.bearings", 2.0)};
    return specimen.measure(draw, hidden::Recording::exact).data.values;
  };
  const double solved_to = hidden::SpecimenOptions().solved_to;
  const Eigen::MatrixXd exact = recorded(1e-5, 1e-11);
  EXPECT_LT((recorded(1e-5, solved_to) - exact).cwiseAbs().maxCoeff(), 1e-3);  // of equations solved less well, alone
  double last = 1e300;
  for (const double tolerance_K : {1e-1, 1e-2}) {
    const double error = (recorded(tolerance_K, solved_to) - exact).cwiseAbs().maxCoeff();
    EXPECT_LT(error, tolerance_K) << tolerance_K;
    EXPECT_LT(error, 0.5 * last) << tolerance_K;
    last = error;
  }
  EXPECT_GT(last, 0.0);
}

TEST(HiddenEffects, WhatTheModelSimplifiesIsMeasuredAsItIs) {
  const auto recorded = [](int pads, bool exact_radiation, double emissivity) {
    hidden::SpecimenOptions options = Bench::other_mesh();
    options.finer_pads = pads;
    options.exact_radiation = exact_radiation;
    solver::Case machine_case = bench().machine_case;
    for (mesh::FilmSpec& film : machine_case.machine.films) film.emissivity.value = emissivity;
    const hidden::Specimen specimen(machine_case, options);
    hidden::Draw draw;
    draw.load = "mixed";
    return specimen.measure(draw, hidden::Recording::exact).data.values;
  };
  const Eigen::MatrixXd stated = recorded(1, false, 0.0);
  EXPECT_GT((recorded(3, false, 0.0) - stated).cwiseAbs().maxCoeff(), 0.05);
  EXPECT_EQ((recorded(1, true, 0.0) - stated).cwiseAbs().maxCoeff(), 0.0) << "nothing radiates";
  EXPECT_GT((recorded(1, true, 0.9) - recorded(1, false, 0.9)).cwiseAbs().maxCoeff(), 0.005);
}

TEST(HiddenEffects, ASpotWarmsItsPlaceByOneWatt) {
  hidden::Random random(3);
  const hidden::Specimen& specimen = bench().specimen;
  const mesh::MachineMesh& mesh = specimen.mesh();
  for (int i = 0; i < 5; ++i) {
    const auto [body, centre] = hidden::drawn_place(mesh, random);
    const Eigen::VectorXd heat = specimen.warmth_at(body, centre);
    EXPECT_NEAR(heat.sum(), 1.0, 1e-12);
    const std::size_t b = mesh.machine.body_index(body);
    const Eigen::VectorXd own = heat.segment(mesh.first_node[b], mesh.bodies[b].nodes());
    EXPECT_NEAR(own.sum(), 1.0, 1e-12);
    EXPECT_LE((mesh.bodies[b].points * own - centre).norm(), 0.06);
  }
}

TEST(HiddenEffects, ATapeThatGrowsMoreChangesWhatIsReadAlongItAndNothingElse) {
  hidden::Draw draw;
  draw.load = "mixed";
  draw.seed = 5;
  const compensation::Measurement right = bench().specimen.measure(draw, hidden::Recording::exact);
  draw.truths = {truth(Kind::scale_expansion, "X", 2.0)};
  const hidden::Record record = bench().specimen.record(draw, hidden::Recording::exact);
  const compensation::Measurement& wrong = record.measurement;
  ASSERT_EQ(record.effective.size(), 1U);
  EXPECT_NEAR(record.effective[0], 2.0, 0.2);
  const std::size_t poses = bench().specimen.measured_poses() + 2;
  EXPECT_EQ(std::count_if(right.channels.begin(), right.channels.end(),
                          [](const auto& c) { return c.id.starts_with("dx@"); }),
            static_cast<long>(poses));
  for (const compensation::MeasuredChannel& channel : right.channels) {
    const double change = (wrong.values(channel) - right.values(channel)).cwiseAbs().maxCoeff();
    if (channel.kind == compensation::ChannelKind::temperature) {
      EXPECT_EQ(change, 0.0) << channel.id;
    } else if (channel.id == "dx@2") {
      EXPECT_GT(change, 0.5) << channel.id;
    } else if (channel.id == "dz@1") {
      EXPECT_LT(change, 0.05) << channel.id;
    }
  }
}

TEST(HiddenEffects, WhatEachOfTwoAmountsToCountsTheMachinesOwnDeviation) {
  const mesh::Machine& nominal = bench().machine_case.machine;
  hidden::Draw draw;
  draw.load = "mixed";
  draw.seed = 10;
  draw.truths = {truth(Kind::sensor_offset, "T2", 1.0), truth(Kind::source_power, nominal.sources.front().id, 1.5)};
  const std::vector<double> effective = bench().specimen.record(draw).effective;
  ASSERT_EQ(effective.size(), 2U);
  EXPECT_EQ(effective[0], 1.0);
  const double own =
      compensation::perturbed(nominal, draw.seed).sources.front().scale.value / nominal.sources.front().scale.value;
  EXPECT_GT(std::abs(own - 1.0), 0.005);
  EXPECT_NEAR(effective[1], 1.5 * own, 1e-12);
}

TEST(HiddenEffects, ARecordDiffersFromItsNoiselessOneByNoiseAlone) {
  hidden::Draw draw;
  draw.load = "mixed";
  draw.seed = 12;
  const hidden::Record record = bench().specimen.record(draw);
  const compensation::Measurement exact = bench().specimen.measure(draw, hidden::Recording::exact);
  ASSERT_EQ(record.noiseless.data.values.rows(), record.measurement.data.values.rows());
  EXPECT_LT(record.noiseless.data.values.rows(), exact.data.values.rows());
  for (const compensation::MeasuredChannel& channel : record.measurement.channels) {
    if (!channel.input.empty()) continue;
    const Eigen::ArrayXd noisy = record.measurement.values(channel), clean = record.noiseless.values(channel);
    EXPECT_TRUE((noisy.isNaN() == clean.isNaN()).all()) << channel.id;
    const Eigen::ArrayXd noise = noisy.isNaN().select(0.0, noisy - clean);
    const double rms = std::sqrt(noise.square().sum() / ((!noisy.isNaN()).count()));
    EXPECT_GT(rms, 0.5 * channel.uncertainty) << channel.id;
    EXPECT_LT(rms, 1.5 * channel.uncertainty) << channel.id;
  }
}

/// Noiseless, without effect, on the bench's mesh.
compensation::Measurement recorded(hidden::Rows rows) {
  hidden::SpecimenOptions options = Bench::other_mesh();
  options.rows = rows;
  options.missing_share = 0.0;
  hidden::Draw draw;
  draw.load = "mixed";
  draw.seed = 5;
  return hidden::Specimen(bench().machine_case, options).record(draw).noiseless;
}

TEST(HiddenEffects, ASparseLogHasNoRowsAtTheChanges) {
  const Eigen::MatrixXd own = recorded(hidden::Rows::own).data.values,
                        sparse = recorded(hidden::Rows::sparse).data.values;
  int shared = 0;
  for (Eigen::Index i = 1; i + 1 < sparse.rows(); ++i) {
    EXPECT_GE(sparse(i, 0) - sparse(i - 1, 0), 240.0);
    EXPECT_LE(sparse(i, 0) - sparse(i - 1, 0), 360.0);
    shared += (own.col(0).array() - sparse(i, 0)).abs().minCoeff() < 1e-6;
  }
  EXPECT_EQ(shared, 0);
  EXPECT_EQ(sparse(sparse.rows() - 1, 0), own(own.rows() - 1, 0));
  // The same machine under the same load.
  EXPECT_LT((sparse.bottomRows(1) - own.bottomRows(1)).cwiseAbs().maxCoeff(), 0.05);
}

TEST(HiddenEffects, ALogWithPausesHasTwoGaps) {
  const Eigen::MatrixXd own = recorded(hidden::Rows::own).data.values,
                        paused = recorded(hidden::Rows::pauses).data.values;
  ASSERT_LT(paused.rows(), own.rows());
  const Eigen::Index readings = 7;
  int gaps = 0;
  for (Eigen::Index i = 1, at = 0; i < paused.rows(); ++i) {
    const Eigen::Index before = at;
    while (own(at, 0) != paused(i, 0)) ASSERT_LT(++at, own.rows());
    gaps += at > before + 1;
    EXPECT_EQ(paused.row(i).tail(readings), own.row(at).tail(readings));
  }
  EXPECT_EQ(gaps, 2);
}

TEST(HiddenEffects, AnEarlierBanksRowIsRead) {
  hidden::Line line;
  line.id = "x", line.kind = "source_power", line.second_named = 1.0, line.place_allowed = 120.0;
  const std::string text = line.text();
  EXPECT_EQ(hidden::Line::parse(text).place_allowed, 120.0);
  const std::string without_refit = text.substr(0, text.rfind('\t'));
  EXPECT_EQ(hidden::Line::parse(without_refit).place_allowed, 120.0);
  EXPECT_EQ(hidden::Line::parse(without_refit).refit_over_winner, hidden::Line::absent);
  const hidden::Line earlier = hidden::Line::parse(without_refit.substr(0, without_refit.rfind('\t')));
  EXPECT_EQ(earlier.id, "x");
  EXPECT_EQ(earlier.second_named, 1.0);
  EXPECT_EQ(earlier.place_allowed, hidden::Line::absent);
}

/// No constant change of these joints describes what happened, so that without a step no cause is the likeliest.
TEST(HiddenEffects, LostPreloadIsAStepWhereNoConstantChangeFits) {
  const std::pair<const char*, std::uint64_t> of[] = {{"X_guide", 2}, {"Z_guide", 1}};
  for (const auto& [joint, seed] : of) {
    hidden::Draw draw;
    draw.load = "mixed";
    draw.seed = seed;
    draw.outside = hidden::Outside::lost_preload;
    draw.outside_where = joint;
    const hidden::Line line = run(hidden::Group::change, draw);
    EXPECT_EQ(line.named_kind + " " + line.named_where, std::string("contact_step ") + joint) << line.text();
    EXPECT_GT(line.named_probability, 0.9) << line.text();
  }
}

TEST(HiddenEffects, WhatNoKindDescribesIsNotNamed) {
  for (const char* sensor : {"T2", "T4"}) {
    hidden::Draw draw;
    draw.load = "mixed";
    draw.seed = 21;
    const hidden::Record clean = bench().specimen.record(draw);
    draw.outside = hidden::Outside::slipping_cable;
    draw.outside_where = sensor;
    const hidden::Record spoilt = bench().specimen.record(draw);
    hidden::Beside beside;
    beside.affected = &spoilt.noiseless;
    beside.unaffected = &clean.noiseless;
    const hidden::Line line =
        hidden::diagnose_set("test", hidden::Group::outside, draw, spoilt.measurement, bench().model, beside);
    EXPECT_TRUE(line.visible() && line.unlike_any()) << line.text();
    EXPECT_EQ(line.verdict, diagnosis::Verdict::unexplained) << line.text();
    const std::vector<std::string> notes = diagnosis::diagnose(bench().model, spoilt.measurement, {}).notes;
    EXPECT_EQ(std::count(notes.begin(), notes.end(),
                         std::string("The unexplained residual is concentrated in one channel alone: ") + sensor + "."),
              1);
  }
}

TEST(Baselines, LearnWhatTheyCan) {
  const Eigen::Index n = 60;
  Eigen::MatrixXd x(n, 4);
  hidden::Random random(11);
  for (double& value : x.reshaped()) value = random.normal();
  // Two of four columns matter: a sparse sum finds these, and shrinks them by the penalty.
  const Eigen::VectorXd y = 2.0 * x.col(1) - 0.7 * x.col(3);
  const Eigen::VectorXd b = hidden::lasso(x, y, 0.1);
  EXPECT_NEAR(b[1], 2.0, 0.25);
  EXPECT_NEAR(b[3], -0.7, 0.25);
  EXPECT_LT(std::abs(b[0]) + std::abs(b[2]), 0.05);
  EXPECT_GT(hidden::lasso(x, y, 0.0)[1], b[1]);
  EXPECT_EQ(hidden::lasso(x, y, 100.0).norm(), 0.0);
  // A smooth function between its samples.
  const Eigen::MatrixXd at = Eigen::VectorXd::LinSpaced(21, -2.0, 2.0),
                        between = Eigen::VectorXd::LinSpaced(8, -1.8, 1.7);
  const Eigen::VectorXd smooth = at.array().sin() + 3.0, expected = between.array().sin() + 3.0;
  EXPECT_LT((hidden::gaussian_process(at, smooth, between) - expected).cwiseAbs().maxCoeff(), 0.05);
}

TEST(HiddenEffects, OptionsOfASpecimenAreChecked) {
  hidden::SpecimenOptions options;
  EXPECT_NO_THROW(options.validate());
  options.missing_share = 1.0;
  EXPECT_THROW(options.validate(), core::InputError);
  options.missing_share = 0.1;
  options.tolerance_K = 0.0;
  EXPECT_THROW(options.validate(), core::InputError);
}

TEST(HiddenEffects, LinesAreReadAsTheyWereWritten) {
  hidden::Line line;
  line.id = "a_1";
  line.group = "single";
  line.kind = "film_coefficient";
  line.where = "table";
  line.value = 1.5;
  line.verdict = diagnosis::Verdict::explained;
  line.against_none = 40;
  line.against_rival = 12;
  line.second_named = true;
  EXPECT_EQ(hidden::Line::parse(line.text()).text(), line.text());
  EXPECT_TRUE(hidden::Line::parse(line.text()).identifiable());
}

TEST(HiddenEffects, TheScoreCountsWhatItSays) {
  const auto line = [](const char* group, diagnosis::Verdict verdict, const char* named, double against_none,
                       double probability) {
    hidden::Line l;
    l.id = "x";
    l.group = group;
    l.kind = "source_power", l.where = "motor", l.value = 2.0, l.estimate = 2.1, l.std = 0.1;
    l.verdict = verdict;
    l.named_kind = named, l.named_where = "motor";
    l.against_none = against_none, l.against_rival = against_none;
    l.probability = l.named_probability = probability;
    l.rank = 1;
    return l;
  };
  const std::string table = hidden::score({line("single", diagnosis::Verdict::explained, "source_power", 50, 0.95),
                                           line("single", diagnosis::Verdict::explained, "film_coefficient", 50, 0.95),
                                           line("single", diagnosis::Verdict::no_discrepancy, "source_power", 5, 0.3),
                                           line("clean", diagnosis::Verdict::explained, "source_power", 0, 0.95)});
  EXPECT_NE(table.find("| >= 60 % | 66.7 % (2 of 3) |"), std::string::npos) << table;
  EXPECT_NE(table.find("| >= 95 % | 50.0 % (1 of 2) |"), std::string::npos) << table;
  EXPECT_NE(table.find("| 0 of 200 | 100.0 % (1 of 1) |"), std::string::npos) << table;
  hidden::Line like_one = line("outside", diagnosis::Verdict::explained, "source_power", 500, 0.95);
  like_one.against_rival = 3;
  const std::string outside =
      hidden::score({line("outside", diagnosis::Verdict::unexplained, "source_power", 50, 0.0),
                     line("outside", diagnosis::Verdict::unexplained, "source_power", 29, 0.0), like_one});
  EXPECT_NE(outside.find("or a law or step of the right place | >= 85 % | 50.0 % (1 of 2) |"), std::string::npos)
      << outside;
  EXPECT_NE(outside.find("leaves some of it | - | 100.0 % (1 of 1) |"), std::string::npos) << outside;
  hidden::Line spot = line("single", diagnosis::Verdict::explained, "source_missing", 50, 0.95);
  spot.kind = "source_missing", spot.place_error = 60.0, spot.region = 40.0, spot.follows_right = 1.0;
  spot.program_before = 5.0, spot.program_after = 3.0, spot.program_truth = 1.0;
  spot.poses_before = 5.0, spot.poses_after = 6.0, spot.poses_truth = 1.0;
  const std::string places = hidden::score({spot});
  EXPECT_NE(places.find("place within 100 mm | >= 80 % | 100.0 % (1 of 1) |"), std::string::npos) << places;
  EXPECT_NE(places.find("holds the truth | 90-98 % | 0.0 % (0 of 1) |"), std::string::npos) << places;
  EXPECT_NE(places.find("relative to the truth's, median | >= 0.9 | 0.50 (1 sets) |"), std::string::npos) << places;
  EXPECT_NE(places.find("at unseen poses, median | >= 0.9 | -0.25 (1 sets) |"), std::string::npos) << places;
  // Of a single, a pair and a clean set, all sure, the pair is right: its second effect is named first.
  hidden::Line pair = line("pair", diagnosis::Verdict::explained, "film_coefficient", 50, 0.95);
  pair.kind2 = "film_coefficient", pair.where2 = "motor";
  hidden::Line clean = line("clean", diagnosis::Verdict::ambiguous, "source_power", 0, 0.95);
  clean.kind = clean.where = "";
  hidden::Line settled = line("single", diagnosis::Verdict::ambiguous, "film_coefficient", 50, 0.89);
  settled.set = "film_coefficient motor; source_power motor";
  const std::string wrong = hidden::score(
      {line("single", diagnosis::Verdict::explained, "film_coefficient", 50, 0.95), pair, clean, settled});
  EXPECT_NE(wrong.find("of singles, pairs and clean sets | <= 1 % | 50.0 % (2 of 4) |"), std::string::npos) << wrong;
  EXPECT_NE(wrong.find("`explained`, identifiable | >= 80 % | 50.0 % (1 of 2) |"), std::string::npos) << wrong;
  EXPECT_NE(wrong.find("named or in the set, identifiable | - | 50.0 % (1 of 2) |"), std::string::npos) << wrong;
  // A change in time: the step of its place is right, that of another place is not, and neither is a steady cause.
  hidden::Line elsewhere = line("change", diagnosis::Verdict::explained, "source_step", 50, 0.95);
  elsewhere.where = "pump";
  const std::string changes =
      hidden::score({line("change", diagnosis::Verdict::explained, "source_step", 50, 0.95),
                     line("change", diagnosis::Verdict::unexplained, "none", 50, 0.95),
                     line("change", diagnosis::Verdict::explained, "source_power", 50, 0.95),
                     line("change", diagnosis::Verdict::explained, "source_step", 29, 0.95), elsewhere});
  EXPECT_NE(changes.find("told in the same way | - | 50.0 % (2 of 4) |"), std::string::npos) << changes;
  spot.place_allowed = 59.0;
  EXPECT_NE(hidden::score({spot}).find("12 sensors or more | >= 50 % | 0.0 % (0 of 1) |"), std::string::npos);
  // Claimed 0.95 three times, right once (a clean set has no cause).
  EXPECT_NE(table.find("expected calibration error"), std::string::npos) << table;
}

}  // namespace
