// The section wire.drive: the registers of a plain Modbus drive.

#include <string>
#include <vector>

#include "config/description.h"
#include "config/key_ranges.h"
#include "config/link_profile.h"
#include "config/section.h"

namespace tiltfeed::config {

namespace {

constexpr int kHighestWord = 0xFFFF;
constexpr int kMostWritten = 123;  // registers of one FC16
constexpr std::array<const char*, 5> kAxisNames{"x", "y", "z", "tilt", "rotary"};
constexpr int kLinearAxes = 3;

const char* counts_key(int axis) { return axis < kLinearAxes ? "counts_per_mm" : "counts_per_deg"; }

/// Each word of the write has one meaning.
class Places {
 public:
  Places(const Section& drive, int words) : drive_(drive), taken_(static_cast<std::size_t>(words), false) {
    taken_.back() = true;  // the trigger
  }
  void take(const char* key, int word, int size) {
    for (int i = word; word >= 0 && i < word + size; ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (at >= taken_.size() || taken_[at])
        return drive_.complain(
            key, "word " + std::to_string(i) + " is the trigger, another value's, or beyond the last one");
      taken_[at] = true;
    }
  }

 private:
  const Section& drive_;
  std::vector<bool> taken_;
};

}  // namespace

DriveMap read_drive(const Section& wire) {
  const Section drive = wire.optional_section("drive", {"block",
                                                        "words",
                                                        "low_word_first",
                                                        "mode_word",
                                                        "mode",
                                                        "x",
                                                        "y",
                                                        "z",
                                                        "tilt",
                                                        "rotary",
                                                        "feed_word",
                                                        "feed_counts_per_mm_per_min",
                                                        "rapid_mm_per_min",
                                                        "acceleration_word",
                                                        "acceleration",
                                                        "deceleration_word",
                                                        "deceleration",
                                                        "trigger",
                                                        "status",
                                                        "moving_mask",
                                                        "moving_value",
                                                        "fault_mask",
                                                        "settle_ms",
                                                        "stop",
                                                        "stop_value"});
  DriveMap map;
  const auto address = [&](const char* key, std::uint16_t usual) {
    return static_cast<std::uint16_t>(drive.integer(key, 0, kHighestAddress, usual));
  };
  const auto value = [&](const char* key, int usual) { return drive.integer(key, 0, kHighestWord, usual); };
  const auto place = [&](const char* key, int usual) { return drive.integer(key, -1, kMostWritten, usual); };
  map.block = address("block", map.block);
  map.words = drive.integer("words", 3, kMostWritten, map.words);
  Places places(drive, map.words);
  map.low_word_first = drive.flag("low_word_first", map.low_word_first);
  map.mode_word = place("mode_word", map.mode_word);
  map.mode = value("mode", map.mode);
  bool moves = false;
  for (int i = 0; i < 5; ++i) {
    DriveAxis& axis = map.axes[static_cast<std::size_t>(i)];
    const char* const name = kAxisNames[static_cast<std::size_t>(i)];
    const Section keys = drive.optional_section(name, {"word", counts_key(i)});
    axis.word = keys.integer("word", -1, kMostWritten, axis.word);
    axis.counts = keys.number(counts_key(i), {-1e6, 1e6}, axis.counts);
    if (axis.counts == 0.0) keys.complain(counts_key(i), "must not be 0");
    places.take(name, axis.word, 2);
    moves = moves || axis.word >= 0;
  }
  if (!moves) drive.complain("x", "has no word, nor has another axis: the drive would move nothing");
  map.feed_word = place("feed_word", map.feed_word);
  map.feed_counts = drive.number("feed_counts_per_mm_per_min", above(0.0, 1e6), map.feed_counts);
  map.rapid = drive.number("rapid_mm_per_min", above(0.0, 1e6), map.rapid);
  map.acceleration_word = place("acceleration_word", map.acceleration_word);
  map.acceleration = value("acceleration", map.acceleration);
  map.deceleration_word = place("deceleration_word", map.deceleration_word);
  map.deceleration = value("deceleration", map.deceleration);
  places.take("mode_word", map.mode_word, 1);
  places.take("feed_word", map.feed_word, 1);
  places.take("acceleration_word", map.acceleration_word, 1);
  places.take("deceleration_word", map.deceleration_word, 1);
  map.trigger = value("trigger", map.trigger);
  map.status = address("status", map.status);
  map.moving_mask = drive.integer("moving_mask", 1, kHighestWord, map.moving_mask);
  map.moving_value = value("moving_value", map.moving_value);
  if ((map.moving_value & ~map.moving_mask) != 0)
    drive.complain("moving_value", "has bits that moving_mask has not");
  map.fault_mask = value("fault_mask", map.fault_mask);
  map.settle = drive.number("settle_ms", {0.0, 10000.0}, map.settle * 1000.0) / 1000.0;
  map.stop = address("stop", map.stop);
  map.stop_value = value("stop_value", map.stop_value);
  return map;
}

void describe(const DriveMap& drive, Description& out) {
  out.add("wire.drive.block", static_cast<int>(drive.block));
  out.add("wire.drive.words", drive.words);
  out.add("wire.drive.low_word_first", drive.low_word_first);
  out.add("wire.drive.mode_word", drive.mode_word);
  out.add("wire.drive.mode", drive.mode);
  for (int i = 0; i < 5; ++i) {
    const std::string name = std::string("wire.drive.") + kAxisNames[static_cast<std::size_t>(i)] + ".";
    out.add(name + "word", drive.axes[static_cast<std::size_t>(i)].word);
    out.add(name + counts_key(i), drive.axes[static_cast<std::size_t>(i)].counts);
  }
  out.add("wire.drive.feed_word", drive.feed_word);
  out.add("wire.drive.feed_counts_per_mm_per_min", drive.feed_counts);
  out.add("wire.drive.rapid_mm_per_min", drive.rapid);
  out.add("wire.drive.acceleration_word", drive.acceleration_word);
  out.add("wire.drive.acceleration", drive.acceleration);
  out.add("wire.drive.deceleration_word", drive.deceleration_word);
  out.add("wire.drive.deceleration", drive.deceleration);
  out.add("wire.drive.trigger", drive.trigger);
  out.add("wire.drive.status", static_cast<int>(drive.status));
  out.add("wire.drive.moving_mask", drive.moving_mask);
  out.add("wire.drive.moving_value", drive.moving_value);
  out.add("wire.drive.fault_mask", drive.fault_mask);
  out.add("wire.drive.settle_ms", tidy(drive.settle * 1000.0));
  out.add("wire.drive.stop", static_cast<int>(drive.stop));
  out.add("wire.drive.stop_value", drive.stop_value);
}

}  // namespace tiltfeed::config
