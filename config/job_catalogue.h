#pragma once
// The keys of a job: what its reader asks for, and what the commented example says of each.

#include <string>
#include <vector>

#include "config/key_log.h"
#include "config/yaml_edit.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::config {

/// config/jobs/example.yaml, as it was when the program was built.
const char* example_job_text();

/// The keys that the reader asks for in this text, in its order: what one word makes of the others (the axis
/// mode, the cutter's type, the pattern's kind) is in it, and so are keys of sections that are absent.
/// Wrong values are no error here. Errors: kInput: the text is no YAML.
Result<KeyLog> job_keys(const std::string& text);

/// One operation of a job's text, and its keys as job_keys() has them: of what it states itself and of what
/// the job says for all.
struct OperationKeys {
  std::string name;              ///< empty: the job has no list of operations, and is one
  std::size_t number = 0;        ///< in the list, from 1; 0: there is none
  std::vector<std::string> own;  ///< what it states: sections, "tolerance_mm", "program.tool"
  KeyLog log;                    ///< paths as those of a job of one operation

  /// It states this section or key, or the one around it.
  bool has_own(const std::string& path) const;
  /// Where a key of its stands in the text, or would be put: "operations[2].cutter.type" or "cutter.type".
  std::string place(const std::string& path) const;
};
/// In the order of the list. Errors: as job_keys().
Result<std::vector<OperationKeys>> operation_keys(const std::string& text);
/// The keys of the text, by their places in it, that no operation may have as it stands.
Result<std::vector<std::string>> unused_keys(const std::string& text);
/// The order of keys for edited(): of operations, too.
Result<KeyOrder> key_order(const std::string& text);

/// A key of a commented file, in its order; those that stand there as a remark, too.
struct DescribedKey {
  std::string path, value, words;  ///< dotted; as it is written there; what is said of it
};
std::vector<DescribedKey> described_keys(const std::string& text);

/// What the example says of a key or section, in one line; numbers in brackets are left out of the path.
/// Empty where it says nothing.
std::string key_help(const std::string& path);

}  // namespace tiltfeed::config
