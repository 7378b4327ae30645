#pragma once
// Where the values of a YAML text stand in it: what is changed in place is cut out by these.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "config/yaml_tree.h"

namespace tiltfeed::config {

/// Offsets are bytes from 0. Requires: `text` outlives it; nodes are those of parse_yaml(text).
class TextLayout {
 public:
  explicit TextLayout(const std::string& text);

  std::size_t at(TextPlace place) const {
    return starts_[static_cast<std::size_t>(place.line) - 1] + static_cast<std::size_t>(place.column) - 1;
  }
  /// Of the line that has this place.
  std::size_t line_start(std::size_t at) const;
  /// Of the line break, or the text's end.
  std::size_t line_end(std::size_t at) const;
  std::size_t next_line(std::size_t at) const;
  /// Blanks before the first letter of the line at `start`; nothing: a blank line.
  std::optional<std::size_t> indent(std::size_t start) const;

  /// Written in braces or brackets.
  bool flows(const YamlNode& node) const;
  /// A map or list by indents.
  bool is_block(const YamlNode& node) const;
  /// Behind the value's last letter. `in_flow`: it stands in braces or brackets.
  std::size_t end_of(const YamlNode& node, bool in_flow) const;
  /// The start of the line behind a value and the remarks that belong to it: those further in than `indent`.
  std::size_t behind(const YamlNode& node, std::size_t indent) const;

 private:
  std::size_t quote_end(std::size_t start) const;
  std::size_t closing(std::size_t start) const;

  const std::string& text_;
  std::vector<std::size_t> starts_;
};

/// Of a key in a map; nothing where it has none.
std::optional<std::size_t> key_index(const YamlNode& map, const std::string& key);
/// The same values, wherever they stand and in whatever order keys are.
bool same_value(const YamlNode& a, const YamlNode& b);

}  // namespace tiltfeed::config
