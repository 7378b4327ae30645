#pragma once
// Tables in markdown, columns padded, so that they read as well on a terminal.

#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::bench {

/// The first column to the left, the others that hold numbers only to the right.
class MarkdownTable {
 public:
  explicit MarkdownTable(std::vector<std::string> heads) : rows_{std::move(heads)} {}
  /// Requires: as many cells as there are heads.
  void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  std::size_t size() const { return rows_.size() - 1; }
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;  ///< the first holds the heads
};

/// 12345678 -> "12,345,678".
std::string grouped(double value);
/// printf with one number.
std::string formatted(const char* format, double value);

/// Errors: kIo.
Result<void> write_file(const std::string& path, const std::string& text);

}  // namespace tiltfeed::bench
