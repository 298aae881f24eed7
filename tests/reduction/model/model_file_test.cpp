// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/model/model_file.h"

#include <gtest/gtest.h>

#include <iterator>
#include <random>

#include "core/error.h"
#include "core/file.h"
#include "reduction/linear/hdf5_store.h"
#include "reduction/model/output_grid.h"
#include "solver/operation/layout.h"
#include "tests/core/temporary_folder.h"
#include "tests/machines/boxes.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Right shapes, random numbers over many magnitudes: what is written must come back bit by bit.
ReducedModel random_model(Index r = 7) {
  std::mt19937 engine(5);
  const auto random = [&](Index rows, Index columns) -> MatrixXd {
    return MatrixXd::NullaryExpr(rows, columns, [&](Index, Index) {
      return std::ldexp(std::uniform_real_distribution<double>(-1, 1)(engine), static_cast<int>(engine() % 600) - 300);
    });
  };
  ReducedModel model;
  model.machine = test::small_machine();
  model.size = "coarse, 1234 nodes";
  model.full_size = 1236;
  std::vector<solver::JointGrid> grids;
  for (const mesh::JointSpec& joint : model.machine.joints) {
    const int axis = joint.axis.empty() ? -1 : model.machine.axis_index(joint.axis);
    if (axis < 0) {
      grids.push_back({axis, false, {0.0}});
    } else {
      grids.push_back({axis, joint.axis == "C", {0.0, 0.1, 1.0 / 3.0}});
    }
  }
  model.system.layout = solver::make_layout(model.machine, grids);
  model.system.capacity = MatrixXd::Identity(r, r);
  model.system.conduction = random(r, r);
  for (std::size_t j = 0; j < model.system.layout.terms.size(); ++j) model.system.terms.push_back(random(r, r));
  model.system.inputs = random(r, std::ssize(model.system.layout.inputs));
  model.system.sensors = random(std::ssize(model.machine.sensors), r);
  model.system.one_kelvin = random(r, 1);
  model.outputs.tool_poses = mesh::workspace_poses(model.machine);
  model.outputs.table_poses = OutputGrid(model.machine).table_poses();
  for (std::size_t i = 0; i < model.outputs.tool_poses.size(); ++i) model.outputs.tool.push_back(random(6, r));
  for (std::size_t i = 0; i < model.outputs.table_poses.size(); ++i) {
    model.outputs.table_axis.push_back(random(6, r));
    model.outputs.table_own.push_back(random(7, r));
  }
  model.errors = {{"validation", 31.25, 0.042, 0.011}, {"a load", 5.0, 0.1, 0.05}};
  return model;
}

std::string message_of(const std::filesystem::path& path) {
  try {
    read_model(path);
  } catch (const core::InputError& error) {
    return error.what();
  }
  return {};
}

