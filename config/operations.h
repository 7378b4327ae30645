#pragma once
// The operations of a job's text, each as the text of a job that it is by itself.

#include <string>
#include <vector>

#include "config/section.h"
#include "config/yaml_tree.h"

namespace tiltfeed::config {

inline constexpr std::size_t kMostOperations = 100;

/// One operation: what it states itself, and what the job says for all.
struct OperationTree {
  std::string name;  ///< empty: the job has no list of operations, and is one
  YamlNode tree;
};

/// In the order of the list. A section that an operation states stands in place of the job's own section as a
/// whole; of the section program it stands in place key by key. A job without a list is one operation.
/// Property: no tree has the key `operations`. Problems: an unknown key, a name that is missing, wrong or
/// there twice.
std::vector<OperationTree> operation_trees(const YamlNode& tree, const Section& root);

}  // namespace tiltfeed::config
