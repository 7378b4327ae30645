#pragma once
// One value of a settings file changed where it stands: remarks, order and everything else stay as they are.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::config {

struct YamlEdit {
  std::string path;                  ///< as in messages: "cutter.holder[1].length_mm"
  std::optional<std::string> value;  ///< one line of YAML; nothing: the key is taken out
};

/// The keys of a section in the order in which they belong; empty: unknown.
using KeyOrder = std::function<std::vector<std::string>(const std::string& section)>;

/// Properties: the result reads as the text did, but for this value; no remark is lost but those inside a
/// block that becomes one line. A key that is taken out stays as a remark where it has a line of its own, and
/// comes back there. A new key stands behind those that belong before it; its section is made if need be.
/// Errors: kInput: the text is no YAML, the value is none, there is no such place, or it is written in a way
/// that only a person can change.
Result<std::string> edited(const std::string& text, const YamlEdit& edit, const KeyOrder& order);

/// A word as it may stand as a value: in double quotes.
std::string quoted_text(const std::string& text);

/// The values at these paths as they are written; empty where there is none. Requires: as edited().
Result<std::vector<std::string>> value_texts(const std::string& text, const std::vector<std::string>& paths);

}  // namespace tiltfeed::config
