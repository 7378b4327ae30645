#pragma once
// The last lines that passed the wire, each way, for the report after a failure.

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>

#include "daemon/stream/stream.h"

namespace tiltfeed::daemon {

/// Bytes become lines at LF; a request or reply of a message link is one line, shown as hexadecimal words.
class WireLog {
 public:
  static constexpr std::size_t kLines = 100;    ///< kept each way
  static constexpr std::size_t kLongest = 600;  ///< bytes kept of one line

  explicit WireLog(bool messages) : messages_(messages) {}
  /// StreamHooks::traffic.
  void take(Way way, std::string_view bytes, Time at);
  /// Oldest first, both ways in the order in which they ended: "12.345678 > G1X1".
  std::string text() const;

 private:
  struct Entry {
    std::uint64_t order = 0;
    Time at{};
    std::string text;
  };
  struct Side {
    std::deque<Entry> lines;
    std::string open;
  };
  void close(Side& side, Time at);

  bool messages_;
  Side sides_[2];
  std::uint64_t order_ = 0;
};

}  // namespace tiltfeed::daemon
