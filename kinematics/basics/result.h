#pragma once
// Every fallible function of the project returns Result<T>; nothing of ours throws.

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace tiltfeed {

/// What kind of failure it is; the message says what, where and what to do.
enum class Code {
  kUsage,        ///< wrong command line
  kInput,        ///< a file's text or value is wrong
  kMesh,         ///< the part cannot be planned safely
  kUnreachable,  ///< no joint values give this pose
  kLimit,        ///< a travel, rotary or size limit is broken
  kGouge,        ///< the tool would cut into the part
  kLink,         ///< the wire, or the controller behind it
  kIo,           ///< a file cannot be read or written
  kCancelled,    ///< stopped by the user; nothing was written
};

/// `message` has the value, the limit, the place (file:line:column, facet, block) and the remedy.
struct Error {
  Code code = Code::kInput;
  std::string message;
};

template <class T>
using Result = tl::expected<T, Error>;

/// `return fail(Code::kInput, "...")` in any function that returns a Result.
inline tl::unexpected<Error> fail(Code code, std::string message) {
  return tl::unexpected<Error>(Error{code, std::move(message)});
}

}  // namespace tiltfeed
