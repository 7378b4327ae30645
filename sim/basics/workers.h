#pragma once
// Tasks on several threads, in no particular order.

#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace tiltfeed::sim {

/// Runs task(0..count-1) on `threads` threads.
template <class Task>
void in_parallel(std::size_t count, int threads, const Task& task) {
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) task(i);
  };
  std::vector<std::thread> others;
  for (int i = 1; i < threads && static_cast<std::size_t>(i) < count; ++i) others.emplace_back(work);
  work();
  for (std::thread& other : others) other.join();
}

}  // namespace tiltfeed::sim