TEST(ModelFile, ComesBackBitByBit) {
  const core::TemporaryFolder scratch;
  const std::filesystem::path path = scratch.path() / "model.rom.h5";
  const ReducedModel model = random_model();
  write_model(path, model);
  const ReducedModel back = read_model(path);
  EXPECT_EQ(back.machine.text, model.machine.text);
  EXPECT_EQ(back.machine.hash, model.machine.hash);
  EXPECT_EQ(back.size, model.size);
  EXPECT_EQ(back.full_size, model.full_size);
  EXPECT_EQ(back.system.capacity, model.system.capacity);
  EXPECT_EQ(back.system.conduction, model.system.conduction);
  EXPECT_EQ(back.system.terms, model.system.terms);
  EXPECT_EQ(back.system.inputs, model.system.inputs);
  EXPECT_EQ(back.system.sensors, model.system.sensors);
  EXPECT_EQ(back.system.one_kelvin, model.system.one_kelvin);
  EXPECT_EQ(back.outputs.tool_poses, model.outputs.tool_poses);
  EXPECT_EQ(back.outputs.table_poses, model.outputs.table_poses);
  EXPECT_EQ(back.outputs.tool, model.outputs.tool);
  EXPECT_EQ(back.outputs.table_axis, model.outputs.table_axis);
  EXPECT_EQ(back.outputs.table_own, model.outputs.table_own);
  ASSERT_EQ(back.system.layout.grids.size(), model.system.layout.grids.size());
  for (std::size_t i = 0; i < back.system.layout.grids.size(); ++i) {
    EXPECT_EQ(back.system.layout.grids[i].positions, model.system.layout.grids[i].positions);
    EXPECT_EQ(back.system.layout.grids[i].axis, model.system.layout.grids[i].axis);
    EXPECT_EQ(back.system.layout.grids[i].periodic, model.system.layout.grids[i].periodic);
  }
  ASSERT_EQ(back.system.layout.terms.size(), model.system.layout.terms.size());
  ASSERT_EQ(back.errors.size(), 2u);
  EXPECT_EQ(back.errors[0].load, "validation");
  EXPECT_EQ(back.errors[1].load, "a load");
  EXPECT_EQ(back.errors[0].max_um, 0.042);
  // Equal models are equal files.
  write_model(scratch.path() / "again.rom.h5", back);
  EXPECT_TRUE(core::read_file(path) == core::read_file(scratch.path() / "again.rom.h5"));
}

TEST(ModelFile, ForeignFilesAreRefused) {
  const core::TemporaryFolder scratch;
  const std::filesystem::path text = scratch.path() / "text.h5", other = scratch.path() / "other.h5";
  core::write_file(text, "time_s,T1_C\n0,20\n");
  EXPECT_NE(message_of(text).find("no HDF5 file"), std::string::npos) << message_of(text);
  EXPECT_NE(message_of(scratch.path() / "none.h5").find("no such file"), std::string::npos);
  EXPECT_NE(message_of(scratch.path()).find("a folder"), std::string::npos) << message_of(scratch.path());
  StoreWriter foreign("other");
  foreign.text_attribute("/", "title", "something else");
  core::write_file(other, foreign.finish());
  EXPECT_NE(message_of(other).find("not a reduced model"), std::string::npos) << message_of(other);
}

TEST(ModelFile, PartsComeBackAndMayBeAbsent) {
  const core::TemporaryFolder scratch;
  const std::filesystem::path path = scratch.path() / "model.rom.h5";
  ReducedModel model = random_model();
  write_model(path, model);
  EXPECT_FALSE(read_model(path).parts.has_value());
  Parts parts;
  for (std::size_t b = 0; b < model.machine.bodies.size(); ++b) parts.capacity.push_back(MatrixXd::Random(7, 7));
  parts.bodies.resize(model.machine.bodies.size());
  parts.stiffness.resize(model.machine.joints.size());
  parts.stiffness_exponent = Eigen::VectorXd::Random(std::ssize(model.machine.joints));
  for (ReducedOutputs* part : {&parts.bodies[3], &parts.stiffness[1]}) {
    *part = model.outputs;
    part->tool_poses.clear();
    part->table_poses.clear();
    part->tool[2] *= 3.0;
  }
  model.parts = parts;
  write_model(path, model);
  const Parts back = read_model(path).parts.value();
  EXPECT_EQ(back.capacity, parts.capacity);
  EXPECT_EQ(back.bodies[3].tool, parts.bodies[3].tool);
  EXPECT_EQ(back.bodies[3].table_own, parts.bodies[3].table_own);
  EXPECT_EQ(back.stiffness[1].table_axis, parts.stiffness[1].table_axis);
  EXPECT_EQ(back.stiffness_exponent, parts.stiffness_exponent);
  EXPECT_TRUE(back.bodies[0].tool.empty());
  EXPECT_EQ(back.scales.size(), model.machine.scales.size());
  model.parts->capacity.pop_back();
  write_model(path, model);
  EXPECT_NE(message_of(path).find("/parts/capacity"), std::string::npos) << message_of(path);
}

