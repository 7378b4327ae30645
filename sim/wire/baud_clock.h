#pragma once
// The speed of a serial line, in real time: so many bytes have passed since the line became busy.

#include <algorithm>
#include <cstddef>

namespace tiltfeed::sim {

class BaudClock {
 public:
  /// `byte_time` in s; 0: as fast as the system.
  explicit BaudClock(double byte_time) : byte_time_(byte_time) {}

  bool paced() const { return byte_time_ > 0.0; }
  /// Bytes that have arrived by `now` at most, if there are any. Requires: now never goes back.
  std::size_t allowed(double now, std::size_t most) {
    if (!paced()) return most;
    if (!busy_) {
      busy_ = true;
      free_at_ = std::max(free_at_, now);
    }
    const double span = now - free_at_;
    return span <= 0.0 ? 0 : std::min(most, static_cast<std::size_t>(span / byte_time_));
  }
  void passed(std::size_t count) {
    if (bytes_ == 0) first_ = free_at_;
    free_at_ += static_cast<double>(count) * byte_time_;
    bytes_ += count;
    last_ = free_at_;
  }
  /// Nothing waits any more.
  void idle() { busy_ = false; }
  /// Of the time from the first byte to the last, the share in which bytes passed.
  double use() const {
    const double span = last_ - first_;
    return span > 0.0 ? static_cast<double>(bytes_) * byte_time_ / span : 0.0;
  }
  std::size_t bytes() const { return bytes_; }

 private:
  double byte_time_, free_at_ = 0.0, first_ = 0.0, last_ = 0.0;
  std::size_t bytes_ = 0;
  bool busy_ = false;
};

}  // namespace tiltfeed::sim
