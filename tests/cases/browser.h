// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Pages in a browser without a window (chromium), and what they must not have.

#include <filesystem>
#include <string>

namespace thermotwin::cases {

/// Command of the browser; empty: there is none.
std::string browser();

struct Page {
  std::string document, log;                             ///< after its scripts have run; what the browser says
  std::string attribute(const std::string& name) const;  ///< the first of this name; empty: none
  /// Value of an attribute of the element with this id.
  std::string attribute_of(const std::string& id, const std::string& name) const;
};

/// @param hash    with its #, or empty
/// @param folder  for the browser's own files: other tests copy the run's while it writes
Page opened(const std::filesystem::path& file, const std::string& hash, const std::filesystem::path& folder);

/// A page of this computer that follows something, some seconds after it was opened.
/// @param address  http://127.0.0.1:...  @param folder  for the browser's own files, new
Page followed(const std::string& address, const std::filesystem::path& folder);

/// At most 5 MB, nothing from elsewhere, whole.
void expect_self_contained(const std::filesystem::path& file);
/// Dragging on the canvas with this id changes its picture, and so does the wheel.
/// @param folder  for a copy of the page and the browser's own files
void expect_turns_and_zooms(const std::filesystem::path& file, const std::string& canvas,
                            const std::filesystem::path& folder);
/// Opens, and no script complains.
void expect_quiet(const Page& page);

}  // namespace thermotwin::cases
