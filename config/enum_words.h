#pragma once
// The words that the keys of a job file may have and what each means, for its reader and for its description.

#include <initializer_list>

#include "config/section.h"
#include "pathgen/options/plan_options.h"

namespace tiltfeed {

template <class E>
using Words = std::initializer_list<EnumWord<E>>;

inline constexpr Words<CutterType> kCutterWords = {{"ball", CutterType::kBall},
                                                   {"bull_nose", CutterType::kBullNose},
                                                   {"flat", CutterType::kFlat},
                                                   {"taper_ball", CutterType::kTaperBall}};
inline constexpr Words<AxisMode> kModeWords = {{"fixed", AxisMode::kFixed}, {"point", AxisMode::kPoint},
                                               {"line", AxisMode::kLine},   {"circle", AxisMode::kCircle},
                                               {"free", AxisMode::kFree},   {"indexed", AxisMode::kIndexed}};
inline constexpr Words<Sense> kSenseWords = {{"outward", Sense::kOutward}, {"inward", Sense::kInward}};
inline constexpr Words<PatternKind> kKindWords = {
    {"raster", PatternKind::kRaster},   {"z_level", PatternKind::kZLevel}, {"split", PatternKind::kSplit},
    {"contour", PatternKind::kContour}, {"spiral", PatternKind::kSpiral},  {"rough", PatternKind::kRough}};
inline constexpr Words<Along> kAlongWords = {{"x", Along::kX}, {"y", Along::kY}};
inline constexpr Words<Direction> kDirectionWords = {{"one_way", Direction::kOneWay},
                                                     {"zigzag", Direction::kZigzag}};
inline constexpr Words<StepMeasure> kMeasureWords = {
    {"flat", StepMeasure::kFlat}, {"surface", StepMeasure::kSurface}, {"scallop", StepMeasure::kScallop}};
/// Values of Pattern::climb.
inline constexpr Words<bool> kMillingWords = {{"climb", true}, {"conventional", false}};
inline constexpr Words<Reaction> kReactionWords = {
    {"trim", Reaction::kTrim}, {"retract", Reaction::kRetract}, {"report", Reaction::kReport}};

/// The word of a value. Requires: `words` has one for it.
template <class E>
const char* word(Words<E> words, E value) {
  const EnumWord<E>* choice = words.begin();
  while (choice->value != value) ++choice;
  return choice->word;
}

}  // namespace tiltfeed
