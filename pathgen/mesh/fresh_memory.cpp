#include "pathgen/mesh/fresh_memory.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace tiltfeed::pathgen {

namespace {

constexpr std::size_t kPage = 4096;
/// That one task touches at least: some hundred microseconds of the system's work.
constexpr std::size_t kBlock = 256 * kPage;

}  // namespace

void touch_pages(void* memory, std::size_t bytes) {
  auto* const begin = static_cast<volatile std::byte*>(memory);
  tbb::parallel_for(std::size_t{0}, (bytes + kBlock - 1) / kBlock, [&](std::size_t b) {
    for (std::size_t at = b * kBlock; at < std::min(bytes, (b + 1) * kBlock); at += kPage)
      begin[at] = std::byte{0};
  });
}

}  // namespace tiltfeed::pathgen
