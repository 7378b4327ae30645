#include "config/job_catalogue.h"

#include <map>
#include <sstream>
#include <utility>
#include <vector>

namespace tiltfeed::config {
namespace {

/// Remarks further in go on with what stands above them.
constexpr std::size_t kShallow = 8;

bool is_key(const std::string& word) {
  return !word.empty() &&
         word.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789") == std::string::npos;
}

std::string trimmed(const std::string& text) {
  const std::size_t from = text.find_first_not_of(' ');
  return from == std::string::npos ? "" : text.substr(from, text.find_last_not_of(' ') - from + 1);
}

/// Reads "  - key: value   # words", and the same as a remark; at the left edge only with words.
struct ExampleLine {
  std::size_t indent = 0;
  std::string key, value, words;
  bool remark = false;  ///< nothing but a remark

  explicit ExampleLine(const std::string& text) {
    std::string rest = text;
    indent = std::min(rest.find_first_not_of(' '), rest.size());
    rest.erase(0, indent);
    const bool hidden = rest.rfind("# ", 0) == 0;
    std::string given = hidden ? rest.substr(2) : rest;
    if (given.rfind("- ", 0) == 0) given.erase(0, 2), indent += 2;
    const std::size_t colon = given.find(':');
    if (colon != std::string::npos && is_key(given.substr(0, colon)) &&
        (!hidden || (indent > 0 && indent <= kShallow) || given.find(" # ") != std::string::npos)) {
      key = given.substr(0, colon);
      const std::size_t hash = given.find(" # ");
      if (hash != std::string::npos) words = trimmed(given.substr(hash + 3));
      value = trimmed(given.substr(colon + 1, hash == std::string::npos ? hash : hash - colon - 1));
    } else if (rest.rfind('#', 0) == 0) {
      remark = true;
      words = trimmed(rest.substr(1));
    }
  }
};

void append(std::string& text, const std::string& words) {
  if (!words.empty()) text += (text.empty() ? "" : " ") + words;
}

/// Without "[circle] " at its start: who asks sees the key only where it applies.
std::string without_users(std::string words) {
  if (words.rfind('[', 0) == 0)
    if (const std::size_t end = words.find("] "); end != std::string::npos) words.erase(0, end + 2);
  return words;
}

}  // namespace

std::vector<DescribedKey> described_keys(const std::string& text) {
  std::vector<DescribedKey> keys;
  std::vector<std::pair<std::size_t, std::string>> open;  // indents and paths of the keys around
  std::istringstream in(text);
  std::string above;
  for (std::string line_text; std::getline(in, line_text);) {
    const ExampleLine line(line_text);
    if (line.key.empty()) {
      if (line.remark && line.indent > kShallow && !keys.empty()) append(keys.back().words, line.words);
      if (line.remark && line.indent <= kShallow) append(above, line.words);
      if (!line.remark) above.clear();
      continue;
    }
    while (!open.empty() && open.back().first >= line.indent) open.pop_back();
    keys.push_back({open.empty() ? line.key : open.back().second + "." + line.key, line.value,
                    line.words.empty() ? above : line.words});
    open.emplace_back(line.indent, keys.back().path);
    above.clear();
  }
  return keys;
}

namespace {

std::map<std::string, std::string> read_help() {
  std::map<std::string, std::string> help;
  for (const DescribedKey& key : described_keys(example_job_text())) append(help[key.path], key.words);
  for (auto& [path, words] : help) words = without_users(words);
  return help;
}

}  // namespace

std::string key_help(const std::string& path) {
  static const std::map<std::string, std::string> help = read_help();
  std::string plain;
  bool inside = false;
  for (const char c : path) {
    if (c == '[') inside = true;
    if (!inside) plain += c;
    if (c == ']') inside = false;
  }
  const auto found = help.find(plain);
  return found == help.end() ? "" : found->second;
}

}  // namespace tiltfeed::config
