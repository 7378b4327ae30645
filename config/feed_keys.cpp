#include <algorithm>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>

#include "config/job.h"
#include "config/job_keys.h"
#include "config/key_ranges.h"

namespace tiltfeed::config {
namespace {

constexpr double kUsualLowest = 0.2;  // feed where the engagement sets it, of the job's own

/// What the tool's cutting data say of chips: the feed of a tooth and the thickest chip, times teeth and
/// speed.
struct ToothLimits {
  double highest = 0.0, chip = 0.0;  ///< mm/min; 0: not stated
};

ToothLimits tooth_limits(const Section& root, const CutterChoice& choice, double rpm) {
  const CuttingData* data = choice.data;
  if (data == nullptr || (data->highest_tooth == 0.0 && data->largest_chip == 0.0)) return {};
  if (rpm == 0.0)
    root.complain("feeds", "missing key spindle_rpm, by which the tool's cutting data for " +
                               quoted(choice.material) + " bound the chip");
  const double teeth = choice.tool->flutes * rpm;
  return {std::min(data->highest_tooth * teeth, kCuttingFeed.max), data->largest_chip * teeth};
}

/// Between which feeds cuts may be, about the job's own.
FeedRange read_feed_range(const Section& feeds, Feed cut, const ToothLimits& tooth) {
  const double own = cut.mm_per_min();
  FeedRange range;
  // What is on the wrong side of the job's own feed is that feed: operations share a section, as they like.
  range.highest = Feed::from_mm_per_min(
      std::max(own, feeds.number("highest_mm_per_min", kCuttingFeed, std::max(own, tooth.highest))));
  range.lowest = Feed::from_mm_per_min(
      std::min(own, feeds.number("lowest_mm_per_min", kCuttingFeed, kUsualLowest * own)));
  range.load = 0.01 * feeds.number("load_percent", {10.0, 100.0}, 100.0);
  range.largest_chip = tooth.chip;
  range.change = 0.01 * feeds.number("change_percent_per_mm", {0.0, 1000.0}, 0.0);
  return range;
}

}  // namespace

void read_feeds(const Section& root, const CutterChoice& choice, Job& job) {
  const std::initializer_list<const char*> keys = {
      "cut_mm_per_min",    "plunge_mm_per_min", "spindle_rpm",          "highest_mm_per_min",
      "lowest_mm_per_min", "load_percent",      "change_percent_per_mm"};
  const bool by_material = !choice.material.empty();
  const Section feeds = by_material ? root.optional_section("feeds", keys) : root.section("feeds", keys);
  const CuttingData* data = choice.data;
  if (data != nullptr && !root.has("feeds"))
    for (const auto& [key, value] :
         {std::pair{"cut_mm_per_min", data->cut_feed}, std::pair{"plunge_mm_per_min", data->plunge_feed}})
      if (value == 0.0)
        root.complain("feeds", std::string("missing key ") + key + ", which the tool's cutting data for " +
                                   quoted(choice.material) + " do not state either");
  const auto feed = [&](const char* key, double usual) {
    if (by_material && data == nullptr)  // the library is not read, or has none, which is said elsewhere
      return Feed::from_mm_per_min(feeds.optional_number(key, kCuttingFeed).value_or(kCuttingFeed.max));
    return Feed::from_mm_per_min(
        feeds.number(key, kCuttingFeed, usual > 0.0 ? std::optional(usual) : std::nullopt));
  };
  job.plan.cut_feed = feed("cut_mm_per_min", data == nullptr ? 0.0 : data->cut_feed);
  job.plan.plunge_feed = feed("plunge_mm_per_min", data == nullptr ? 0.0 : data->plunge_feed);
  job.spindle_rpm = feeds.number("spindle_rpm", {0.0, 200'000.0}, data == nullptr ? 0.0 : data->spindle_rpm);
  job.feeds = read_feed_range(feeds, job.plan.cut_feed, tooth_limits(root, choice, job.spindle_rpm));
}

}  // namespace tiltfeed::config
