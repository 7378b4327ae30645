#pragma once
// The keys of a job: what its reader asks for, and what the commented example says of each.

#include <string>
#include <vector>

#include "config/key_log.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::config {

/// config/jobs/example.yaml, as it was when the program was built.
const char* example_job_text();

/// The keys that the reader asks for in this text, in its order: what one word makes of the others (the axis
/// mode, the cutter's type, the pattern's kind) is in it, and so are keys of sections that are absent.
/// Wrong values are no error here. Errors: kInput: the text is no YAML.
Result<KeyLog> job_keys(const std::string& text);

/// A key of a commented file, in its order; those that stand there as a remark, too.
struct DescribedKey {
  std::string path, value, words;  ///< dotted; as it is written there; what is said of it
};
std::vector<DescribedKey> described_keys(const std::string& text);

/// What the example says of a key or section, in one line; numbers in brackets are left out of the path.
/// Empty where it says nothing.
std::string key_help(const std::string& path);

}  // namespace tiltfeed::config
