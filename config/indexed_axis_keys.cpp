#include "config/description.h"
#include "config/enum_words.h"
#include "config/job_keys.h"
#include "pathgen/indexed/index_order.h"

namespace tiltfeed::config {
namespace {

constexpr Range kCoverage{50.0, 100.0};          // percent
constexpr Range kGain{0.0, 50.0};                // percent
constexpr Range kSteepest = between(0.0, 90.0);  // degrees

}  // namespace

void read_indexed_axis(const Section& root, const Section& axis, pathgen::IndexedAxis& indexed,
                       const pathgen::Cutter& cutter) {
  if (cutter.type != pathgen::CutterType::kBall && cutter.type != pathgen::CutterType::kTaperBall)
    root.complain("cutter", "the type " + std::string(word(kCutterWords, cutter.type)) +
                                " touches the part at other places for other tool axes, which the mode "
                                "indexed cannot weigh; use ball or taper_ball");
  indexed.most_directions = static_cast<std::uint32_t>(axis.integer(
      "most_directions", 1, pathgen::kMostDirections, static_cast<int>(indexed.most_directions)));
  indexed.coverage = axis.number("coverage_percent", kCoverage, 100.0 * indexed.coverage) / 100.0;
  indexed.least_gain = axis.number("least_gain_percent", kGain, 100.0 * indexed.least_gain) / 100.0;
  indexed.steepest =
      Angle::from_degrees(axis.number("steepest_deg", kSteepest, tidy(indexed.steepest.degrees())));
}

}  // namespace tiltfeed::config
