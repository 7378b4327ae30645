#include "config/job.h"

#include <algorithm>
#include <optional>
#include <sstream>
#include <vector>

#include "config/body_keys.h"
#include "config/job_catalogue.h"
#include "config/job_keys.h"
#include "config/job_reading.h"
#include "config/key_ranges.h"
#include "config/named_files.h"
#include "config/new_job.h"
#include "config/operations.h"
#include "config/program_keys.h"
#include "config/section.h"
#include "config/yaml_edit.h"
#include "config/yaml_tree.h"
#include "kinematics/basics/tolerance_budget.h"
#include "kinematics/machine/chain.h"
#include "pathgen/part_file/file_kind.h"

namespace tiltfeed::config {
namespace {

constexpr double kMostBlended = 0.5;  // of the tolerance
constexpr std::size_t kMostPartBodies = 100;
constexpr Range kAvoided{0.001, 100.0};  // mm
// A direction that a machine misses by so much (rad) it does not give: more than any axis tolerance.
constexpr double kAxisMissed = 0.05;

/// What stands at `section`.`key`; null: nothing.
const YamlNode* node_at(const YamlNode& tree, const char* section, const char* key) {
  const YamlNode* node = &tree;
  for (const char* name : {section, key}) {
    const auto found = std::find_if(node->keys.begin(), node->keys.end(),
                                    [&](const YamlKey& at) { return at.text == name; });
    if (found == node->keys.end()) return nullptr;
    node = &node->items[static_cast<std::size_t>(found - node->keys.begin())];
  }
  return node;
}

/// The library that the job names, if it names one.
Result<std::optional<ToolLibrary>> read_library(const YamlNode& tree, const Section& root,
                                                const Complaint& complaint, const std::string& path,
                                                const JobFiles& files) {
  const YamlNode* named = node_at(tree, "cutter", "library");
  if (named == nullptr || named->text.empty()) return std::nullopt;
  Result<ToolLibrary> library =
      load_tool_library(files.tools.empty() ? beside_file(path, named->text) : files.tools);
  if (library) return std::move(*library);
  if (library.error().code != Code::kIo) return tl::unexpected(library.error());
  root.complain("cutter", "library: " + library.error().message + " (the path is relative to this file)",
                Code::kIo);
  return tl::unexpected(*complaint.error());
}

}  // namespace

Job read_job(const Section& root, const std::string& path, const ToolLibrary* tools) {
  Job job;
  job.path = path;
  const Section part = root.section("part", {"name", "stl", "unit", "bodies", "avoid_faces", "avoid_mm"});
  job.plan.name = part.name("name");
  job.stl_path = beside_file(path, part.text("stl"));
  job.stl_unit_mm = read_stl_unit(part);
  job.bodies = part.lines("bodies", kMostPartBodies);
  job.avoid_faces = part.lines("avoid_faces", kMostPartBodies);
  job.avoid = part.number("avoid_mm", kAvoided, job.avoid);
  if (job.avoid_faces.empty()) part.unused("avoid_mm", "without avoid_faces");
  const CutterChoice choice = read_cutter(root, tools);
  job.plan.cutter = choice.cutter;
  job.tool_id = choice.id;
  job.material = choice.material;
  if (tools != nullptr) job.tools_path = tools->path;
  read_axis(root, job.plan);
  job.plan.pattern = read_pattern(root, job.plan);
  job.plan.containment = read_containment(root, job.plan.axis.mode);
  read_only_faces(root, job);
  read_path(root, job.plan);
  job.axis_tolerance = read_axis_tolerance(root, job.plan);
  job.calm = read_calm(root, job.plan);
  read_feeds(root, choice, job);
  job.program = read_program_data(root, choice.tool == nullptr ? 0 : choice.tool->number);
  job.setup = read_setup(root, job.plan);
  job.fixtures = read_fixtures(root, path);
  job.blank = read_blank(root, path);
  job.machine.path = beside_file(path, root.text("machine"));
  return job;
}

Section job_root(const YamlNode& tree, Complaint& complaint) {
  return {tree,
          "",
          {"part",         "cutter",       "axis",       "pattern",        "rest",   "containment",
           "tolerance_mm", "allowance_mm", "stock",      "points",         "guards", "links",
           "clearance_mm", "approach_mm",  "feeds",      "program",        "setup",  "fixtures",
           "blank",        "machine",      "operations", "operation_order"},
          complaint};
}

bool reads_by_tool(const Section& root) {
  if (!root.has("operations")) root.unused("operation_order", "without operations");
  return root.choice<bool>("operation_order", {{"listed", false}, {"by_tool", true}}, false);
}

namespace {

/// What the axis mode needs and a machine of fewer axes does not give, as text; empty: none.
std::string missed_direction(const Job& job) {
  const MachineModel& machine = job.machine.model;
  if (machine.tilt.present && machine.rotary.present) return "";
  const pathgen::AxisFrame& axis = job.plan.axis;
  const Vec3 b = cross(axis.n, axis.t);
  std::vector<Vec3> needed;
  switch (axis.mode) {
    case pathgen::AxisMode::kFixed:
      needed = {axis.n};
      break;
    case pathgen::AxisMode::kLine:
      needed = {axis.n, b};
      break;
    case pathgen::AxisMode::kPoint:
    case pathgen::AxisMode::kCircle:
      needed = {axis.n, axis.t, b};
      break;
    case pathgen::AxisMode::kFree:
    case pathgen::AxisMode::kIndexed: {
      const std::string has =
          machine.tilt.present     ? "the rotary axis " + std::string(1, machine.tilt.letter) + " alone"
          : machine.rotary.present ? "the rotary axis " + std::string(1, machine.rotary.letter) + " alone"
                                   : "no rotary axis";
      return "this mode turns the tool every way, and " + machine.name + " has " + has +
             "; use fixed, or where it has one line, or take a machine with two";
    }
  }
  if (may_lean(job.plan))
    return "the reaction tilt turns the tool every way about the axis, and " + machine.name +
           " has fewer than two rotary axes; use the reaction trim, or take a machine with two";
  const Chain chain(machine, job.setup);
  for (const Vec3 direction : needed) {
    const Vec3 there = chain.on_table(direction);
    double missed = chain.solve_axis(there).missed;
    // Of the modes that turn the tool the work may lie on either side.
    if (axis.mode != pathgen::AxisMode::kFixed) missed = std::min(missed, chain.solve_axis(-there).missed);
    if (missed > kAxisMissed) return unreachable_text(machine, direction, there);
  }
  return "";
}

/// Of the key that a message begins with, or of its section.
TextPlace place_of(const YamlNode& tree, const std::string& message) {
  const bool cutter = message.starts_with("cutter.");
  const YamlNode* node = cutter ? node_at(tree, "cutter", "id") : node_at(tree, "program", "tool");
  return node != nullptr ? node->place : TextPlace{};
}

/// Files of the text that did not come with it. Whether they are there is not told either.
void refuse_named_files(const YamlNode& tree, Complaint& complaint) {
  for (const NamedFileKey& file : files_named_in(tree)) {
    const bool tool = file.key.ends_with("library");
    const std::string instead = tool ? "state the tool in the job"
                                     : "state it as boxes, cylinders or cones, or plan the job where the "
                                       "file is and submit its program";
    complaint.add(file.node->place, file.key + ": the file " + quoted(file.node->text) +
                                        " did not come with the job; " + instead);
  }
}

/// Of one operation.
Result<Job> parse_tree(const YamlNode& tree, const std::string& path, const JobFiles& files) {
  Complaint complaint(path);
  if (files.closed) refuse_named_files(tree, complaint);
  if (complaint.error()) return tl::unexpected(*complaint.error());
  const Section root = job_root(tree, complaint);
  const Result<std::optional<ToolLibrary>> tools = read_library(tree, root, complaint, path, files);
  if (!tools) return tl::unexpected(tools.error());
  Job job = read_job(root, path, *tools ? &**tools : nullptr);
  if (complaint.error()) return tl::unexpected(*complaint.error());
  if (!files.stl.empty()) job.stl_path = files.stl;
  Result<MachineProfile> machine = files.machine.empty()
                                       ? load_named_machine(job.machine.path, root, complaint)
                                       : load_machine(files.machine);
  if (!machine) return tl::unexpected(machine.error());
  job.machine = std::move(*machine);
  const bool numbered = node_at(tree, "program", "tool") != nullptr;
  const Result<int> number =
      number_in(job.machine.magazine, job.machine.path, {job.tool_id, job.program.tool, numbered});
  if (!number)
    complaint.add(place_of(tree, number.error().message), number.error().message);
  else
    job.program.tool = *number;
  for (const auto& [key, wrong] : not_of_control(job.program, job.machine.format, job.machine.path))
    complaint.add(node_at(tree, "program", key)->place, std::string("program.") + key + ": " + wrong);
  const bool stands =
      job.plan.axis.mode == pathgen::AxisMode::kFixed || job.plan.axis.mode == pathgen::AxisMode::kIndexed;
  if (job.machine.format.tilted_planes && stands && job.program.tool == 0 &&
      begins_at_home(job.machine.format.dialect))
    root.complain("program", "tool is 0, and a tilted plane in " +
                                 std::string(name_of(job.machine.format.dialect).name) +
                                 " needs a tool number for its H word; state program.tool");
  if (job.program.plane_offsets && job.machine.format.tilted_planes && !stands)
    complaint.add(node_at(tree, "program", "plane_offsets")->place,
                  "program.plane_offsets: this axis.mode turns the rotaries in cuts, which are in no tilted "
                  "plane; expected false, or axis.mode fixed or indexed");
  // What the control leaves the path by is a share of the tolerance that nothing else may have.
  const double left = left_to_control(job), asked = job.program.smoothing_tolerance;
  if (asked > kMostBlended * job.plan.tolerance)
    complaint.add(node_at(tree, "program", "smoothing_tolerance_mm")->place,
                  "program.smoothing_tolerance_mm: " + exact_text(asked) +
                      " is more than half of tolerance_mm, " + exact_text(job.plan.tolerance) +
                      "; the plan has the rest");
  else if (left > kMostBlended * job.plan.tolerance)
    root.complain("tolerance_mm", exact_text(job.plan.tolerance) +
                                      " is less than twice the blend_tolerance_mm of the machine and the "
                                      "program.smoothing_tolerance_mm, " +
                                      exact_text(left) + ", which the control takes of it");
  // Judges hold the whole tolerance: what arcs leave the path by is in the text that they read.
  if (const double arcs = job.program.arc_tolerance;
      arcs > 0.0 && arcs + left > kMostBlended * job.plan.tolerance)
    complaint.add(node_at(tree, "program", "arc_tolerance_mm")->place,
                  "program.arc_tolerance_mm: " + exact_text(arcs) +
                      (left > 0.0 ? " and " + exact_text(left) + ", which the control takes, are" : " is") +
                      " more than half of tolerance_mm, " + exact_text(job.plan.tolerance) +
                      "; the plan has the rest");
  if (const std::string missed = missed_direction(job); !missed.empty())
    complaint.add(node_at(tree, "axis", "mode")->place, "axis.mode: " + missed);
  if (complaint.error()) return tl::unexpected(*complaint.error());
  job.plan.tolerance -= left;
  if (pathgen::has_surfaces(pathgen::format_of_file(job.stl_path))) {
    job.tessellation = ToleranceBudget::tessellation(job.plan.tolerance);
    job.plan.tolerance -= job.tessellation;
  }
  set_default_turns(job.machine.model, job.plan);
  job.plan.links.rapid = rapid_rates(job.machine.model);
  return job;
}

/// "roughing, finishing".
std::string names_of(const std::vector<Job>& jobs) {
  std::string names;
  for (const Job& job : jobs) names += (names.empty() ? "" : ", ") + job.operation.name;
  return names;
}

/// Lines of `more` that `text` has not yet, at its end.
void add_lines(std::string& text, const std::string& more) {
  std::istringstream in(more);
  for (std::string line; std::getline(in, line);)
    if (("\n" + text + "\n").find("\n" + line + "\n") == std::string::npos)
      text += (text.empty() ? "" : "\n") + line;
}

/// What is wrong with tools that take turns in one spindle; empty: nothing.
std::string wrong_tools(const std::vector<Job>& jobs) {
  for (const Job& job : jobs)
    for (const Job& other : jobs) {
      const bool same = cutter_text(job.plan.cutter) == cutter_text(other.plan.cutter);
      const std::string both =
          "the operations " + quoted(other.operation.name) + " and " + quoted(job.operation.name);
      if (!same && job.program.tool == 0)
        return both + " have different cutters, and program.tool of " + quoted(job.operation.name) +
               " is 0: it does not say which tool is to be changed in; state a tool number for each";
      if (!same && job.program.tool == other.program.tool)
        return both + " have different cutters under one tool number, " + std::to_string(job.program.tool) +
               "; give each its own";
    }
  return "";
}

/// All that have the tool of the first, then all that have the tool of the next one that is left, and so on.
void group_by_tool(std::vector<Job>& jobs) {
  std::vector<int> tools;
  const auto place = [&](const Job& job) {
    return std::find(tools.begin(), tools.end(), job.program.tool) - tools.begin();
  };
  for (const Job& job : jobs)
    if (place(job) == static_cast<std::ptrdiff_t>(tools.size())) tools.push_back(job.program.tool);
  std::stable_sort(jobs.begin(), jobs.end(),
                   [&](const Job& one, const Job& other) { return place(one) < place(other); });
}

/// In the order of the list.
Result<std::vector<Job>> read_operations(const std::vector<OperationTree>& trees, const std::string& path,
                                         const JobFiles& files) {
  std::vector<Job> jobs;
  Error wrong{Code::kInput, ""};
  for (std::size_t i = 0; i < trees.size(); ++i) {
    Result<Job> job = parse_tree(trees[i].tree, path, files);
    if (!job) {
      if (wrong.message.empty()) wrong.code = job.error().code;
      add_lines(wrong.message, job.error().message);
      continue;
    }
    job->operation = {trees[i].name, i + 1, trees.size()};
    jobs.push_back(std::move(*job));
  }
  if (!wrong.message.empty()) return tl::unexpected(wrong);
  if (const std::string tools = wrong_tools(jobs); !tools.empty())
    return fail(Code::kInput, path + ": " + tools);
  return jobs;
}

/// As they are listed, whatever order is asked for.
Result<std::vector<Job>> parse_list(const YamlNode& tree, const std::string& path, const JobFiles& files,
                                    bool& by_tool) {
  Complaint complaint(path);
  const Section root = job_root(tree, complaint);
  const std::vector<OperationTree> trees = operation_trees(tree, root);
  by_tool = reads_by_tool(root);
  if (complaint.error()) return tl::unexpected(*complaint.error());
  return read_operations(trees, path, files);
}

Result<std::vector<Job>> parse_operations(const std::string& text, const std::string& path,
                                          const JobFiles& files) {
  const Result<YamlNode> tree = parse_yaml(text, path);
  if (!tree) return tl::unexpected(tree.error());
  bool by_tool = false;
  Result<std::vector<Job>> jobs = parse_list(*tree, path, files, by_tool);
  if (!jobs) return jobs;
  if (by_tool) group_by_tool(*jobs);
  if (jobs->front().plan.rest_more_than > 0.0)
    return fail(Code::kInput,
                path + ": rest.more_than_mm: no operation comes before " +
                    (jobs->front().operation.name.empty() ? "this one, the job is one"
                                                          : quoted(jobs->front().operation.name)) +
                    "; leave rest out there, or put another operation first");
  for (std::size_t i = 0; i < jobs->size(); ++i) (*jobs)[i].operation.number = i + 1;
  if (files.operation.empty()) return jobs;
  const auto named = std::find_if(jobs->begin(), jobs->end(),
                                  [&](const Job& job) { return job.operation.name == files.operation; });
  if (named != jobs->end()) return std::vector<Job>{std::move(*named)};
  return fail(Code::kUsage,
              path + ": there is no operation " + quoted(files.operation) +
                  (jobs->front().operation.name.empty() ? "; the job has no list of operations"
                                                        : "; its operations are " + names_of(*jobs)));
}

Result<Job> parse_job_with(const std::string& text, const std::string& path, const JobFiles& files) {
  Result<std::vector<Job>> jobs = parse_operations(text, path, files);
  if (!jobs) return tl::unexpected(jobs.error());
  if (jobs->size() == 1) return std::move(jobs->front());
  return fail(Code::kUsage, path + ": the job has several operations (" + names_of(*jobs) +
                                "), and one is wanted here; name it (--operation), or move it into a job of "
                                "its own");
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

Result<std::vector<Job>> load_operations(const std::string& path, const JobFiles& files) {
  const Result<std::string> text = read_config_text(path);
  if (!text) return tl::unexpected(text.error());
  return parse_operations(*text, path, files);
}

Result<std::string> with_tool_written_out(const std::string& text, const std::string& path,
                                          const JobFiles& files) {
  const Result<YamlNode> tree = parse_yaml(text, path);
  if (!tree) return tl::unexpected(tree.error());
  bool by_tool = false;
  const Result<std::vector<Job>> jobs = parse_list(*tree, path, files, by_tool);
  if (!jobs) return tl::unexpected(jobs.error());
  std::vector<YamlEdit> edits;
  for (const Job& job : *jobs) {
    if (job.tools_path.empty()) continue;
    const std::string in =
        job.operation.name.empty() ? "" : "operations[" + std::to_string(job.operation.number) + "].";
    edits.push_back({in + "cutter", "{id: \"" + job.tool_id + "\", " + cutter_text(job.plan.cutter) + "}"});
    if (!job.material.empty())
      for (const auto& [key, value] : {std::pair{"cut_mm_per_min", job.plan.cut_feed.mm_per_min()},
                                       std::pair{"plunge_mm_per_min", job.plan.plunge_feed.mm_per_min()},
                                       std::pair{"spindle_rpm", job.spindle_rpm}})
        edits.push_back({in + "feeds." + key, exact_text(value)});
    if (job.program.tool > 0) edits.push_back({in + "program.tool", std::to_string(job.program.tool)});
  }
  std::string out = text;
  for (const YamlEdit& edit : edits) {
    const Result<KeyLog> log = job_keys(out);
    if (!log) return tl::unexpected(log.error());
    Result<std::string> changed =
        edited(out, edit, [&](const std::string& section) { return log->known(section); });
    if (!changed) return changed;
    out = std::move(*changed);
  }
  return out;
}

Result<Job> load_job(const std::string& path) { return load_job_with(path, {}); }

}  // namespace tiltfeed::config
