// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/text.h"

#include <gtest/gtest.h>

#include "core/config.h"

namespace thermotwin::core {
namespace {

TEST(Text, APlainNumberHasNoExponent) {
  EXPECT_EQ(plain_number(358.2, 2), "360");
  EXPECT_EQ(plain_number(2170.3, 4), "2170");
  EXPECT_EQ(plain_number(152.0, 2), "150");
  EXPECT_EQ(plain_number(-12345.6, 4), "-12350");
  EXPECT_EQ(plain_number(0.01234, 2), "0.012");
  EXPECT_EQ(plain_number(0.00001234, 2), "0.000012");
  EXPECT_EQ(plain_number(0.0, 2), "0");
  EXPECT_EQ(plain_number(3e12, 2), "3e+12");
  EXPECT_EQ(plain_number(1.4, 4), "1.4");
}

TEST(Text, EditDistance) {
  EXPECT_EQ(edit_distance("", ""), 0U);
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
  EXPECT_EQ(edit_distance("sitting", "kitten"), 3U);
  EXPECT_EQ(edit_distance("saturday", "sunday"), 3U);
}

TEST(Text, Nearest) {
  EXPECT_EQ(nearest("spindel", {"speed", "spindle", "axis"}), "spindle");
  EXPECT_EQ(nearest("x", {}), "");
  EXPECT_EQ(nearest("ab", {"ac", "ad"}), "ac") << "the first of equals";
}

TEST(Text, Join) {
  EXPECT_EQ(join({}), "");
  EXPECT_EQ(join({"a"}), "a");
  EXPECT_EQ(join({"a", "b", "c"}), "a, b, c");
  EXPECT_EQ(join({"a", "b"}, "/"), "a/b");
}

TEST(Text, TableAlignsNumbersRightByShownWidth) {
  EXPECT_EQ(format_table({{"model", "rms µm"}, {"größe", "1.5"}, {"b", "-12"}}),
            "model  rms µm\n"
            "-----  ------\n"
            "größe     1.5\n"
            "b         -12\n");
}

TEST(Text, TableTakesShortRows) {
  EXPECT_EQ(format_table({{"a", "b"}, {"1"}}), "a  b\n-  -\n1\n");
  EXPECT_EQ(format_table({}), "");
}

TEST(Text, Utf8) {
  const auto bad_at = [](std::string_view text) {
    const auto offset = find_invalid_utf8(text);
    return offset ? static_cast<int>(*offset) : -1;
  };
  EXPECT_EQ(bad_at(""), -1);
  EXPECT_EQ(bad_at("aµ€😀\xED\x9F\xBF\xEE\x80\x80\xF4\x8F\xBF\xBF"), -1);
  EXPECT_EQ(bad_at("a\x80"), 1);   // continuation alone
  EXPECT_EQ(bad_at("ab\xC3"), 2);  // cut off
  EXPECT_EQ(bad_at("\xC3("), 0);
  EXPECT_EQ(bad_at("\xC0\xAF"), 0);          // overlong
  EXPECT_EQ(bad_at("\xE0\x9F\xBF"), 0);      // overlong
  EXPECT_EQ(bad_at("\xF0\x8F\xBF\xBF"), 0);  // overlong
  EXPECT_EQ(bad_at("\xED\xA0\x80"), 0);      // surrogate
  EXPECT_EQ(bad_at("\xF4\x90\x80\x80"), 0);  // above U+10FFFF
  EXPECT_EQ(bad_at("\xF8\x88\x80\x80\x80"), 0);
}

TEST(Text, OtherLettersMayStandInQuotesAndComments) {
  for (const char* good : {"", "a = 1",
                           "\xEF\xBB\xBF"
                           "a = 1",
                           "a = \"ä\"", "a = 'ä' # µm", "# ä\na = 1", "a = \"\"\"\nä \"\" ä\"\"\"", "a = \"\\\"ä\"",
                           "a = '\\'\nb = 'ä'", "a = \"\"\"ä\"\"\"\"\"\n"})
    EXPECT_EQ(find_bare_non_ascii(good), std::nullopt) << good;
  EXPECT_EQ(find_bare_non_ascii("ä = 1"), 0U);
  EXPECT_EQ(find_bare_non_ascii("a = 1 ä"), 6U);
  EXPECT_EQ(find_bare_non_ascii("a\xEF\xBB\xBF"), 1U);
  EXPECT_EQ(find_bare_non_ascii("a = \"x\"ä"), 7U);
  EXPECT_EQ(find_bare_non_ascii("a = '\\'ä"), 7U);
  EXPECT_EQ(find_bare_non_ascii("a = '''x'''ä"), 11U);
  EXPECT_EQ(find_bare_non_ascii("# c\nä"), 4U);
}

TEST(Text, TrimmedLosesBlanksAtBothEndsOnly) {
  EXPECT_EQ(trimmed(" \t a b\r\n"), "a b");
  EXPECT_EQ(trimmed("a"), "a");
  EXPECT_EQ(trimmed(" \t\r\n"), "");
  EXPECT_EQ(trimmed(""), "");
}

TEST(Text, AStringOfTomlReadsBackAsItIs) {
  for (const char* text : {"plain", "a \"quote\"", "back\\slash", "tab\tand\nline", "\x7F \x01", "µm °C", ""}) {
    const Config config = Config::parse("key = " + toml_text(text) + "\n", "test");
    EXPECT_EQ(config.root().text("key"), text);
  }
}

TEST(XmlText, IsHarmless) {
  EXPECT_EQ(xml_text("a<b & \"c\">"), "a&lt;b &amp; &quot;c&quot;&gt;");
  EXPECT_EQ(xml_text(std::string_view("x\x01y\x00\tz\n", 7)), "xy\tz\n");
  EXPECT_EQ(xml_text("µm °C"), "µm °C");
}

}  // namespace
}  // namespace thermotwin::core
