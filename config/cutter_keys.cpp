#include "config/cutter_keys.h"

#include <algorithm>
#include <cmath>

#include "config/description.h"
#include "config/enum_words.h"

namespace tiltfeed::config {
namespace {

constexpr Range kDiameter = above(0.0, 500.0);  // mm
constexpr Range kLength = above(0.0, 2000.0);   // mm
constexpr Range kTaper = between(0.0, 60.0);    // degrees
constexpr std::size_t kMaxSteps = 100;          // of a holder; a slipped list is seen

/// Height above the tip from where the end is as wide as the cutting part, mm.
double end_height(const pathgen::Cutter& cutter) {
  switch (cutter.type) {
    case pathgen::CutterType::kTaperBall:  // where the cone touches the ball
      return cutter.radius() * (1.0 - std::sin(cutter.taper.radians()));
    default:
      return cutter.nose_radius();
  }
}

void read_end(const Section& section, pathgen::Cutter& cutter) {
  if (cutter.type == pathgen::CutterType::kBullNose) {
    cutter.corner_radius = section.number("corner_radius_mm", kDiameter);
    if (section.sound("corner_radius_mm") && section.sound("diameter_mm") &&
        cutter.corner_radius >= cutter.radius())
      section.complain("corner_radius_mm", exact_text(cutter.corner_radius) +
                                               " mm is not below the cutter's radius, " +
                                               exact_text(cutter.radius()) + " mm; write type: ball");
  } else {
    section.unused("corner_radius_mm",
                   "by the type " + std::string(word(kCutterWords, cutter.type)) + ", only by bull_nose");
  }
  if (cutter.type == pathgen::CutterType::kTaperBall)
    cutter.taper = Angle::from_degrees(section.number("taper_deg", kTaper));
  else
    section.unused("taper_deg",
                   "by the type " + std::string(word(kCutterWords, cutter.type)) + ", only by taper_ball");
}

/// Requires: all of the cutting part is given.
void check_lengths(const Section& section, const pathgen::Cutter& cutter) {
  const double end = end_height(cutter);
  const char* const end_key = cutter.cutting_length > 0.0 ? "cutting_length_mm" : "shank_length_mm";
  if (cutter.shank_length > cutter.length)
    section.complain("shank_length_mm", exact_text(cutter.shank_length) + " mm is over length_mm, " +
                                            exact_text(cutter.length) +
                                            " mm; the holder must start at or below the gauge line");
  if (cutter.cutting_end() < end)
    section.complain(end_key, exact_text(cutter.cutting_end()) +
                                  " mm is below the height of the cutter's rounded end, " +
                                  exact_text(tidy(end)) + " mm; expected a length from the tip");
  if (cutter.cutting_length > cutter.shank_length)
    section.complain("cutting_length_mm", exact_text(cutter.cutting_length) +
                                              " mm is over shank_length_mm, " +
                                              exact_text(cutter.shank_length) +
                                              " mm; the cutting part ends at or below the holder");
  const double top = 2.0 * cutter.cutting_top_radius();
  if (top > kDiameter.max)
    section.complain("taper_deg", "the cone is " + exact_text(tidy(top)) +
                                      " mm wide at the top of the cutting part; expected at most " +
                                      exact_text(kDiameter.max) + " mm, check cutting_length_mm");
}

/// Steps above the gauge line are those of the spindle nose.
std::vector<pathgen::HolderStep> read_holder(const Section& cutter) {
  std::vector<pathgen::HolderStep> steps;
  for (const Section& section :
       cutter.list("holder", {"diameter_mm", "upper_diameter_mm", "length_mm"}, kMaxSteps)) {
    pathgen::HolderStep step;
    step.lower_diameter = section.number("diameter_mm", kDiameter);
    step.upper_diameter = section.number("upper_diameter_mm", kDiameter, step.lower_diameter);
    step.length = section.number("length_mm", kLength);
    steps.push_back(step);
  }
  return steps;
}

}  // namespace

double smallest_radius(const pathgen::Cutter& cutter) {
  return cutter.nose_radius() > 0.0 ? std::min(cutter.nose_radius(), cutter.radius()) : cutter.radius();
}

pathgen::Cutter read_cutter_form(const Section& section) {
  pathgen::Cutter cutter;
  cutter.type = section.choice<pathgen::CutterType>("type", kCutterWords);
  cutter.diameter = section.number("diameter_mm", kDiameter);
  read_end(section, cutter);
  cutter.length = section.number("length_mm", kLength);
  cutter.shank_length = section.number("shank_length_mm", kLength);
  cutter.cutting_length = section.optional_number("cutting_length_mm", kLength).value_or(0.0);
  const bool taper = cutter.type == pathgen::CutterType::kTaperBall;
  const bool nose = cutter.type == pathgen::CutterType::kBullNose;
  // Of a value that is missing or wrong no other is wrong.
  const auto told = [&](const char* key) { return !section.has(key) || section.sound(key); };
  if (section.sound("type") && section.sound("diameter_mm") && section.sound("length_mm") &&
      section.sound("shank_length_mm") && told("cutting_length_mm") &&
      (!taper || section.sound("taper_deg")) && (!nose || section.sound("corner_radius_mm")))
    check_lengths(section, cutter);
  if (const auto diameter = section.optional_number("shank_diameter_mm", kDiameter)) {
    cutter.shank_diameter = *diameter;
    if (section.sound("shank_length_mm") && told("cutting_length_mm") &&
        cutter.cutting_end() == cutter.shank_length)
      section.complain(
          "shank_diameter_mm",
          "the cutting part goes up to the holder, so there is no shank; give cutting_length_mm, "
          "below shank_length_mm");
  }
  cutter.holder = read_holder(section);
  return cutter;
}

}  // namespace tiltfeed::config
