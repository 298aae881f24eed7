// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reads case files (TOML). Each value knows its file and line. A missing key, a wrong type, a value out of range and
// an unknown key are InputErrors; the message of an unknown key names the nearest known one. A node is a light
// handle, and the Config that made it must outlive it. A Config with a KeyTable takes ranges and defaults from there.

#include <Eigen/Core>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/key_table.h"
#include "core/range.h"
#include "core/uncertain.h"

namespace thermotwin::core {

class Node;

class Config {
public:
  /// @param keys  the file's; null: any key may be asked for. It must outlive the Config
  /// @throws InputError (unreadable, not UTF-8, not TOML; with line and column)
  static Config load(const std::filesystem::path& path, const KeyTable* keys = nullptr);
  static Config parse(const std::string& text, const std::string& source, const KeyTable* keys = nullptr);
  Config(Config&&) noexcept;
  Config& operator=(Config&&) noexcept;
  ~Config();

  Node root() const;
  const std::string& text() const;    ///< the file as read
  const std::string& source() const;  ///< its name for messages

private:
  Config();
  friend class Node;
  struct Data;
  std::unique_ptr<Data> data_;
};

/// A table of the file. Every key that is read counts as known; finish() rejects the others.
/// In a file with a KeyTable, a key is one of its rows: an absent one has the row's value; a range or words that are
/// given here apply instead of the row's, where they follow from other values of the file.
/// @throws std::logic_error for a key without a row, or read as another kind than the row says
class Node {
public:
  bool has(const std::string& key) const;
  std::vector<std::string> keys() const;  ///< as written; counts none as known

  double number(const std::string& key, std::optional<Range> range = {}) const;
  double number_or(const std::string& key, double otherwise, std::optional<Range> range = {}) const {
    return has(key) ? number(key, range) : otherwise;
  }
  Uncertain uncertain(const std::string& key, std::optional<Range> range = {}) const;
  Uncertain uncertain_or(const std::string& key, Uncertain otherwise, std::optional<Range> range = {}) const {
    return has(key) ? uncertain(key, range) : otherwise;
  }
  int integer(const std::string& key) const;
  int integer(const std::string& key, int low, int high) const;
  int integer_or(const std::string& key, int otherwise, int low, int high) const {
    return has(key) ? integer(key, low, high) : otherwise;
  }
  /// The version of the file's keys, from 1. @throws InputError naming both for a newer one than is read; absent
  int schema(int newest) const;
  bool boolean(const std::string& key) const;
  bool boolean_or(const std::string& key, bool otherwise) const;
  std::string text(const std::string& key) const;
  std::string text_or(const std::string& key, const std::string& otherwise) const {
    return has(key) ? text(key) : otherwise;
  }
  /// @param allowed  none: those of the key's row. @throws InputError unless the text is one of the allowed words
  std::string choice(const std::string& key, const std::vector<std::string>& allowed = {}) const;
  std::string choice_or(const std::string& key, const std::string& otherwise,
                        const std::vector<std::string>& allowed = {}) const {
    return has(key) ? choice(key, allowed) : otherwise;
  }
  Eigen::Vector3d vector3(const std::string& key) const;
  bool is_list(const std::string& key) const;  ///< an array stands there
  std::vector<double> numbers(const std::string& key) const;
  std::vector<std::string> texts(const std::string& key) const;  ///< a text or an array of texts
  std::vector<std::string> texts_or_empty(const std::string& key) const {
    return has(key) ? texts(key) : std::vector<std::string>();
  }
  /// [[x, y, z], ...] as rows (n x 3)
  Eigen::MatrixX3d points3(const std::string& key) const;

  Node table(const std::string& key) const;  ///< [key] or key = {...}; required
  std::optional<Node> table_if(const std::string& key) const {
    return has(key) ? std::optional(table(key)) : std::nullopt;
  }
  std::vector<Node> tables(const std::string& key) const;  ///< [[key]]; absent: empty

  /// "machine.toml:12 film[3].law" - of this table, or of one of its keys; the third [[film]] is [3]
  std::string place() const;
  std::string place(const std::string& key) const;

  /// @throws InputError for the first key that was never read: an unknown one, with the nearest known key, or one
  ///   that has no meaning beside the others
  void finish() const;

private:
  friend class Config;
  struct Data;
  explicit Node(std::shared_ptr<Data> data);
  std::shared_ptr<Data> data_;
};

}  // namespace thermotwin::core
