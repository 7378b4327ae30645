#pragma once
// CL text read from a string.

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "kinematics/cl_text/apt_file.h"

namespace tiltfeed {

inline Result<AptProgram> read_text(const std::string& text, const AptOptions& options = {}) {
  std::istringstream in(text);
  return read_apt(in, "p.cls", options);
}

/// The one operation of a text that must be right.
inline AptOperation only_operation(const std::string& text, const AptOptions& options = {}) {
  const auto program = read_text(text, options);
  EXPECT_TRUE(program) << program.error().message;
  if (!program || program->operations.size() != 1) return {};
  return program->operations.front();
}

}  // namespace tiltfeed
