#include "config/job.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "config/description.h"
#include "config/section.h"
#include "config/yaml_tree.h"

namespace tiltfeed {
namespace {

// Ranges: beyond anything that fits a machine with a tilting head and a table, so a slipped digit is seen.
constexpr Range kUnit{1e-4, 1e4};                 // mm; a tenth of a micrometre to ten metres
constexpr Range kDiameter = above(0.0, 500.0);    // mm
constexpr Range kLength = above(0.0, 2000.0);     // mm
constexpr Range kPosition{-10'000.0, 10'000.0};   // mm
constexpr Range kRadius = above(0.0, 10'000.0);   // mm
constexpr Range kSideStep = above(0.0, 1000.0);   // mm
constexpr Range kTolerance{1e-4, 1.0};            // mm; finer is below what 4 printed decimals hold
constexpr Range kAllowance{0.0, 50.0};            // mm
constexpr Range kClearance = above(0.0, 1000.0);  // mm
constexpr Range kFeed = above(0.0, 100'000.0);    // mm/min
constexpr Range kSpindle{0.0, 200'000.0};         // 1/min
constexpr Range kFixtureAngle{-360.0, 360.0};     // degrees
constexpr Range kTilt = above(0.0, 180.0);        // degrees

constexpr double kInch = 25.4;  // mm, exactly

double read_unit(const Section& part) {
  const std::string word = part.scalar("unit").value_or("");
  if (!part.has("unit") || word == "mm") return 1.0;
  if (word == "inch") return kInch;
  if (word == "m") return 1000.0;
  if (word.find_first_of("0123456789") == std::string::npos)
    part.complain("unit",
                  "expected mm, inch, m or the unit's length as a number of mm, found " + quoted(word));
  return part.number("unit", kUnit);
}

Cutter read_cutter(const Section& root) {
  const Section section = root.section("cutter", {"type", "diameter_mm", "length_mm", "shank_length_mm"});
  section.choice<int>("type", {{"ball", 0}});
  Cutter cutter;
  cutter.diameter = section.number("diameter_mm", kDiameter);
  cutter.length = section.number("length_mm", kLength);
  cutter.shank_length = section.number("shank_length_mm", kLength);
  if (cutter.shank_length > cutter.length)
    section.complain("shank_length_mm", number_text(cutter.shank_length) + " mm is over length_mm, " +
                                            number_text(cutter.length) +
                                            " mm; the holder must start at or below the gauge line");
  if (cutter.shank_length < cutter.radius())
    section.complain("shank_length_mm", number_text(cutter.shank_length) +
                                            " mm is below the ball's radius, " +
                                            number_text(cutter.radius()) + " mm; expected tip to holder");
  return cutter;
}

/// t unit; n made perpendicular to it when it is so within kPerpendicularTolerance, else an error.
void read_directions(const Section& axis, AxisFrame& frame) {
  frame.t = axis.direction("t", frame.t);
  const Vec3 n = axis.direction("n", frame.n);
  const double angle = angle_between(frame.t, n);
  if (std::abs(angle - kPi / 2.0) > kPerpendicularTolerance) {
    axis.complain(axis.has("n") ? "n" : "t",
                  "t and n are " + number_text(Angle::from_radians(angle).degrees()) +
                      " degrees apart; expected 90 within " + number_text(kPerpendicularTolerance) + " rad");
    return;
  }
  // Once leaves an error of the order of the rounding of n; twice is exact to the last digit.
  const Vec3 once = normalized(n - dot(n, frame.t) * frame.t);
  frame.n = normalized(once - dot(once, frame.t) * frame.t);
}

AxisFrame read_axis(const Section& root) {
  const Section axis = root.section("axis", {"mode", "sense", "origin_mm", "t", "n", "circle_radius_mm"});
  AxisFrame frame;
  frame.mode = axis.choice<AxisMode>("mode", {{"fixed", AxisMode::kFixed},
                                              {"point", AxisMode::kPoint},
                                              {"line", AxisMode::kLine},
                                              {"circle", AxisMode::kCircle}});
  if (frame.mode != AxisMode::kFixed)
    frame.sense = axis.choice<Sense>("sense", {{"outward", Sense::kOutward}, {"inward", Sense::kInward}});
  else if (axis.has("sense"))
    axis.complain("sense", "not used in the mode fixed, where the shank points along n; remove it");
  const Vec3 origin = axis.vector("origin_mm", kPosition, Vec3{});
  frame.origin = {origin.x, origin.y, origin.z};
  read_directions(axis, frame);
  if (frame.mode == AxisMode::kCircle)
    frame.circle_radius = axis.number("circle_radius_mm", kRadius);
  else if (axis.has("circle_radius_mm"))
    axis.complain("circle_radius_mm", "used in the mode circle only; remove it or change mode");
  return frame;
}

void read_pattern(const Section& root, PlanOptions& plan) {
  const Section pattern = root.section("pattern", {"along", "direction", "side_step_mm"});
  plan.pattern.along = pattern.choice<Along>("along", {{"x", Along::kX}, {"y", Along::kY}}, plan.pattern.along);
  plan.pattern.direction = pattern.choice<Direction>(
      "direction", {{"one_way", Direction::kOneWay}, {"zigzag", Direction::kZigzag}}, plan.pattern.direction);
  plan.pattern.side_step = pattern.number("side_step_mm", kSideStep);
}

void read_accuracy(const Section& root, PlanOptions& plan) {
  plan.tolerance = root.number("tolerance_mm", kTolerance, plan.tolerance);
  if (plan.tolerance >= plan.cutter.radius())
    root.complain("tolerance_mm", number_text(plan.tolerance) + " mm is not below the ball's radius, " +
                                      number_text(plan.cutter.radius()) + " mm");
  plan.allowance = root.number("allowance_mm", kAllowance, plan.allowance);
  plan.links.clearance = root.number("clearance_mm", kClearance);
  plan.links.approach = root.number("approach_mm", kClearance);
  if (plan.links.approach > plan.links.clearance)
    root.complain("approach_mm", number_text(plan.links.approach) + " mm is over clearance_mm, " +
                                     number_text(plan.links.clearance) +
                                     " mm; the approach is the last part of the way down from there");
}

/// Cosine and sine of an angle in degrees, exact for multiples of 90.
std::array<double, 2> turn(double degrees) {
  constexpr std::array<std::array<double, 2>, 4> kQuarters{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  const double quarters = degrees / 90.0;
  if (quarters == std::floor(quarters)) return kQuarters[(static_cast<int>(quarters) % 4 + 4) % 4];
  const double angle = Angle::from_degrees(degrees).radians();
  return {std::cos(angle), std::sin(angle)};
}

/// Rz Ry Rx: about the table's x first, then its y, then its z.
Rotation fixture_rotation(Vec3 degrees) {
  const auto [cx, sx] = turn(degrees.x);
  const auto [cy, sy] = turn(degrees.y);
  const auto [cz, sz] = turn(degrees.z);
  const Rotation about_x{{Vec3{1, 0, 0}, Vec3{0, cx, -sx}, Vec3{0, sx, cx}}};
  const Rotation about_y{{Vec3{cy, 0, sy}, Vec3{0, 1, 0}, Vec3{-sy, 0, cy}}};
  const Rotation about_z{{Vec3{cz, -sz, 0}, Vec3{sz, cz, 0}, Vec3{0, 0, 1}}};
  return about_z * about_y * about_x;
}

Setup read_setup(const Section& root, PlanOptions& plan) {
  const Section section = root.section("setup", {"part_zero_mm", "fixture_rotation_deg", "tilt_max_deg"});
  Setup setup;
  setup.part_zero = section.vector("part_zero_mm", kPosition);
  setup.fixture = fixture_rotation(section.vector("fixture_rotation_deg", kFixtureAngle, Vec3{}));
  setup.tool_length = plan.cutter.length;
  plan.up = setup.fixture.rows[2];
  plan.tilt_max = Angle::from_degrees(section.number("tilt_max_deg", kTilt, plan.tilt_max.degrees()));
  return setup;
}

/// `name` as the job file means it: relative to that file's folder.
std::string resolved(const std::string& job_path, const std::string& name) {
  return (std::filesystem::path(job_path).parent_path() / name).lexically_normal().string();
}

Job read_job(const Section& root, const std::string& path) {
  Job job;
  job.path = path;
  const Section part = root.section("part", {"name", "stl", "unit"});
  job.plan.name = part.name("name");
  job.stl_path = resolved(path, part.text("stl"));
  job.stl_unit_mm = read_unit(part);
  job.plan.cutter = read_cutter(root);
  job.plan.axis = read_axis(root);
  read_pattern(root, job.plan);
  read_accuracy(root, job.plan);
  const Section feeds = root.section("feeds", {"cut_mm_per_min", "plunge_mm_per_min", "spindle_rpm"});
  job.plan.cut_feed = Feed::from_mm_per_min(feeds.number("cut_mm_per_min", kFeed));
  job.plan.plunge_feed = Feed::from_mm_per_min(feeds.number("plunge_mm_per_min", kFeed));
  job.spindle_rpm = feeds.number("spindle_rpm", kSpindle, 0.0);
  job.setup = read_setup(root, job.plan);
  job.machine.path = resolved(path, root.text("machine"));
  return job;
}

const char* word(AxisMode mode) {
  switch (mode) {
    case AxisMode::kFixed:
      return "fixed";
    case AxisMode::kPoint:
      return "point";
    case AxisMode::kLine:
      return "line";
    case AxisMode::kCircle:
      return "circle";
  }
  return "";
}

void describe_axis(Description& out, const AxisFrame& axis) {
  out.add("axis.mode", word(axis.mode));
  if (axis.mode != AxisMode::kFixed)
    out.add("axis.sense", axis.sense == Sense::kOutward ? "outward" : "inward");
  out.add("axis.origin_mm", from_origin(axis.origin));
  out.add("axis.t", axis.t);
  out.add("axis.n", axis.n);
  if (axis.mode == AxisMode::kCircle) out.add("axis.circle_radius_mm", axis.circle_radius);
}

}  // namespace

Result<Job> parse_job(const std::string& text, const std::string& path) {
  const Result<YamlNode> tree = parse_yaml(text, path);
  if (!tree) return tl::unexpected(tree.error());
  Complaint complaint(path);
  const Section root(*tree, "",
                     {"part", "cutter", "axis", "pattern", "tolerance_mm", "allowance_mm", "clearance_mm",
                      "approach_mm", "feeds", "setup", "machine"},
                     complaint);
  Job job = read_job(root, path);
  if (complaint.first()) return tl::unexpected(*complaint.first());

  Result<MachineProfile> machine = load_machine(job.machine.path);
  if (!machine && machine.error().code == Code::kIo) {
    root.complain("machine", machine.error().message + " (the path is relative to the job file)", Code::kIo);
    return tl::unexpected(*complaint.first());
  }
  if (!machine) return tl::unexpected(machine.error());
  job.machine = std::move(*machine);
  return job;
}

Result<Job> load_job(const std::string& path) {
  const Result<std::string> text = read_config_text(path);
  if (!text) return tl::unexpected(text.error());
  return parse_job(*text, path);
}

std::string describe(const Job& job) {
  const PlanOptions& plan = job.plan;
  Description out;
  out.add("job", job.path);
  out.add("part.name", plan.name);
  out.add("part.stl", job.stl_path);
  out.add("part.unit_mm", job.stl_unit_mm);
  out.add("cutter.type", "ball");
  out.add("cutter.diameter_mm", plan.cutter.diameter);
  out.add("cutter.length_mm", plan.cutter.length);
  out.add("cutter.shank_length_mm", plan.cutter.shank_length);
  describe_axis(out, plan.axis);
  out.add("pattern.along", plan.pattern.along == Along::kX ? "x" : "y");
  out.add("pattern.direction", plan.pattern.direction == Direction::kOneWay ? "one_way" : "zigzag");
  out.add("pattern.side_step_mm", plan.pattern.side_step);
  out.add("tolerance_mm", plan.tolerance);
  out.add("allowance_mm", plan.allowance);
  out.add("clearance_mm", plan.links.clearance);
  out.add("approach_mm", plan.links.approach);
  out.add("feeds.cut_mm_per_min", plan.cut_feed.mm_per_min());
  out.add("feeds.plunge_mm_per_min", plan.plunge_feed.mm_per_min());
  out.add("feeds.spindle_rpm", job.spindle_rpm);
  out.add("setup.part_zero_mm", job.setup.part_zero);
  for (std::size_t row = 0; row < 3; ++row)
    out.add("setup.fixture_row_" + std::to_string(row + 1), job.setup.fixture.rows[row]);
  out.add("setup.tilt_max_deg", plan.tilt_max.degrees());
  out.add("setup.tool_length_mm", job.setup.tool_length);
  std::istringstream machine(describe(job.machine));
  std::string text = out.text();
  for (std::string line; std::getline(machine, line);) text += "machine." + line + "\n";
  return text;
}

}  // namespace tiltfeed