TEST(ModelFile, TheMeshErrorComesBackAndMayBeAbsent) {
  const core::TemporaryFolder scratch;
  const std::filesystem::path path = scratch.path() / "model.rom.h5";
  ReducedModel model = random_model();
  write_model(path, model);
  EXPECT_FALSE(read_model(path).mesh_error.has_value());
  MeshError error;
  error.sensors = Eigen::VectorXd::LinSpaced(std::ssize(model.machine.sensors), 0.01, 0.03);
  error.tcp << 0.01, 0.02, 0.03, 0.04, 0.05, 0.06;
  error.second = "quadratic, 1.6 times the element size";
  model.mesh_error = error;
  write_model(path, model);
  const MeshError back = read_model(path).mesh_error.value();
  EXPECT_EQ(back.sensors, error.sensors);
  EXPECT_EQ(back.tcp, error.tcp);
  EXPECT_EQ(back.second, error.second);
  model.mesh_error->tcp[2] = 1.5;
  write_model(path, model);
  EXPECT_NE(message_of(path).find("/mesh_error with a share outside 0 to 1"), std::string::npos) << message_of(path);
}

TEST(ModelFile, TheAirBesideTheSensorsComesBackAndMayBeAbsent) {
  const core::TemporaryFolder scratch;
  const std::filesystem::path path = scratch.path() / "model.rom.h5";
  ReducedModel model = random_model();
  write_model(path, model);
  EXPECT_FALSE(read_model(path).sensor_air.has_value());
  SensorAir air;
  air.film.setConstant(std::ssize(model.machine.sensors), 1);
  air.film[0] = -1;
  air.volumes = MatrixXd::Random(std::ssize(model.machine.volumes), 7);
  model.sensor_air = air;
  write_model(path, model);
  const SensorAir back = read_model(path).sensor_air.value();
  EXPECT_EQ(back.film, air.film);
  EXPECT_EQ(back.volumes, air.volumes);
  model.sensor_air->film[0] = std::ssize(model.machine.films);
  write_model(path, model);
  EXPECT_NE(message_of(path).find("/sensor_air/film that does not fit"), std::string::npos) << message_of(path);
}

TEST(ModelFile, AnotherVersionIsNamed) {
  const core::TemporaryFolder scratch;
  const std::filesystem::path path = scratch.path() / "old.rom.h5";
  StoreWriter old("old");
  old.text_attribute("/", "format", "thermotwin reduced model");
  old.integer_attribute("/", "version", model_file_version + 1);
  core::write_file(path, old.finish());
  const std::string message = message_of(path);
  EXPECT_NE(message.find("version " + std::to_string(model_file_version + 1)), std::string::npos) << message;
  EXPECT_NE(message.find("old.rom.h5"), std::string::npos) << message;
}

TEST(ModelFile, ATruncatedFileIsRefusedWhereverItEnds) {
  const core::TemporaryFolder scratch;
  const std::filesystem::path path = scratch.path() / "model.rom.h5", cut = scratch.path() / "cut.rom.h5";
  write_model(path, random_model(3));
  const std::string bytes = core::read_file(path);
  for (int i = 0; i < 40; ++i) {
    core::write_file(cut, std::string_view(bytes).substr(0, bytes.size() * static_cast<std::size_t>(i) / 40));
    EXPECT_NE(message_of(cut), "") << "cut at " << i << "/40";
  }
}

TEST(ModelFile, ADamagedNumberIsNoticed) {
  const core::TemporaryFolder scratch;
  const std::filesystem::path path = scratch.path() / "model.rom.h5";
  const ReducedModel model = random_model();
  write_model(path, model);
  std::string bytes = core::read_file(path);
  const double value = model.system.one_kelvin(3);
  const std::size_t at = bytes.find(std::string(reinterpret_cast<const char*>(&value), sizeof value));
  ASSERT_NE(at, std::string::npos);
  bytes[at + 2] = static_cast<char>(bytes[at + 2] ^ 4);
  core::write_file(path, bytes);
  EXPECT_NE(message_of(path).find("checksum"), std::string::npos) << message_of(path);
}

