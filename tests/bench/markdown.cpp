#include "tests/bench/markdown.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

namespace tiltfeed::bench {

namespace {

bool is_number(const std::string& cell) {
  return cell.find_first_not_of("0123456789.,e+- ") == std::string::npos;
}

}  // namespace

std::string MarkdownTable::text() const {
  std::vector<std::size_t> widths(rows_.front().size(), 0);
  std::vector<bool> right(widths.size(), true);
  right.front() = false;
  for (std::size_t r = 0; r < rows_.size(); ++r)
    for (std::size_t c = 0; c < widths.size(); ++c) {
      widths[c] = std::max(widths[c], rows_[r][c].size());
      if (r > 0 && !is_number(rows_[r][c])) right[c] = false;
    }
  std::string out;
  const auto add_line = [&](const std::vector<std::string>& cells) {
    for (std::size_t c = 0; c < widths.size(); ++c) {
      const std::string blanks(widths[c] - cells[c].size(), ' ');
      out.append("| ").append(right[c] ? blanks : cells[c]).append(right[c] ? cells[c] : blanks).append(" ");
    }
    out += "|\n";
  };
  add_line(rows_.front());
  for (std::size_t c = 0; c < widths.size(); ++c)
    out.append("|").append(widths[c] + 1, '-').append(right[c] ? ":" : "-");
  out += "|\n";
  for (std::size_t r = 1; r < rows_.size(); ++r) add_line(rows_[r]);
  return out;
}

std::string grouped(double value) {
  const std::string digits = formatted("%.0f", std::abs(value));
  std::string text;
  if (value < 0.0) text += '-';
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += ',';
    text += digits[i];
  }
  return text;
}

std::string formatted(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

Result<void> write_file(const std::string& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  out.close();
  if (!out) return fail(Code::kIo, path + " cannot be written");
  return {};
}

}  // namespace tiltfeed::bench
