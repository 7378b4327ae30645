#include "config/job.h"

#include <filesystem>

#include "config/job_catalogue.h"
#include "config/job_keys.h"
#include "config/program_keys.h"
#include "config/section.h"
#include "config/yaml_tree.h"

namespace tiltfeed::config {
namespace {

// Ranges, here and in the *_keys.cpp: beyond anything that fits a machine with a tilting head and a table, so
// a slipped digit is seen.
constexpr Range kUnit{1e-4, 1e4};               // mm; a tenth of a micrometre to ten metres
constexpr Range kFeed = above(0.0, 100'000.0);  // mm/min
constexpr Range kSpindle{0.0, 200'000.0};       // 1/min

constexpr double kInch = 25.4;        // mm, exactly
constexpr double kMostBlended = 0.5;  // of the tolerance

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
  read_axis(root, job.plan);
  job.plan.pattern = read_pattern(root, job.plan);
  job.plan.containment = read_containment(root, job.plan.axis.mode);
  read_path(root, job.plan);
  job.axis_tolerance = read_axis_tolerance(root, job.plan);
  const Section feeds = root.section("feeds", {"cut_mm_per_min", "plunge_mm_per_min", "spindle_rpm"});
  job.plan.cut_feed = Feed::from_mm_per_min(feeds.number("cut_mm_per_min", kFeed));
  job.plan.plunge_feed = Feed::from_mm_per_min(feeds.number("plunge_mm_per_min", kFeed));
  job.spindle_rpm = feeds.number("spindle_rpm", kSpindle, 0.0);
  job.program = read_program_data(root);
  job.setup = read_setup(root, job.plan);
  job.machine.path = resolved(path, root.text("machine"));
  return job;
}

}  // namespace

namespace {

Section root_of(const YamlNode& tree, Complaint& complaint) {
  return {
      tree,
      "",
      {"part", "cutter", "axis", "pattern", "containment", "tolerance_mm", "allowance_mm", "stock", "points",
       "guards", "links", "clearance_mm", "approach_mm", "feeds", "program", "setup", "machine"},
      complaint};
}

Result<Job> parse_job_with(const std::string& text, const std::string& path, const JobFiles& files) {
  const Result<YamlNode> tree = parse_yaml(text, path);
  if (!tree) return tl::unexpected(tree.error());
  Complaint complaint(path);
  const Section root = root_of(*tree, complaint);
  Job job = read_job(root, path);
  if (complaint.error()) return tl::unexpected(*complaint.error());
  if (!files.stl.empty()) job.stl_path = files.stl;
  Result<MachineProfile> machine = files.machine.empty()
                                       ? load_named_machine(job.machine.path, root, complaint)
                                       : load_machine(files.machine);
  if (!machine) return tl::unexpected(machine.error());
  job.machine = std::move(*machine);
  // What the control rounds corners off by is a share of the tolerance that nothing else may have.
  const double blend = job.machine.format.blend_tolerance;
  if (blend > kMostBlended * job.plan.tolerance)
    root.complain("tolerance_mm", exact_text(job.plan.tolerance) +
                                      " is less than twice the blend_tolerance_mm of the machine, " +
                                      exact_text(blend) + ", which the control takes of it");
  if (complaint.error()) return tl::unexpected(*complaint.error());
  job.plan.tolerance -= blend;
  if (Angle& turn = job.plan.free.max_turn;
      job.plan.axis.mode == pathgen::AxisMode::kFree && turn.radians() == 0.0)
    turn = default_turn(job.machine.model, job.plan.cutter, job.plan.cut_feed);
  return job;
}

}  // namespace

Result<Job> parse_job(const std::string& text, const std::string& path) {
  return parse_job_with(text, path, {});
}

Result<Job> load_job_with(const std::string& path, const JobFiles& files) {
  const Result<std::string> text = read_config_text(path);
  if (!text) return tl::unexpected(text.error());
  return parse_job_with(*text, path, files);
}

Result<KeyLog> job_keys(const std::string& text) {
  const Result<YamlNode> tree = parse_yaml(text, "job");
  if (!tree) return tl::unexpected(tree.error());
  KeyLog log;
  Complaint complaint("job", &log);
  read_job(root_of(*tree, complaint), "job");
  return log;
}

Result<Job> load_job(const std::string& path) { return load_job_with(path, {}); }

}  // namespace tiltfeed::config
