#pragma once
// A file into memory, on all cores.

#include <cstdint>
#include <optional>

namespace tiltfeed {

/// Reads up to `size` bytes from the file's start, blocks side by side: copying is the most of it. How many
/// there are before the file ends; nothing, and errno, if it cannot be read.
std::optional<std::uint64_t> read_blocks(int fd, char* buffer, std::uint64_t size);

}  // namespace tiltfeed