TEST(ModelFile, AnyFlippedBitIsAnError) {
  const core::TemporaryFolder scratch;
  const std::filesystem::path path = scratch.path() / "model.rom.h5";
  write_model(path, random_model(3));
  std::string bytes = core::read_file(path);
  std::mt19937_64 random(17);
  for (int flip = 0; flip < 500; ++flip) {
    const std::size_t bit = random() % (8 * bytes.size());
    const auto turn = [&] { bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << (bit % 8))); };
    turn();
    core::write_file(path, bytes);
    EXPECT_NE(message_of(path), "") << "bit " << bit;
    turn();
  }
  core::write_file(path, bytes);
  EXPECT_EQ(message_of(path), "") << "as it was";
}

// As written before files had a checksum.
TEST(ModelFile, AFileWithoutChecksumIsToBeWrittenAnew) {
  const core::TemporaryFolder scratch;
  const std::filesystem::path path = scratch.path() / "model.rom.h5";
  write_model(path, random_model(3));
  const std::string bytes = core::read_file(path);
  core::write_file(path, std::string_view(bytes).substr(0, bytes.rfind("\nthermotwin")));
  EXPECT_NE(message_of(path).find("thermotwin reduce"), std::string::npos) << message_of(path);
}

// As written while the checksum was one of single bytes.
TEST(ModelFile, AFileWithTheEarlierChecksumIsReadAndItsDamageNoticed) {
  const core::TemporaryFolder scratch;
  const std::filesystem::path path = scratch.path() / "model.rom.h5";
  const ReducedModel model = random_model(3);
  write_model(path, model);
  std::string bytes = core::read_file(path);
  bytes.resize(bytes.rfind("\nthermotwin"));
  const std::string line = "\nthermotwin fnv1a-64 " + core::content_hash(bytes) + "\n";
  core::write_file(path, bytes + line);
  EXPECT_EQ(read_model(path).system.conduction, model.system.conduction);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  core::write_file(path, bytes + line);
  EXPECT_NE(message_of(path).find("checksum"), std::string::npos) << message_of(path);
}

TEST(ModelFile, SizesThatDisagreeAndMissingNumbersAreRefused) {
  const core::TemporaryFolder scratch;
  const std::filesystem::path path = scratch.path() / "model.rom.h5";
  ReducedModel model = random_model();
  model.system.sensors = MatrixXd::Ones(5, 7);
  write_model(path, model);
  EXPECT_NE(message_of(path).find("/system/sensors"), std::string::npos) << message_of(path);
  model = random_model();
  model.system.inputs(2, 1) = std::nan("");
  write_model(path, model);
  EXPECT_NE(message_of(path).find("not finite"), std::string::npos) << message_of(path);
  model = random_model();
  model.system.layout.grids[2].positions.pop_back();
  write_model(path, model);
  EXPECT_NE(message_of(path), "");
  model = random_model();
  model.outputs.tool.pop_back();
  model.outputs.tool_poses.pop_back();
  write_model(path, model);
  EXPECT_NE(message_of(path).find("tool poses"), std::string::npos) << message_of(path);
}

TEST(ModelFile, AFailedWriteLeavesTheEarlierFile) {
  const core::TemporaryFolder scratch;
  const std::filesystem::path path = scratch.path() / "model.rom.h5";
  write_model(path, random_model());
  const std::string before = core::read_file(path);
  ReducedModel broken = random_model();
  broken.system.terms[1] = MatrixXd::Ones(2, 2);
  EXPECT_THROW(write_model(path, broken), core::InputError);
  EXPECT_TRUE(core::read_file(path) == before);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(scratch.path()), {}), 1) << "no temporary file stays";
}

}  // namespace
}  // namespace thermotwin::reduction
