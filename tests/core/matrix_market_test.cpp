// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/matrix_market.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/error.h"

namespace thermotwin::core {
namespace {

Eigen::MatrixXd parse(const std::string& text) { return parse_matrix_market(text, "m.mtx"); }

Eigen::MatrixXd square(double a, double b, double c, double d) {
  Eigen::MatrixXd matrix(2, 2);
  matrix << a, b, c, d;
  return matrix;
}

std::string coordinate(const std::string& rest) { return "%%MatrixMarket matrix coordinate " + rest; }

TEST(MatrixMarket, ReadsEveryKind) {
  const auto same = [](const std::string& text, const Eigen::MatrixXd& wanted) {
    EXPECT_EQ(parse(text), wanted) << text;
  };
  same(coordinate("real general\n% a comment\n\n2 2 3\n1 1 1.5\n2 1 -2e-1\n1 2 3\n"), square(1.5, 3, -0.2, 0));
  same(coordinate("real symmetric\n2 2 2\n1 1 1\n2 1 2\n"), square(1, 2, 2, 0));
  same(coordinate("real skew-symmetric\n2 2 1\n2 1 2\n"), square(0, -2, 2, 0));
  same(coordinate("integer general\n2 2 1\n2 2 7\n"), square(0, 0, 0, 7));
  same(coordinate("pattern symmetric\n2 2 2\n2 1\n2 2\n"), square(0, 1, 1, 1));
  same("%%MatrixMarket matrix array real general\n2 2\n1\n2\n3\n4\n", square(1, 3, 2, 4));
  same("%%MatrixMarket matrix array real symmetric\n2 2\n1\n2\n3\n", square(1, 2, 2, 3));
  same("%%MatrixMarket matrix array real skew-symmetric\n2 2\n5\n", square(0, -5, 5, 0));
  same("%%matrixmarket MATRIX Array Real General\r\n2 2\r\n1\r\n2\r\n3\r\n4\r\n", square(1, 3, 2, 4));
}

TEST(MatrixMarket, NumbersAsProgramsWriteThem) {
  EXPECT_EQ(parse(coordinate("real general\n2 2 4\n1 1 +1.5\n1 2 1.5D-3\n2 1 2d0\n2 2 1e-400\n")),
            square(1.5, 1.5e-3, 2, 0));
  EXPECT_EQ(parse(coordinate("real general\n  2   2 2\n1 1 1\n\n  1 1   2.5  ")), square(3.5, 0, 0, 0))
      << "entries given twice are summed";
}

TEST(MatrixMarket, AByteOrderMarkBeforeTheBannerIsPassedOver) {
  EXPECT_EQ(parse("\xEF\xBB\xBF" + coordinate("real general\n1 1 1\n1 1 2\n"))(0, 0), 2.0);
}

TEST(MatrixMarket, WhatIsWrittenIsReadAgainBitByBit) {
  Eigen::MatrixXd matrix(3, 2);
  matrix << 1.0 / 3, -1e-300, 0, 5e300, std::numeric_limits<double>::denorm_min(), 1;
  EXPECT_EQ(parse(format_matrix_market(matrix, "a matrix")), matrix);
}

struct Wrong {
  std::string text, place, said;
};

TEST(MatrixMarket, ErrorsNameLineValueAndWhatIsAllowed) {
  const std::vector<Wrong> all = {
      {"", "m.mtx:1", "%%MatrixMarket"},
      {"2 2 1\n1 1 1\n", "m.mtx:1", "banner"},
      {"%%MatrixMarket matrix coordinate real\n", "m.mtx:1", "five words"},
      {coordinate("complex general\n1 1 1\n1 1 1 0\n"), "m.mtx:1", "real, integer, pattern"},
      {coordinate("real hermitian\n1 1 1\n1 1 1\n"), "m.mtx:1", "'hermitian'"},
      {coordinate("real general\n"), "m.mtx:2", "no size line"},
      {coordinate("real general\n2 2\n1 1 1\n"), "m.mtx:2", "without entries"},
      {coordinate("real general\n0 2 1\n1 1 1\n"), "m.mtx:2", "rows '0'"},
      {coordinate("real general\n2 x 1\n1 1 1\n"), "m.mtx:2", "columns 'x'"},
      {coordinate("real general\n2 2 2\n1 1 1\n"), "m.mtx:4", "after 1 of 2 entries"},
      {coordinate("real general\n2 2 1\n1 1 1\n% but\n2 2 1\n"), "m.mtx:5", "after the last entry"},
      {coordinate("real general\n2 2 1\n3 1 1\n"), "m.mtx:3", "row '3'"},
      {coordinate("real general\n2 2 1\n1 0 1\n"), "m.mtx:3", "column '0'"},
      {coordinate("real general\n2 2 1\n1 1\n"), "m.mtx:3", "without a value"},
      {coordinate("real general\n2 2 2\n1 1 1\n1 2 nan\n"), "m.mtx:4", "'nan'"},
      {coordinate("real general\n2 2 1\n1 1 -inf\n"), "m.mtx:3", "'-inf'"},
      {coordinate("real general\n2 2 1\n1 1 1e999\n"), "m.mtx:3", "'1e999'"},
      {coordinate("real general\n2 2 1\n1 1 1.0x\n"), "m.mtx:3", "'1.0x'"},
      {coordinate("real general\n2 2 1\n1 1 1 0\n"), "m.mtx:3", "'0' after the entry"},
      {coordinate("integer general\n2 2 1\n1 1 1.5\n"), "m.mtx:3", "whole number"},
      {coordinate("unsigned-integer general\n2 2 1\n1 1 -1\n"), "m.mtx:3", "0 or more"},
      {coordinate("real symmetric\n2 3 1\n1 1 1\n"), "m.mtx:2", "square"},
      {coordinate("real symmetric\n2 2 1\n1 2 1\n"), "m.mtx:3", "above the diagonal"},
      {coordinate("real skew-symmetric\n2 2 1\n1 1 1\n"), "m.mtx:3", "on the diagonal"},
      {"%%MatrixMarket matrix array real general\n2 2\n1\n2\n3\n", "m.mtx:6", "before entry (2, 2)"},
      {"%%MatrixMarket matrix array pattern general\n2 2\n", "m.mtx:1", "array pattern"},
      {"%%MatrixMarket matrix array real general\n1000000 1000000\n1\n", "m.mtx:2", "bytes"},
  };
  for (const Wrong& wrong : all) {
    try {
      parse(wrong.text);
      ADD_FAILURE() << "was accepted:\n" << wrong.text;
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_TRUE(message.starts_with(wrong.place + ":")) << message;
      EXPECT_NE(message.find(wrong.said), std::string::npos) << message;
      EXPECT_NE(message.find("; allowed: "), std::string::npos) << message;
    }
  }
}

}  // namespace
}  // namespace thermotwin::core
