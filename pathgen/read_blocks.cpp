#include "pathgen/read_blocks.h"

#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>

namespace tiltfeed {

namespace {

constexpr std::uint64_t kBlock = 1 << 20;

}  // namespace

std::optional<std::uint64_t> read_blocks(int fd, char* buffer, std::uint64_t size) {
  std::atomic<std::uint64_t> end = size;
  std::atomic<int> error = 0;
  tbb::parallel_for(std::uint64_t{0}, (size + kBlock - 1) / kBlock, [&](std::uint64_t b) {
    const std::uint64_t last = std::min(size, (b + 1) * kBlock);
    for (std::uint64_t at = b * kBlock; at < last;) {
      const ssize_t got = ::pread(fd, buffer + at, last - at, static_cast<off_t>(at));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) error = errno;
      if (got <= 0) {  // it is shorter than it was
        for (std::uint64_t known = end; at < known && !end.compare_exchange_weak(known, at);) {
        }
        return;
      }
      at += static_cast<std::uint64_t>(got);
    }
  });
  errno = error;
  return error == 0 ? std::optional(end.load()) : std::nullopt;
}

}  // namespace tiltfeed
