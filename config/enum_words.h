#pragma once
// The words that the keys of a job file may have and what each means, for its reader and for its description.

#include <initializer_list>

#include "config/section.h"
#include "pathgen/options/plan_options.h"

namespace tiltfeed::config {

template <class E>
using Words = std::initializer_list<EnumWord<E>>;

inline constexpr Words<pathgen::CutterType> kCutterWords = {{"ball", pathgen::CutterType::kBall},
                                                            {"bull_nose", pathgen::CutterType::kBullNose},
                                                            {"flat", pathgen::CutterType::kFlat},
                                                            {"taper_ball", pathgen::CutterType::kTaperBall}};
inline constexpr Words<pathgen::AxisMode> kModeWords = {
    {"fixed", pathgen::AxisMode::kFixed}, {"point", pathgen::AxisMode::kPoint},
    {"line", pathgen::AxisMode::kLine},   {"circle", pathgen::AxisMode::kCircle},
    {"free", pathgen::AxisMode::kFree},   {"indexed", pathgen::AxisMode::kIndexed}};
inline constexpr Words<pathgen::Sense> kSenseWords = {{"outward", pathgen::Sense::kOutward},
                                                      {"inward", pathgen::Sense::kInward}};
inline constexpr Words<pathgen::PatternKind> kKindWords = {
    {"raster", pathgen::PatternKind::kRaster}, {"z_level", pathgen::PatternKind::kZLevel},
    {"split", pathgen::PatternKind::kSplit},   {"contour", pathgen::PatternKind::kContour},
    {"spiral", pathgen::PatternKind::kSpiral}, {"rough", pathgen::PatternKind::kRough},
    {"pencil", pathgen::PatternKind::kPencil}};
inline constexpr Words<pathgen::Along> kAlongWords = {{"x", pathgen::Along::kX}, {"y", pathgen::Along::kY}};
inline constexpr Words<pathgen::Direction> kDirectionWords = {{"one_way", pathgen::Direction::kOneWay},
                                                              {"zigzag", pathgen::Direction::kZigzag}};
inline constexpr Words<pathgen::StepMeasure> kMeasureWords = {{"flat", pathgen::StepMeasure::kFlat},
                                                              {"surface", pathgen::StepMeasure::kSurface},
                                                              {"scallop", pathgen::StepMeasure::kScallop},
                                                              {"ridge", pathgen::StepMeasure::kRidge}};
/// Values of Pattern::climb.
inline constexpr Words<bool> kMillingWords = {{"climb", true}, {"conventional", false}};
inline constexpr Words<pathgen::Reaction> kReactionWords = {{"trim", pathgen::Reaction::kTrim},
                                                            {"retract", pathgen::Reaction::kRetract},
                                                            {"tilt", pathgen::Reaction::kTilt},
                                                            {"report", pathgen::Reaction::kReport}};

/// The word of a value. Requires: `words` has one for it.
template <class E>
const char* word(Words<E> words, E value) {
  const EnumWord<E>* choice = words.begin();
  while (choice->value != value) ++choice;
  return choice->word;
}

}  // namespace tiltfeed::config
