#pragma once
// Tables of bad settings: a good text with one piece replaced, the place where the error must be, and a part
// of what it must say.

#include <gtest/gtest.h>

#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed {

struct BadText {
  const char* from;  ///< first occurrence is replaced; "" replaces the whole text
  const char* to;
  const char* place;    ///< "line:column"
  const char* message;  ///< a part of the message
};

inline std::string replaced(const std::string& text, const std::string& from, const std::string& to) {
  if (from.empty()) return to;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "the table's piece '" << from << "' is not in the text";
  if (at == std::string::npos) return text;
  return text.substr(0, at) + to + text.substr(at + from.size());
}

/// `result` must fail with kInput at file:place, and the message must have the part.
template <class T>
void expect_bad(const Result<T>& result, const std::string& file, const BadText& bad) {
  SCOPED_TRACE(std::string("'") + bad.from + "' -> '" + bad.to + "'");
  ASSERT_FALSE(result.has_value()) << "accepted";
  EXPECT_EQ(result.error().code, Code::kInput);
  const std::string& message = result.error().message;
  const std::string start = file + ":" + bad.place + ": ";
  EXPECT_EQ(message.substr(0, start.size()), start) << message;
  EXPECT_NE(message.find(bad.message, start.size()), std::string::npos) << message;
}

}  // namespace tiltfeed
