#pragma once
// JSON text of other programs as a plain tree that remembers what was asked of it.

#include <map>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::config {

enum class JsonKind { kNothing, kFlag, kNumber, kText, kList, kMap };

struct JsonNode {
  JsonKind kind = JsonKind::kNothing;
  double number = 0.0;  ///< also 1 of true
  std::string text;
  std::vector<std::string> keys;  ///< of a map
  std::vector<JsonNode> items;    ///< of a list; of a map: items[i] is the value of keys[i]
  mutable bool asked = false;

  /// Null where there is none, or where this is no map.
  const JsonNode* find(const std::string& key) const;
  /// The text at a key without blanks at its ends and without control characters; empty where there is none.
  std::string text_at(const std::string& key) const;
  /// The finite number at a key; 0 where there is none.
  double number_at(const std::string& key) const;
  /// All beneath it is asked for.
  void pass_over() const;
  /// The paths of texts, numbers and flags that nobody asked for and that say something, and how many
  /// have each; lists are named by their key alone.
  void count_unasked(const std::string& path, std::map<std::string, int>& counts) const;
};

/// `file` goes into messages. Errors: kInput with line and column, or nesting over 64 levels.
Result<JsonNode> parse_json(const std::string& text, const std::string& file);

/// One line for a message: without control characters and blanks at its ends.
std::string one_line(const std::string& text);

}  // namespace tiltfeed::config
