#pragma once
// Text that others have said: what comes from a wire is no text before it has been made one.

#include <string>
#include <string_view>

namespace tiltfeed::daemon {

/// For messages: printable ASCII, at most 80 bytes; every other byte becomes '?'.
std::string wire_text(std::string_view bytes);
/// Valid UTF-8 as it is; each byte that is no part of it becomes '?'.
std::string valid_text(std::string_view text);

}  // namespace tiltfeed::daemon
