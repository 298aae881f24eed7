// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Runs CalculiX (ccx) on decks of the program and reads what it leaves.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>
#include <vector>

#include "solver/export/calculix_deck.h"

namespace thermotwin::test {

inline bool have_ccx() { return std::system("command -v ccx > /dev/null 2>&1") == 0; }

/// A deck in a folder that goes with it.
class CalculiX {
public:
  CalculiX(const mesh::MachineMesh& mesh, const solver::DeckOptions& options) : nodes_(mesh.nodes()) {
    static int count = 0;
    folder_ = std::filesystem::temp_directory_path() /
              ("thermotwin_ccx_" + std::to_string(::getpid()) + "_" + std::to_string(count++));
    summary_ = solver::write_calculix_deck(folder_, mesh, options);
    run("heat");
    if (!options.heat_only) run("static");
  }
  ~CalculiX() {
    if (!::testing::Test::HasFailure()) std::filesystem::remove_all(folder_);
  }

  const solver::DeckSummary& summary() const { return summary_; }
  /// degC at the end of each step of heat.inp, one column a step
  Eigen::MatrixXd temperatures() const {
    const std::vector<Eigen::MatrixXd> blocks = read("heat", "NDTEMP", 1);
    Eigen::MatrixXd all(nodes_, std::ssize(blocks));
    for (std::size_t i = 0; i < blocks.size(); ++i) all.col(i) = blocks[i].row(0).transpose();
    return all;
  }
  /// m, (3 x nodes), in the machine's frame
  Eigen::MatrixXd displacement() const {
    const std::vector<Eigen::MatrixXd> blocks = read("static", "DISP", 3);
    return blocks.empty() ? Eigen::MatrixXd() : blocks.back();
  }

private:
  void run(const std::string& job) const {
    const std::string command =
        "cd '" + folder_.string() + "' && OMP_NUM_THREADS=1 ccx " + job + " > " + job + ".log 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0) << "see " << folder_.string() << "/" << job << ".log";
  }

  /// Results of this name in the .frd file, one matrix (components x nodes) a time.
  std::vector<Eigen::MatrixXd> read(const std::string& job, const std::string& name, int components) const {
    std::ifstream file(folder_ / (job + ".frd"));
    std::vector<Eigen::MatrixXd> blocks;
    bool inside = false;
    for (std::string line; std::getline(file, line);) {
      if (line.starts_with(" -4")) {
        inside = line.substr(5, name.size()) == name && line[5 + name.size()] == ' ';
        if (inside) blocks.push_back(Eigen::MatrixXd::Constant(components, nodes_, std::nan("")));
      } else if (line.starts_with(" -3")) {
        inside = false;
      } else if (inside && line.starts_with(" -1")) {
        const long node = std::stol(line.substr(3, 10));
        if (node > nodes_) continue;
        for (int i = 0; i < components; ++i) blocks.back()(i, node - 1) = std::stod(line.substr(13 + 12 * i, 12));
      }
    }
    return blocks;
  }

  std::filesystem::path folder_;
  Eigen::Index nodes_;
  solver::DeckSummary summary_;
};

}  // namespace thermotwin::test
