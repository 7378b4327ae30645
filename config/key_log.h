#pragma once
// What the readers ask of a file, key by key: the one source of forms and tables of keys.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "config/range.h"
#include "config/yaml_tree.h"

namespace tiltfeed::config {

enum class KeyKind {
  kNumber,
  kInteger,
  kWord,  ///< one of KeyFact::words
  kText,
  kVector,      ///< [x, y, z]
  kDirection,   ///< likewise, of any length but zero
  kDirections,  ///< a list of those
  kInterval,    ///< [low, high]
  kPoints,      ///< a list of [u, v]
  kList,        ///< of maps, whose keys are KeyFact::words
};
/// "number", "integer", ...
const char* word_of(KeyKind kind);

/// One question of a reader: what it takes at a key, and whether the file has it.
struct KeyFact {
  std::string path = {};  ///< dotted, "cutter.holder[1].length_mm"
  KeyKind kind = KeyKind::kText;
  std::optional<Range> range = {};  ///< of a number, or of each number
  bool required = false;
  std::string usual = {};  ///< the default as it would be typed; empty: required, or no plain value
  std::vector<std::string> words = {};
  std::size_t least = 0, most = 0;  ///< items of a list; 0: no list
  std::string unused = {};          ///< why the key is refused in this file; empty: it is taken
  bool present = false;
  TextPlace place = {};  ///< of the value, where present
};

class KeyLog {
 public:
  /// What is refused stays refused; else the first that asks counts, but for a plain text.
  void add(KeyFact fact);
  /// The keys that a section knows, in their order.
  void add_section(const std::string& path, const std::vector<std::string>& known);

  /// In the order in which they were asked for.
  const std::vector<KeyFact>& facts() const { return facts_; }
  /// As Section was given them; empty where there is no such section.
  std::vector<std::string> known(const std::string& section) const;

 private:
  struct Known {
    std::string section;
    std::vector<std::string> keys;
  };
  std::vector<KeyFact> facts_;
  std::vector<Known> sections_;
};

}  // namespace tiltfeed::config
