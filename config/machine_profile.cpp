#include "config/machine_profile.h"

#include <cmath>
#include <string_view>

#include "config/description.h"
#include "config/section.h"
#include "config/yaml_tree.h"

namespace tiltfeed {
namespace {

// Ranges: wide enough for any machine with a table that people stand beside, narrow enough that a slipped
// digit or a metre typed as a millimetre is seen.
constexpr Range kPosition{-100'000.0, 100'000.0};         // mm
constexpr Range kTiltWord{-360.0, 360.0};                 // degrees; a head does not turn further
constexpr Range kRotaryWord{-1'000'000.0, 1'000'000.0};   // degrees; endless tables are given large limits
constexpr Range kVelocity = above(0.0, 1'000'000.0);      // mm/min or degrees/min
constexpr Range kAcceleration = above(0.0, 1'000'000.0);  // mm/s^2 or degrees/s^2
constexpr Range kInverseTime = above(0.0, 1e9);           // 1/min

/// A head that turns about a nearly vertical axis cannot tilt the tool: 1 degree, far below any nutating
/// head.
const double kMinTiltInclination = Angle::from_degrees(1.0).radians();

/// Letters that mean something else in RS274 programs.
constexpr std::string_view kTakenLetters = "DFGHIJKLMNOPQRSTXYZ";

LinearAxis read_linear(const Section& linear, const char* key) {
  const Section axis =
      linear.section(key, {"min_mm", "max_mm", "velocity_mm_per_min", "acceleration_mm_per_s2"});
  LinearAxis result;
  result.min = axis.number("min_mm", kPosition);
  result.max = axis.number("max_mm", kPosition);
  if (result.min >= result.max)
    axis.complain("max_mm", exact_text(result.max) + " mm is not above min_mm, " + exact_text(result.min) +
                                " mm; expected min_mm < max_mm");
  result.velocity = axis.number("velocity_mm_per_min", kVelocity);
  result.acceleration = axis.number("acceleration_mm_per_s2", kAcceleration);
  return result;
}

Section rotary_section(const Section& root, const char* key) {
  return root.section(key, {"letter", "direction", "sign", "zero_deg", "min_deg", "max_deg",
                            "velocity_deg_per_min", "acceleration_deg_per_s2"});
}

RotaryAxis read_rotary(const Section& axis, Range word) {
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
  result.min = axis.number("min_deg", word);
  result.max = axis.number("max_deg", word);
  if (result.min >= result.max)
    axis.complain("max_deg", exact_text(result.max) + " degrees is not above min_deg, " +
                                 exact_text(result.min) + " degrees; expected min_deg < max_deg");
  result.velocity = axis.number("velocity_deg_per_min", kVelocity);
  result.acceleration = axis.number("acceleration_deg_per_s2", kAcceleration);
  return result;
}

RotaryAxis read_tilt(const Section& axis) {
  const RotaryAxis tilt = read_rotary(axis, kTiltWord);
  const double level = std::hypot(tilt.direction.x, tilt.direction.y);
  if (std::atan2(level, std::abs(tilt.direction.z)) < kMinTiltInclination)
    axis.complain("direction",
                  "it is vertical, so this head cannot tilt the tool; expected a direction at "
                  "least 1 degree from (0, 0, 1)");
  return tilt;
}

RotaryAxis read_table(const Section& axis) {
  const RotaryAxis rotary = read_rotary(axis, kRotaryWord);
  if (rotary.direction != Vec3{0, 0, 1})
    axis.complain("direction",
                  "the table must turn about the vertical; expected [0, 0, 1] (the key sign "
                  "states which way it turns)");
  return rotary;
}

Vec3 read_pivot(const Section& root) {
  const Vec3 pivot = root.vector("pivot_to_gauge_mm", kPosition);
  if (pivot.z >= 0.0)
    root.complain("pivot_to_gauge_mm", "z is " + exact_text(pivot.z) +
                                           " mm; expected it below 0: the gauge line hangs under the pivot");
  return pivot;
}

ProgramFormat read_format(const Section& root) {
  const Section program =
      root.optional_section("program", {"dialect", "linear_decimals", "rotary_decimals", "max_line_length",
                                        "line_numbers", "max_inverse_time_per_min"});
  const ProgramFormat usual;
  ProgramFormat result;
  result.dialect = program.choice<Dialect>("dialect", {{"rs274", Dialect::kRs274}, {"grbl", Dialect::kGrbl}},
                                           usual.dialect);
  result.linear_decimals = program.integer("linear_decimals", 1, 6, usual.linear_decimals);
  result.rotary_decimals = program.integer("rotary_decimals", 1, 6, usual.rotary_decimals);
  result.max_line_length = program.integer("max_line_length", 16, 4096, usual.max_line_length);
  result.line_numbers = program.flag("line_numbers", usual.line_numbers);
  result.max_inverse_time = program.number("max_inverse_time_per_min", kInverseTime, usual.max_inverse_time);
  return result;
}

void read_link(const Section& root, MachineProfile& profile) {
  const Section link = root.optional_section("link", {"default", "receive_buffer_bytes"});
  profile.link = link.text("default", "");
  profile.receive_buffer = link.integer("receive_buffer_bytes", 17, 65536, profile.receive_buffer);
  // Character counting sends a line only when it and its line end fit; a longer one would wait for ever.
  const bool counts = profile.format.dialect == Dialect::kGrbl || link.has("receive_buffer_bytes");
  if (counts && profile.format.max_line_length + 1 > profile.receive_buffer)
    link.complain("receive_buffer_bytes",
                  std::to_string(profile.receive_buffer) + " bytes do not hold a line of program." +
                      "max_line_length, " + std::to_string(profile.format.max_line_length) +
                      ", and its line end; lower max_line_length or state the controller's real buffer");
}

MachineProfile read_profile(const Section& root) {
  MachineProfile profile;
  MachineModel& model = profile.model;
  model.name = root.name("name");
  const Section linear = root.section("linear", {"x", "y", "z"});
  model.x = read_linear(linear, "x");
  model.y = read_linear(linear, "y");
  model.z = read_linear(linear, "z");
  model.tilt = read_tilt(rotary_section(root, "tilt"));
  const Section rotary = rotary_section(root, "rotary");
  model.rotary = read_table(rotary);
  if (model.tilt.letter == model.rotary.letter)
    rotary.complain("letter", std::string(1, model.rotary.letter) +
                                  " is tilt.letter too; expected two different letters");
  const Vec3 centre = root.vector("table_centre_mm", kPosition, Vec3{});
  model.table_centre = {centre.x, centre.y, centre.z};
  model.pivot_to_gauge = read_pivot(root);
  profile.format = read_format(root);
  read_link(root, profile);
  return profile;
}

void describe_linear(Description& out, const std::string& key, const LinearAxis& axis) {
  out.add(key + ".min_mm", axis.min);
  out.add(key + ".max_mm", axis.max);
  out.add(key + ".velocity_mm_per_min", axis.velocity);
  out.add(key + ".acceleration_mm_per_s2", axis.acceleration);
}

void describe_rotary(Description& out, const std::string& key, const RotaryAxis& axis) {
  out.add(key + ".letter", std::string(1, axis.letter));
  out.add(key + ".direction", axis.direction);
  out.add(key + ".sign", axis.sign);
  out.add(key + ".zero_deg", axis.zero);
  out.add(key + ".min_deg", axis.min);
  out.add(key + ".max_deg", axis.max);
  out.add(key + ".velocity_deg_per_min", axis.velocity);
  out.add(key + ".acceleration_deg_per_s2", axis.acceleration);
}

}  // namespace

Result<MachineProfile> parse_machine(const std::string& text, const std::string& path) {
  const Result<YamlNode> tree = parse_yaml(text, path);
  if (!tree) return tl::unexpected(tree.error());
  Complaint complaint(path);
  const Section root(
      *tree, "",
      {"name", "linear", "tilt", "rotary", "table_centre_mm", "pivot_to_gauge_mm", "program", "link"},
      complaint);
  MachineProfile profile = read_profile(root);
  if (complaint.first()) return tl::unexpected(*complaint.first());
  profile.path = path;
  return profile;
}

Result<MachineProfile> load_machine(const std::string& path) {
  const Result<std::string> text = read_config_text(path);
  if (!text) return tl::unexpected(text.error());
  return parse_machine(*text, path);
}

std::string describe(const MachineProfile& profile) {
  const MachineModel& model = profile.model;
  const ProgramFormat& format = profile.format;
  Description out;
  out.add("file", profile.path);
  out.add("name", model.name);
  describe_linear(out, "linear.x", model.x);
  describe_linear(out, "linear.y", model.y);
  describe_linear(out, "linear.z", model.z);
  describe_rotary(out, "tilt", model.tilt);
  describe_rotary(out, "rotary", model.rotary);
  out.add("table_centre_mm", from_origin(model.table_centre));
  out.add("pivot_to_gauge_mm", model.pivot_to_gauge);
  out.add("program.dialect", format.dialect == Dialect::kGrbl ? "grbl" : "rs274");
  out.add("program.linear_decimals", format.linear_decimals);
  out.add("program.rotary_decimals", format.rotary_decimals);
  out.add("program.max_line_length", format.max_line_length);
  out.add("program.line_numbers", format.line_numbers);
  out.add("program.max_inverse_time_per_min", format.max_inverse_time);
  out.add("link.default", profile.link.empty() ? "none" : profile.link);
  out.add("link.receive_buffer_bytes", profile.receive_buffer);
  return out.text();
}

}  // namespace tiltfeed
