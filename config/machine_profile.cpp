#include "config/machine_profile.h"

#include "config/body_keys.h"
#include "config/description.h"
#include "config/key_ranges.h"
#include "config/program_keys.h"
#include "config/rotary_keys.h"
#include "config/section.h"
#include "config/yaml_tree.h"

namespace tiltfeed::config {
namespace {

// Ranges: wide enough for any machine with a table that people stand beside, narrow enough that a slipped
// digit or a metre typed as a millimetre is seen.
constexpr Range kLinearVelocity = above(0.0, 1'000'000.0);      // mm/min
constexpr Range kLinearAcceleration = above(0.0, 1'000'000.0);  // mm/s^2
constexpr Range kLinearJerk = above(0.0, 1e9);                  // mm/s^3
constexpr Range kCornerTime{0.0, 1000.0};                       // ms
constexpr Range kByteRate{0.0, 1e9};                            // bytes/s

LinearAxis read_linear(const Section& linear, const char* key) {
  const Section axis = linear.section(
      key, {"min_mm", "max_mm", "velocity_mm_per_min", "acceleration_mm_per_s2", "jerk_mm_per_s3"});
  LinearAxis result;
  result.min = axis.number("min_mm", kMachinePlace);
  result.max = axis.number("max_mm", kMachinePlace);
  if (result.min >= result.max)
    axis.complain("max_mm", exact_text(result.max) + " mm is not above min_mm, " + exact_text(result.min) +
                                " mm; expected min_mm < max_mm");
  result.velocity = axis.number("velocity_mm_per_min", kLinearVelocity);
  result.acceleration = axis.number("acceleration_mm_per_s2", kLinearAcceleration);
  result.jerk = axis.number("jerk_mm_per_s3", kLinearJerk, 0.0);
  return result;
}

void read_link(const Section& root, MachineProfile& profile) {
  const Section link = root.optional_section("link", {"default", "receive_buffer_bytes", "bytes_per_s"});
  profile.link = link.text("default", "");
  profile.receive_buffer = link.integer("receive_buffer_bytes", 17, 65536, profile.receive_buffer);
  profile.link_rate = link.number("bytes_per_s", kByteRate, profile.link_rate);
  // Character counting sends a line only when it and its line end fit; a longer one would wait for ever.
  const bool counts = profile.format.dialect == Dialect::kGrbl || link.has("receive_buffer_bytes");
  if (counts && profile.format.max_line_length + 1 > profile.receive_buffer)
    link.complain("receive_buffer_bytes",
                  std::to_string(profile.receive_buffer) + " bytes do not hold a line of program." +
                      "max_line_length, " + std::to_string(profile.format.max_line_length) +
                      ", and its line end; lower max_line_length or state the controller's real buffer");
}

void read_control(const Section& root, MachineProfile& profile) {
  const Section control =
      root.optional_section("control", {"look_ahead_blocks", "corner_time_ms", "blend_rotary"});
  ControlModel& model = profile.control;
  model.look_ahead = control.integer("look_ahead_blocks", 1, 100'000, model.look_ahead);
  model.corner_time = control.number("corner_time_ms", kCornerTime, model.corner_time * 1e3) / 1e3;
  profile.model.blends_rotary = control.flag("blend_rotary", profile.model.blends_rotary);
}

MachineProfile read_profile(const Section& root, std::optional<Dialect> dialect) {
  MachineProfile profile;
  MachineModel& model = profile.model;
  model.name = root.name("name");
  const Section linear = root.section("linear", {"x", "y", "z"});
  model.x = read_linear(linear, "x");
  model.y = read_linear(linear, "y");
  model.z = read_linear(linear, "z");
  read_rotaries(root, model);
  read_control(root, profile);
  profile.format = read_format(root, dialect);
  if (profile.format.tcp && !model.tilt.present && !model.rotary.present)
    root.complain("program", "tcp is true, and the machine has no rotary axis; expected false");
  check_rotary_words(root, model, profile.format.dialect);
  check_home(root, model, profile.format);
  check_planes(root, model, profile.format);
  read_link(root, profile);
  profile.wire = read_link_profile(root);
  profile.magazine = read_magazine(root);
  return profile;
}

void describe_linear(Description& out, const std::string& key, const LinearAxis& axis) {
  out.add(key + ".min_mm", axis.min);
  out.add(key + ".max_mm", axis.max);
  out.add(key + ".velocity_mm_per_min", axis.velocity);
  out.add(key + ".acceleration_mm_per_s2", axis.acceleration);
  if (axis.jerk > 0.0) out.add(key + ".jerk_mm_per_s3", axis.jerk);
}

}  // namespace

Result<MachineProfile> parse_machine(const std::string& text, const std::string& path,
                                     std::optional<Dialect> dialect) {
  const Result<YamlNode> tree = parse_yaml(text, path);
  if (!tree) return tl::unexpected(tree.error());
  Complaint complaint(path);
  const Section root(*tree, "",
                     {"name", "linear", "structure", "tilt", "rotary", "table_centre_mm", "pivot_to_gauge_mm",
                      "rotary_to_tilt_mm", "spindle_direction", "slides", "bodies", "clearances", "control",
                      "check", "program", "link", "wire", "magazine"},
                     complaint);
  MachineProfile profile = read_profile(root, dialect);
  if (complaint.error()) return tl::unexpected(*complaint.error());
  profile.vectors = read_vectors(root, profile.model);
  profile.solid = read_bodies(root, profile.model, path);
  if (complaint.error()) return tl::unexpected(*complaint.error());
  profile.path = path;
  return profile;
}

Result<MachineProfile> load_machine(const std::string& path, std::optional<Dialect> dialect) {
  const Result<std::string> text = read_config_text(path);
  if (!text) return tl::unexpected(text.error());
  return parse_machine(*text, path, dialect);
}

Result<MachineProfile> load_named_machine(const std::string& path, const Section& root,
                                          const Complaint& complaint) {
  Result<MachineProfile> machine = load_machine(path);
  if (machine || machine.error().code != Code::kIo) return machine;
  root.complain("machine", machine.error().message + " (the path is relative to this file)", Code::kIo);
  return tl::unexpected(*complaint.error());
}

std::string describe(const MachineProfile& profile) {
  const MachineModel& model = profile.model;
  Description out;
  out.add("file", profile.path);
  out.add("name", model.name);
  describe_linear(out, "linear.x", model.x);
  describe_linear(out, "linear.y", model.y);
  describe_linear(out, "linear.z", model.z);
  describe_rotaries(out, model);
  describe_vectors(out, profile.vectors);
  describe_bodies(out, profile.solid);
  out.add("control.look_ahead_blocks", profile.control.look_ahead);
  out.add("control.corner_time_ms", profile.control.corner_time * 1e3);
  out.add("control.blend_rotary", profile.model.blends_rotary);
  describe_format(out, profile.format);
  out.add("link.default", profile.link.empty() ? "none" : profile.link);
  out.add("link.receive_buffer_bytes", profile.receive_buffer);
  out.add("link.bytes_per_s", profile.link_rate);
  describe(profile.wire, out);
  describe(profile.magazine, out);
  return out.text();
}

}  // namespace tiltfeed::config
