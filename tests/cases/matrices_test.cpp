// SPDX-License-Identifier: GPL-3.0-or-later
// `reduce --matrices` as a user meets it: Matrix Market files in, reduced ones out.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>

#include "core/file.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

const std::string coordinate = "%%MatrixMarket matrix coordinate real general\n";

/// Three states: gains 1 and 1/2 at rest, Hankel singular values known for each alone.
class Matrices {
public:
  Matrices() {
    write("A", coordinate + "3 3 3\n1 1 -1\n2 2 -10\n3 3 -1000\n");
    write("B", coordinate + "3 1 3\n1 1 1\n2 1 1\n3 1 0.001\n");
    write("C", coordinate + "1 3 3\n1 1 1\n1 2 1\n1 3 1\n");
  }
  void write(const std::string& name, const std::string& text) const { core::write_file(in() / (name + ".mtx"), text); }
  std::filesystem::path in() const { return folder_ / "in"; }
  std::filesystem::path out() const { return folder_ / "out"; }
  Result reduce(std::vector<std::string> more = {}) const {
    std::vector<std::string> all{"reduce", "--matrices", in().string(), "--out", out().string()};
    all.insert(all.end(), more.begin(), more.end());
    return thermotwin(all);
  }

private:
  core::TemporaryFolder folder_;
};

