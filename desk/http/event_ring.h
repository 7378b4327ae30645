#pragma once
// The last events, for every client that listens: text of server-sent events, numbered.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>

namespace tiltfeed::desk {

/// Where a listener is.
struct EventPlace {
  std::uint64_t event = 0;  ///< the next one that it gets
  std::size_t byte = 0;     ///< so much of it has been read
};

/// Holds `kBytes` of text at most. A listener that has fallen out of it is told so, and fetches everything
/// anew. Events are never merged; numbers rise by one.
class EventRing {
 public:
  static constexpr std::size_t kBytes = 64 * 1024;

  /// `data` is one line (JSON). An event that alone is over kBytes replaces all others.
  void add(const std::string& name, const std::string& data);
  /// A comment that keeps connections alive; it has a place, but no number of its own in the text.
  void beat();

  /// Where a listener starts that has had `last`; without it, or where what follows it is gone: at the end.
  EventPlace start_after(bool known, std::uint64_t last) const;
  bool has(const EventPlace& place) const { return place.event < first_ + events_.size(); }
  bool lost(const EventPlace& place) const { return place.event < first_; }
  /// Copies what there is, `most` bytes at most; returns how many. Requires: not lost.
  std::size_t read(EventPlace& place, char* out, std::size_t most) const;

 private:
  void push(std::string text);

  std::deque<std::string> events_;
  std::uint64_t first_ = 1;  ///< number of events_[0]
  std::size_t bytes_ = 0;
};

}  // namespace tiltfeed::desk
