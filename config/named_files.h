#pragma once
// Which files a job's text names besides its part and its machine: a job of somebody else may name any.

#include <string>
#include <vector>

#include "config/yaml_tree.h"

namespace tiltfeed::config {

struct NamedFileKey {
  std::string key;  ///< "cutter.library", "operations[2].cutter.library", "fixtures[1].stl", "blank.file"
  const YamlNode* node = nullptr;  ///< its value, in the tree
};

/// Each such key, whatever its value is, in the order above. The file is not looked for.
std::vector<NamedFileKey> files_named_in(const YamlNode& job);

}  // namespace tiltfeed::config
