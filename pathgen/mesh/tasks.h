#pragma once
// How threads share the work on a mesh.

#include <atomic>
#include <cstddef>

namespace tiltfeed::pathgen {

/// Facets or vertices that one task takes at least: some ten to hundred microseconds of work.
inline constexpr std::size_t kGrain = 4096;
inline constexpr auto kRelaxed = std::memory_order_relaxed;

}  // namespace tiltfeed::pathgen
