#include "config/rotary_keys.h"

#include <cmath>
#include <limits>
#include <string_view>

#include "config/enum_words.h"
#include "config/key_ranges.h"

namespace tiltfeed::config {
namespace {

// Ranges: wide enough for any machine that people stand beside, narrow enough that a slipped digit or a metre
// typed as a millimetre is seen.
constexpr Range kTiltWord{-360.0, 360.0};                        // degrees; a tilt does not turn further
constexpr Range kRotaryWord{-1'000'000.0, 1'000'000.0};          // degrees
constexpr Range kAngularVelocity = above(0.0, 1'000'000.0);      // degrees/min
constexpr Range kAngularAcceleration = above(0.0, 1'000'000.0);  // degrees/s^2
constexpr Range kAngularJerk = above(0.0, 1e9);                  // degrees/s^3

/// Axes nearer to parallel than 1 degree, far below any nutating head, cannot aim the tool.
const double kMinInclination = Angle::from_degrees(1.0).radians();

constexpr std::initializer_list<const char*> kTiltKeys{"letter",
                                                       "direction",
                                                       "sign",
                                                       "zero_deg",
                                                       "word",
                                                       "continuous",
                                                       "min_deg",
                                                       "max_deg",
                                                       "velocity_deg_per_min",
                                                       "acceleration_deg_per_s2",
                                                       "jerk_deg_per_s3",
                                                       "prefer"};
constexpr std::initializer_list<const char*> kRotaryKeys{"letter",
                                                         "direction",
                                                         "sign",
                                                         "zero_deg",
                                                         "word",
                                                         "continuous",
                                                         "min_deg",
                                                         "max_deg",
                                                         "velocity_deg_per_min",
                                                         "acceleration_deg_per_s2",
                                                         "jerk_deg_per_s3"};

/// Letters that mean something else in RS274 programs.
constexpr std::string_view kTakenLetters = "DFGHIJKLMNOPQRSTXYZ";

constexpr Words<Structure> kStructureWords = {{"table-head", Structure::kTableHead},
                                              {"table-table", Structure::kTableTable},
                                              {"head-head", Structure::kHeadHead}};
constexpr Words<RotaryWord> kRotaryWords = {{"accumulate", RotaryWord::kAccumulate},
                                            {"shortest", RotaryWord::kShortest},
                                            {"signed", RotaryWord::kSigned}};
constexpr Words<int> kPreferWords = {{"positive", +1}, {"negative", -1}, {"quicker", 0}};

bool parallel(Vec3 a, Vec3 b) { return length(cross(a, b)) < std::sin(kMinInclination); }

/// The limits of the word, or that it has none: a control that takes words modulo 360 turns for ever.
void read_range(const Section& axis, Range word, RotaryAxis& result) {
  const bool modulo = result.word != RotaryWord::kAccumulate;
  const bool continuous = axis.flag("continuous", modulo);
  if (modulo && !continuous)
    axis.complain("continuous", "expected true: a word that counts modulo 360 has no limits");
  if (continuous) {
    for (const char* key : {"min_deg", "max_deg"}) axis.unused(key, "by an axis that turns without end");
    result.min = -std::numeric_limits<double>::infinity();
    result.max = std::numeric_limits<double>::infinity();
    return;
  }
  result.min = axis.number("min_deg", word);
  result.max = axis.number("max_deg", word);
  if (result.min >= result.max)
    axis.complain("max_deg", exact_text(result.max) + " degrees is not above min_deg, " +
                                 exact_text(result.min) + " degrees; expected min_deg < max_deg");
}

RotaryAxis read_axis_of(const Section& axis, Range word) {
  RotaryAxis result;
  const std::string letter = axis.text("letter");
  if (letter.size() != 1 || letter[0] < 'A' || letter[0] > 'Z' ||
      kTakenLetters.find(letter[0]) != std::string_view::npos)
    axis.complain("letter", "expected one of the letters A B C E U V W, found " + quoted(letter));
  else
    result.letter = letter[0];
  result.direction = axis.direction("direction");
  result.sign = axis.choice<int>("sign", {{"1", +1}, {"+1", +1}, {"-1", -1}});
  result.zero = axis.number("zero_deg", word, 0.0);
  result.word = axis.choice<RotaryWord>("word", kRotaryWords, RotaryWord::kAccumulate);
  read_range(axis, word, result);
  result.velocity = axis.number("velocity_deg_per_min", kAngularVelocity);
  result.acceleration = axis.number("acceleration_deg_per_s2", kAngularAcceleration);
  result.jerk = axis.number("jerk_deg_per_s3", kAngularJerk, 0.0);
  return result;
}

/// A direction that no axis of the model has, square to the spindle as far as a tilt must be.
Vec3 square_to(Vec3 a, Vec3 b) {
  const Vec3 other = std::abs(a.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  return normalized(parallel(a, b) ? cross(a, other) : cross(a, b));
}

RotaryAxis read_tilt(const Section& root, MachineModel& model) {
  const Section tilt = root.section(
      "tilt", {"letter", "direction", "sign", "zero_deg", "word", "continuous", "min_deg", "max_deg",
               "velocity_deg_per_min", "acceleration_deg_per_s2", "jerk_deg_per_s3", "prefer"});
  const RotaryAxis axis = read_axis_of(tilt, kTiltWord);
  model.preferred_tilt = tilt.choice<int>("prefer", kPreferWords, 0);
  if (parallel(axis.direction, model.spindle))
    tilt.complain("direction",
                  "it is that of the spindle, so this axis cannot tilt the tool; expected a direction at "
                  "least 1 degree from spindle_direction");
  return axis;
}

RotaryAxis read_rotary(const Section& root, const MachineModel& model) {
  const Section rotary = root.section(
      "rotary", {"letter", "direction", "sign", "zero_deg", "word", "continuous", "min_deg", "max_deg",
                 "velocity_deg_per_min", "acceleration_deg_per_s2", "jerk_deg_per_s3"});
  const RotaryAxis axis = read_axis_of(rotary, kRotaryWord);
  if (!model.tilt.present) return axis;
  if (parallel(model.tilt.direction, axis.direction))
    rotary.complain("direction", "it is that of the tilt; expected two axes at least 1 degree apart");
  if (model.tilt.letter == axis.letter)
    rotary.complain("letter",
                    std::string(1, axis.letter) + " is tilt.letter too; expected two different letters");
  return axis;
}

/// What lies between the axes: the pivot of a tilting head, the way from one axis to the other.
void read_offsets(const Section& root, MachineModel& model) {
  const Vec3 centre = root.vector("table_centre_mm", kMachinePlace, Vec3{});
  model.table_centre = {centre.x, centre.y, centre.z};
  if (model.structure == Structure::kTableTable || !model.tilt.present) {
    root.unused("pivot_to_gauge_mm", "without a tilting head");
  } else {
    model.pivot_to_gauge = root.vector("pivot_to_gauge_mm", kMachinePlace);
    if (model.pivot_to_gauge.z > 0.0)
      root.complain("pivot_to_gauge_mm",
                    "z is " + exact_text(model.pivot_to_gauge.z) +
                        " mm; expected at most 0: the gauge line hangs under the pivot, or lies in it where "
                        "tools are measured from there");
  }
  if (model.structure == Structure::kTableHead)
    root.unused("rotary_to_tilt_mm", "where the slides lie between the two axes");
  else
    model.rotary_to_tilt = root.vector("rotary_to_tilt_mm", kMachinePlace);
}

std::string limit(double value) { return std::isfinite(value) ? exact_text(value) : "none"; }

void describe_rotary(Description& out, const std::string& key, const RotaryAxis& axis) {
  if (!axis.present) return out.add(key, "none");
  out.add(key + ".letter", std::string(1, axis.letter));
  out.add(key + ".direction", axis.direction);
  out.add(key + ".sign", axis.sign);
  out.add(key + ".zero_deg", axis.zero);
  out.add(key + ".word", word(kRotaryWords, axis.word));
  out.add(key + ".min_deg", limit(axis.min));
  out.add(key + ".max_deg", limit(axis.max));
  out.add(key + ".velocity_deg_per_min", axis.velocity);
  out.add(key + ".acceleration_deg_per_s2", axis.acceleration);
  if (axis.jerk > 0.0) out.add(key + ".jerk_deg_per_s3", axis.jerk);
}

}  // namespace

void read_rotaries(const Section& root, MachineModel& model) {
  model.structure = root.choice<Structure>("structure", kStructureWords, Structure::kTableHead);
  model.spindle = root.direction("spindle_direction", Vec3{0, 0, 1});
  // A machine that carries work and tool on slides alone, or turns one of them, lacks a section or both.
  const bool both = model.structure != Structure::kTableHead;
  const bool tilts = both || root.has("tilt"), turns = both || root.has("rotary");
  if (tilts) model.tilt = read_tilt(root, model);
  model.tilt.present = tilts;
  if (turns) model.rotary = read_rotary(root, model);
  if (!tilts)
    model.tilt = absent_axis(square_to(model.spindle, turns ? model.rotary.direction : model.spindle));
  if (!turns) model.rotary = absent_axis(model.spindle);
  read_offsets(root, model);
}

void check_rotary_words(const Section& root, const MachineModel& model, Dialect dialect) {
  const auto check = [&](const Section& axis, RotaryWord stated) {
    if (const char* why = refusal_of(dialect, stated))
      axis.complain("word", std::string(word(kRotaryWords, stated)) + " is no word of " +
                                name_of(dialect).name + ": " + why +
                                "; expected one that this control obeys");
  };
  if (model.tilt.present) check(root.section("tilt", kTiltKeys), model.tilt.word);
  if (model.rotary.present) check(root.section("rotary", kRotaryKeys), model.rotary.word);
}

void describe_rotaries(Description& out, const MachineModel& model) {
  out.add("structure", word(kStructureWords, model.structure));
  describe_rotary(out, "tilt", model.tilt);
  if (model.tilt.present) out.add("tilt.prefer", word(kPreferWords, model.preferred_tilt));
  describe_rotary(out, "rotary", model.rotary);
  out.add("table_centre_mm", from_origin(model.table_centre));
  if (model.structure != Structure::kTableTable && model.tilt.present)
    out.add("pivot_to_gauge_mm", model.pivot_to_gauge);
  if (model.structure != Structure::kTableHead) out.add("rotary_to_tilt_mm", model.rotary_to_tilt);
  out.add("spindle_direction", model.spindle);
}

}  // namespace tiltfeed::config
