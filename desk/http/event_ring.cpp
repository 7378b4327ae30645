#include "desk/http/event_ring.h"

#include <algorithm>
#include <cstring>

namespace tiltfeed::desk {

void EventRing::push(std::string text) {
  bytes_ += text.size();
  events_.push_back(std::move(text));
  while (bytes_ > kBytes && events_.size() > 1) {
    bytes_ -= events_.front().size();
    events_.pop_front();
    ++first_;
  }
}

void EventRing::add(const std::string& name, const std::string& data) {
  push("id: " + std::to_string(first_ + events_.size()) + "\nevent: " + name + "\ndata: " + data + "\n\n");
}

void EventRing::beat() { push(":\n\n"); }

EventPlace EventRing::start_after(bool known, std::uint64_t last) const {
  const std::uint64_t end = first_ + events_.size();
  if (known && last + 1 >= first_ && last < end) return {last + 1, 0};
  return {end, 0};
}

std::size_t EventRing::read(EventPlace& place, char* out, std::size_t most) const {
  std::size_t copied = 0;
  while (copied < most && has(place)) {
    const std::string& text = events_[static_cast<std::size_t>(place.event - first_)];
    const std::size_t count = std::min(most - copied, text.size() - place.byte);
    std::memcpy(out + copied, text.data() + place.byte, count);
    copied += count;
    place.byte += count;
    if (place.byte == text.size()) place = {place.event + 1, 0};
  }
  return copied;
}

}  // namespace tiltfeed::desk