TEST(Matrices, AreReducedToFilesOfTheSameForm) {
  const Matrices matrices;
  const Result result = matrices.reduce({"--json", "--quiet", "--compare", "--order", "2"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(result.err, "");
  const auto summary = nlohmann::json::parse(result.out);
  EXPECT_EQ(summary["n"], 3);
  EXPECT_EQ(summary["inputs"], 1);
  EXPECT_EQ(summary["outputs"], 1);
  EXPECT_EQ(summary["order"], 2);
  EXPECT_TRUE(summary["stable"].get<bool>());
  ASSERT_EQ(summary["hankel_singular_values"].size(), 3U);
  EXPECT_DOUBLE_EQ(summary["bound"].get<double>(), 2 * summary["hankel_singular_values"][2].get<double>());
  EXPECT_LE(summary["hinf_error_sampled"].get<double>(), summary["bound"].get<double>() * (1 + 1e-6));
  EXPECT_NEAR(summary["hinf_norm_sampled"].get<double>(), 1.0 + 0.1 + 1e-6, 1e-12);
  for (const char* name : {"E.mtx", "A.mtx", "B.mtx", "C.mtx", "system.rom.h5"})
    EXPECT_TRUE(std::filesystem::exists(matrices.out() / name)) << name;

  // What was written is read again, and cannot be reduced without loss.
  const Result again = thermotwin({"reduce", "--matrices", matrices.out().string(), "--out",
                                   (matrices.out() / "again").string(), "--json", "--quiet", "--order", "2"});
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_NEAR(nlohmann::json::parse(again.out)["hankel_singular_values"][0].get<double>(),
              summary["hankel_singular_values"][0].get<double>(), 1e-12);
}

TEST(Matrices, TheTextSaysOrderBoundAndTrueError) {
  const Matrices matrices;
  for (const char* method : {"balanced", "modal", "krylov"}) {
    const Result result = matrices.reduce({"--method", method, "--order", "1"});
    EXPECT_EQ(result.status, 0) << result.err;
    for (const char* words : {"3 states", "Hankel", "bound", "true error", "order 1 by", method})
      EXPECT_SAYS(result.out, words);
  }
}

TEST(Matrices, FilmsHaveNamesAndValues) {
  const Matrices matrices;
  matrices.write("A_film_air", coordinate + "3 3 1\n1 1 -1\n");
  const Result result = matrices.reduce({"--film", "air=0,9", "--json", "--quiet"});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto summary = nlohmann::json::parse(result.out);
  ASSERT_EQ(summary["points"].size(), 2U);
  EXPECT_EQ(summary["points"][1]["films"]["air"], 9.0);
  EXPECT_TRUE(std::filesystem::exists(matrices.out() / "A_film_air.mtx"));
  const Result unknown = matrices.reduce({"--film", "ar=1"});
  EXPECT_EQ(unknown.status, 3);
  EXPECT_SAYS(unknown.err, "nearest: air");
  EXPECT_SAYS(matrices.reduce({"--film", "air=9"}).out, "at          air 9\n");
  EXPECT_SAYS(matrices.reduce().out, "at          every film at its value in names.toml, or 1 without one\n");
  EXPECT_EQ(matrices.reduce({"--film", "air"}).status, 3);
  EXPECT_EQ(matrices.reduce({"--film", "air=x"}).status, 3);
}

/// A rod of n lumps, free at both ends: A is singular.
void write_free_rod(const Matrices& matrices, int n) {
  std::string a = fmt::format("{}{} {} {}\n", coordinate, n, n, 3 * n - 2),
              b = fmt::format("{}{} 1 1\n1 1 1\n", coordinate, n),
              c = fmt::format("{}1 {} 1\n1 {} 1\n", coordinate, n, n);
  for (int i = 1; i <= n; ++i) {
    a += fmt::format("{} {} {}\n", i, i, i == 1 || i == n ? -1 : -2);
    if (i < n) a += fmt::format("{} {} 1\n{} {} 1\n", i, i + 1, i + 1, i);
  }
  matrices.write("A", a);
  matrices.write("B", b);
  matrices.write("C", c);
}

TEST(Matrices, ASingularAIsNamedOnBothRoutes) {
  for (const int n : {200, 3200}) {
    const Matrices matrices;
    write_free_rod(matrices, n);
    const Result result = matrices.reduce();
    EXPECT_EQ(result.status, 3) << result.err;
    for (const char* words : {"not stable", "A is singular", "zero within rounding", "a support"})
      EXPECT_SAYS(result.err, words);
  }
}

TEST(Matrices, UnsignedIntegersAreRead) {
  const Matrices matrices;
  matrices.write("C", "%%MatrixMarket matrix coordinate unsigned-integer general\n1 3 3\n1 1 1\n1 2 1\n1 3 1\n");
  const Result result = matrices.reduce({"--order", "2"});
  EXPECT_EQ(result.status, 0) << result.err;
}

TEST(Matrices, WrongUsageIsSaid) {
  const Matrices matrices;
  const Result both = thermotwin({"reduce", toy_case().string(), "--matrices", matrices.in().string()});
  EXPECT_EQ(both.status, 2);
  EXPECT_SAYS(both.err, "--matrices");
  EXPECT_SAYS(both.err, "CASE");
  const Result neither = thermotwin({"reduce"});
  EXPECT_EQ(neither.status, 2);
  EXPECT_SAYS(neither.err, "a CASE or --matrices DIR is needed");
  EXPECT_EQ(matrices.reduce({"--size", "fine"}).status, 2);
  EXPECT_EQ(thermotwin({"reduce", toy_case().string(), "--film", "air=1"}).status, 2);
  const Result magic = matrices.reduce({"--method", "magic"});
  EXPECT_EQ(magic.status, 2);
  EXPECT_SAYS(magic.err, "one of: balanced, modal, krylov");
}

struct BadMatrix {
  std::string name, file, text;
  std::vector<std::string> said;
};
void PrintTo(const BadMatrix& slip, std::ostream* out) { *out << slip.name; }

class BadMatrices : public testing::TestWithParam<BadMatrix> {};

TEST_P(BadMatrices, AreRefusedAndLeaveEarlierResults) {
  const BadMatrix& bad = GetParam();
  const Matrices matrices;
  ASSERT_EQ(matrices.reduce().status, 0);
  const auto before = files_in(matrices.out());
  if (bad.text.empty())
    std::filesystem::remove(matrices.in() / (bad.file + ".mtx"));
  else
    matrices.write(bad.file, bad.text);
  const Result result = matrices.reduce();
  EXPECT_EQ(result.status, 3) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_SAYS(result.err, "allowed: ");
  for (const std::string& words : bad.said) EXPECT_SAYS(result.err, words);
  EXPECT_EQ(files_in(matrices.out()), before);
  // Without earlier results no folder is left behind.
  std::filesystem::remove_all(matrices.out());
  EXPECT_EQ(matrices.reduce().status, 3);
  EXPECT_FALSE(std::filesystem::exists(matrices.out()));
}

INSTANTIATE_TEST_SUITE_P(
    Slips, BadMatrices,
    testing::ValuesIn(std::vector<BadMatrix>{
        {"NoSuchFile", "B", "", {"B.mtx", "no such file"}},
        {"NoBanner", "A", "3 3 0\n", {"A.mtx:1", "%%MatrixMarket"}},
        {"NotANumber", "A", coordinate + "3 3 1\n1 1 nan\n", {"A.mtx:3", "'nan'", "a finite number"}},
        {"NotSquare", "A", coordinate + "3 4 1\n1 1 1\n", {"A.mtx", "3 x 4", "square"}},
        {"OtherSize", "C", coordinate + "1 4 1\n1 1 1\n", {"C.mtx", "1 x 4", "1 x 3"}},
        {"NoInput", "B", coordinate + "3 1 0\n", {"B.mtx", "has no input"}},
        {"NoOutput", "C", coordinate + "1 3 0\n", {"C.mtx", "has no output"}},
        {"HugeInput", "B", coordinate + "3 1 1\n1 1 1e200\n", {"B.mtx", "1e+200", "1e-100 to 1e100"}},
        {"TinyOutput", "C", coordinate + "1 3 1\n1 1 1e-200\n", {"C.mtx", "1e-200", "1e-100 to 1e100"}},
        {"Unstable", "A", coordinate + "3 3 3\n1 1 -1\n2 2 0.25\n3 3 -1000\n", {"not stable", "eigenvalue 0.25"}},
        {"Oscillating",
         "A",
         coordinate + "3 3 5\n1 1 -1\n2 2 0.5\n2 3 2\n3 2 -2\n3 3 0.5\n",
         {"not stable", "0.5 +- 2 i"}},
        {"SingularE",
         "E",
         coordinate + "3 3 2\n1 1 1\n2 2 1\n",
         {"E.mtx", "singular", "1 of its 3 rows are empty", "Schur complement"}},
    }),
    [](const auto& bad) { return bad.param.name; });

TEST(Matrices, TheirOwnFolderIsNoPlaceForResults) {
  const Matrices matrices;
  const auto before = files_in(matrices.in());
  const Result result = thermotwin({"reduce", "--matrices", matrices.in().string(), "--out", matrices.in().string()});
  EXPECT_EQ(result.status, 3);
  EXPECT_SAYS(result.err, "another folder");
  EXPECT_EQ(files_in(matrices.in()), before);
}

}  // namespace
}  // namespace thermotwin::cases
