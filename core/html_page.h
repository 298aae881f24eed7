// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Pages of HTML that need nothing else: one file, no network, light and dark schemes. All verbs that leave a page take
// its parts from here, so that the pages look alike. Arguments named `markup` are HTML and enter as they are; all
// others are plain text and are escaped here.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace thermotwin::core {

/// A whole document with the style of pages and of plots.
std::string html_document(std::string_view title, std::string_view body_markup);

/// A sentence that is plain ASCII for terminals: escaped, with the signs for "+-", "um", "degC" and "W/m2".
std::string html_sentence(std::string_view words);

/// Name of the page and a line below it.
std::string html_title(std::string_view title, std::string_view below);

/// A number with what it is above and a note below.
std::string html_tile(std::string_view label_markup, std::string_view value_markup, std::string_view below_markup);
std::string html_tiles(const std::vector<std::string>& tiles);

enum class Tone { plain, good, warn };
/// What the page finds, in a sentence or two: the first thing to read. @param label  a word above it
std::string html_finding(Tone tone, std::string_view label, const std::vector<std::string>& sentences_markup);

/// Heading and a card. @param below_markup  a line that explains the content; may be empty
std::string html_section(std::string_view heading, std::string_view below_markup, std::string_view content_markup);

/// A picture that is no wider than this on a wide page.
std::string html_wide(int most_px, std::string_view picture_markup);

/// A picture as a card of its own, to stand in a grid. @param note  short, on the right; may be empty
std::string html_figure(std::string_view caption, std::string_view note, std::string_view picture_markup);
std::string html_figures(const std::vector<std::string>& figures);

/// First row is the header, as for format_table(); columns of numbers align right.
std::string html_table(const std::vector<std::vector<std::string>>& rows);

/// One of several contents, chosen by a list. The first one shows; without scripts all of them do.
/// @param id  unique on the page  @param items  name and markup of each
std::string html_choice(std::string_view id, std::string_view label,
                        const std::vector<std::pair<std::string, std::string>>& items);

struct NextStep {
  std::string why, command;
};
/// "What to do next": a sentence and a command each.
std::string html_next_steps(const std::vector<NextStep>& steps);

}  // namespace thermotwin::core
