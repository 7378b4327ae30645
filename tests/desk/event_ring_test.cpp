#include "desk/http/event_ring.h"

#include <gtest/gtest.h>

#include <random>

namespace tiltfeed::desk {
namespace {

std::string all_of(const EventRing& ring, EventPlace place) {
  std::string text(EventRing::kBytes * 2, '\0');
  text.resize(ring.read(place, text.data(), text.size()));
  return text;
}

TEST(EventRing, gives_each_event_once_and_in_order_in_pieces_of_any_size) {
  std::mt19937 random(1);
  EventRing ring;
  EventPlace place = ring.start_after(false, 0);
  std::string expected, got;
  for (int i = 1; i <= 2000; ++i) {
    const std::string data = "{\"n\": " + std::to_string(random() % 1000000) + "}";
    ring.add("part", data);
    expected += "id: " + std::to_string(i) + "\nevent: part\ndata: " + data + "\n\n";
    while (random() % 4 != 0 && ring.has(place)) {
      char piece[64];
      got.append(piece, ring.read(place, piece, 1 + random() % sizeof piece));
    }
    ASSERT_FALSE(ring.lost(place));
  }
  got += all_of(ring, place);
  EXPECT_EQ(got, expected);
}

TEST(EventRing, goes_on_after_the_last_event_that_a_listener_had) {
  EventRing ring;
  for (const char* data : {"1", "2", "3"}) ring.add("x", data);
  EXPECT_EQ(all_of(ring, ring.start_after(true, 1)),
            "id: 2\nevent: x\ndata: 2\n\nid: 3\nevent: x\ndata: 3\n\n");
  EXPECT_EQ(all_of(ring, ring.start_after(true, 3)), "");
  EXPECT_EQ(all_of(ring, ring.start_after(false, 0)), "");
  // A number of another life of the server.
  EXPECT_EQ(all_of(ring, ring.start_after(true, 77)), "");
  EXPECT_EQ(all_of(ring, ring.start_after(true, ~0ull)), "");
}

TEST(EventRing, tells_a_listener_that_fell_out_of_it) {
  EventRing ring;
  const EventPlace slow = ring.start_after(false, 0);
  const std::string large(EventRing::kBytes / 2, 'x');
  ring.add("x", large);
  EXPECT_FALSE(ring.lost(slow));
  ring.add("x", large);
  EXPECT_TRUE(ring.lost(slow));
  // One that is larger than the ring is still there for who keeps up.
  const EventPlace quick = ring.start_after(false, 0);
  ring.add("x", large + large + large);
  EXPECT_FALSE(ring.lost(quick));
  EXPECT_TRUE(ring.has(quick));
}

}  // namespace
}  // namespace tiltfeed::desk
