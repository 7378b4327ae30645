#pragma once
// YAML text as a plain tree, every node with its place. Only the part of YAML that a settings file needs:
// one document of maps, lists and scalars. Anchors, aliases, tags, merge keys, duplicate keys, tabs, control
// characters and anything over 1 MiB are errors here, so no later stage meets them.

#include <cstddef>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::config {

/// Far above any hand-written file (the commented example has 6 KiB), far below what could hurt.
inline constexpr std::size_t kMaxConfigBytes = 1u << 20;

/// 1-based; columns count bytes, as compilers do.
struct TextPlace {
  int line = 1;
  int column = 1;
};

/// "file:line:column".
std::string to_string(const std::string& file, TextPlace place);

enum class YamlKind { kNothing, kScalar, kList, kMap };

struct YamlKey {
  std::string text;
  TextPlace place;
};

struct YamlNode {
  YamlKind kind = YamlKind::kNothing;
  TextPlace place;              ///< where the value starts; of its key when the value is nothing
  std::string text;             ///< of a scalar, quotes and escapes resolved
  bool plain = true;            ///< a scalar without quotes
  std::vector<YamlKey> keys;    ///< of a map, all different, in file order
  std::vector<YamlNode> items;  ///< of a list; of a map: items[i] is the value of keys[i]
};

/// The file's bytes. Errors: kIo with the reason; kInput when it is over kMaxConfigBytes.
Result<std::string> read_config_text(const std::string& path);

/// The one document in `text`. `file` goes into messages only.
/// Errors: kInput as file:line:column and what was expected.
Result<YamlNode> parse_yaml(const std::string& text, const std::string& file);

/// What a node is, for messages: "found 'abc'", "found a list of 3".
std::string found(const YamlNode& node);

/// Text of a file as it may stand in a message: at most 60 bytes, nothing unprintable, in single quotes.
std::string quoted(const std::string& text);

}  // namespace tiltfeed::config
