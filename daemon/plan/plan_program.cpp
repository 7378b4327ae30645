#include "daemon/plan/plan_program.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <optional>

#include "config/fixture_meshes.h"
#include "config/job.h"
#include "config/job_inputs.h"
#include "config/output_file.h"
#include "daemon/plan/header_figures.h"
#include "daemon/plan/part_size.h"
#include "daemon/plan/path_drawing.h"
#include "daemon/plan/plan_report.h"
#include "daemon/plan/proof_process.h"
#include "daemon/plan/start_turn.h"
#include "daemon/post/block.h"
#include "daemon/post/block_map.h"
#include "daemon/post/end_ways.h"
#include "daemon/post/near_singularity.h"
#include "daemon/post/part_extent.h"
#include "daemon/post/post.h"
#include "daemon/post/printed_path.h"
#include "daemon/post/tcp_start.h"
#include "kinematics/basics/decimal.h"
#include "kinematics/basics/tolerance_budget.h"
#include "kinematics/cl_text/cl_file.h"
#include "kinematics/joints/joint_path.h"
#include "kinematics/timing/tcp_path.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/mesh/stl.h"
#include "pathgen/plan/plan.h"

namespace tiltfeed::daemon {
namespace {

/// Wall time of the stages that are run here.
class StageClock {
 public:
  template <class Function>
  auto time(const char* stage, Function function) {
    const auto start = std::chrono::steady_clock::now();
    auto result = function();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const auto before = std::find_if(times.begin(), times.end(),
                                     [&](const pathgen::StageTime& one) { return one.stage == stage; });
    if (before != times.end())
      before->seconds += seconds;
    else
      times.push_back({stage, seconds});
    return result;
  }
  std::vector<pathgen::StageTime> times;
};

/// Also gives the program's words the decimals that the tolerance needs.
JointPathOptions joint_options(config::Job& job, const pathgen::Mesh& part) {
  const ToleranceBudget budget(job.plan.tolerance);
  JointPathOptions options;
  options.tolerance = job.axis_tolerance.radians() > 0.0 ? budget.joints_beside_pole() : budget.joints();
  options.reach = job.plan.cutter.shank_length;
  // What the axis may lean moves the shank's end by no more than the tip may stray; under TCP the words do so
  // once more.
  const double strays =
      job.machine.format.tcp ? std::min(options.tolerance, budget.joints_before_words()) : options.tolerance;
  const Angle lean = Angle::from_radians(strays / job.plan.cutter.shank_length);
  options.axis_tolerance = std::min(options.axis_tolerance, lean.degrees());
  job.machine.format = config::fine_enough(job.machine.format, options.tolerance, options.axis_tolerance);
  // Joints that become other words are kept finer than what is printed.
  options.linear_decimals = joint_decimals(job.machine.format);
  options.rotary_decimals = job.machine.format.rotary_decimals;
  options.clear = part_extent(part, job);
  return options;
}

/// The whole way, stage by stage.
class Planning {
 public:
  Planning(const PlanFiles& files, const PlanListener& listener) : files_(files), listener_(listener) {}
  /// What to tell the user.
  Result<std::string> run();

 private:
  Result<void> load();
  Result<void> plan_path();
  Result<void> open_program();
  Result<void> program();
  int tilt_side() const;
  Result<void> find_joints();
  Result<JointPath> joints_of(ToolPath& path, const JointPathOptions& options);
  Result<void> find_path_joints(const pathgen::Mesh& held, const JointPathOptions& options);
  Result<void> find_plane_joints(const std::vector<AxisRun>& ways, const pathgen::Mesh& held,
                                 const JointPathOptions& options);
  void time_joints(const JointPathOptions& options);
  Result<void> write();
  Result<void> write_others();
  Result<void> add(const std::string& path, const std::function<void(std::ostream&)>& write);
  Result<void> report();
  bool show(const char* stage, double share) { return !listener_.stage || listener_.stage(stage, share); }
  void note(const std::string& text) {
    if (listener_.note) listener_.note(text);
  }

  const PlanFiles& files_;
  const PlanListener& listener_;
  StageClock clock_;
  std::optional<config::Job> job_;
  pathgen::CheckedMesh part_;
  std::optional<pathgen::Mesh> held_;  ///< part and fixtures, where there are any
  pathgen::Plan planned_;
  std::optional<SingularityBendReport> bend_;
  JointPath joints_;
  std::vector<AxisRun> runs_;  ///< of joints_, each in a tilted plane; empty: the program is in none
  ToolPath printed_;           ///< with runs_: what the blocks' moves count
  std::optional<PlannedProgram> posted_;
  std::optional<StartTurn> turn_;
  Timing timing_;
  ProgramReport program_;
  std::optional<ProofFigures> proof_;
  std::vector<config::OutputFile> outputs_;  ///< the program first
  std::optional<ProofProcess> prover_;
  std::string told_;
};

Result<void> Planning::load() {
  const std::vector<config::NamedFile> outputs = outputs_of(files_);
  if (auto fits = config::check_outputs(
          outputs, {{"JOB", files_.job}, {"--stl", files_.stl}, {"--machine", files_.machine}});
      !fits)
    return fits;
  auto job = config::load_job_with(files_.job, {files_.stl, files_.machine});
  if (!job) return tl::unexpected(job.error());
  job_ = std::move(*job);
  if (files_.alone)
    if (auto whole = goes_alone(*job_); !whole) return whole;
  return config::check_outputs(outputs, config::files_of(*job_));
}

Result<void> Planning::plan_path() {
  show("read", 0.0);
  auto stl = clock_.time("read", [&] { return pathgen::read_stl(job_->stl_path, job_->stl_unit_mm); });
  if (!stl) return tl::unexpected(stl.error());
  show("check", 0.0);
  auto part = clock_.time("check", [&] {
    return pathgen::check_mesh(*stl, {ToleranceBudget(job_->plan.tolerance).repair()},
                               [&](double f) { return show("check", f); });
  });
  if (!part) return tl::unexpected(part.error());
  part_ = std::move(*part);
  note(size_text(part_.bounds));
  if (job_->machine.format.path_control == config::PathControl::kBlend)
    note("the control rounds corners off (G64) by " + decimal(job_->machine.format.blend_tolerance, 4) +
         " mm at most, which the plan leaves it of the tolerance");
  const std::optional<std::string> odd_unit = unit_warning(part_.bounds, *job_);
  if (odd_unit) note("warning: " + *odd_unit);
  *stl = pathgen::Stl{};  // gives its memory back; facets = {} would keep it
  job_->plan.find_rest_material = !files_.report.empty();
  auto fixtures = config::fixture_meshes(*job_);
  if (!fixtures) return tl::unexpected(fixtures.error());
  job_->plan.fixtures = std::move(*fixtures), job_->plan.fixture_room = config::fixture_room(*job_);
  if (job_->plan.fixtures) held_ = pathgen::joined(part_.mesh, job_->plan.fixtures->mesh);
  auto planned =
      pathgen::plan(part_, job_->plan, [&](const char* stage, double f) { return show(stage, f); });
  if (!planned) return tl::unexpected(planned.error());
  planned_ = std::move(*planned);
  if (odd_unit) planned_.report.warnings.push_back(*odd_unit);
  clock_.times.insert(clock_.times.end(), planned_.report.times.begin(), planned_.report.times.end());
  return {};
}

/// On which side of home the tilt leans most; 0: it stands at home.
int Planning::tilt_side() const {
  const RotaryAxis& tilt = job_->machine.model.tilt;
  double most = 0.0;
  for (const JointMove& move : joints_.moves)
    if (const double lean = move.joints.a - tilt.zero; std::abs(lean) > std::abs(most)) most = lean;
  return tilt.present ? (most > 0.0) - (most < 0.0) : 0;
}

/// Joints, text and proof. Where bodies of the machine come too near to the part or to fixtures the tilt may
/// stand on its other side: the tool goes the same way, the head and the table are turned round it.
Result<void> Planning::program() {
  const auto once = [&]() -> Result<void> {
    for (const auto stage : {&Planning::open_program, &Planning::find_joints, &Planning::write})
      if (auto done = (this->*stage)(); !done) return done;
    return {};
  };
  auto first = once();
  const int side = tilt_side();
  const std::string collision = prover_ ? prover_->collision() : "";
  if (first || collision.empty() || side == 0 || joints_.report.reconfigurations > 0) return first;
  outputs_.clear();
  prover_.reset();
  job_->machine.model.preferred_tilt = -side;
  note("bodies come too near to each other; the tilt is tried on its other side");
  const auto second = once();
  if (!second) return second.error().code == Code::kCancelled ? second : first;
  if (tilt_side() == side) return first;
  planned_.report.warnings.push_back(
      "the tilt stands on its other side. On the side that was taken first these come too near: " +
      collision);
  return {};
}

/// The prover takes in the part while joints are found and blocks are printed.
Result<void> Planning::open_program() {
  auto file = config::OutputFile::open(files_.program);
  if (!file) return tl::unexpected(file.error());
  outputs_.push_back(std::move(*file));
  if (!files_.prove) return {};
  auto started =
      ProofProcess::start({files_.job, files_.stl, files_.machine, files_.program, files_.gouge_picture},
                          outputs_.back().descriptor());
  if (!started) return tl::unexpected(started.error());
  prover_.emplace(std::move(*started));
  return {};
}

Result<void> Planning::find_joints() {
  if (!bend_) bend_ = clock_.time("pole", [&] { return bend_near_singularity(*job_, part_, planned_.path); });
  const pathgen::Mesh& held = held_ ? *held_ : part_.mesh;
  const bool asked = job_->machine.format.tilted_planes;
  const auto ways = asked ? axis_runs(planned_.path) : std::nullopt;
  if (asked && !ways)
    note(
        "no tilted planes: a rotary turns in a cut, and the program is posted as if the profile did not ask "
        "for them");
  if (ways) job_->machine.format = config::in_tilted_planes(job_->machine.format);
  job_->machine.format.tilted_planes = ways.has_value();
  const JointPathOptions options = joint_options(*job_, held);
  const auto found = clock_.time("joints", [&] {
    return ways ? find_plane_joints(*ways, held, options) : find_path_joints(held, options);
  });
  if (!found) return found;
  turn_ = start_turn(held, *job_, joints_.moves.front().joints);
  time_joints(options);
  return {};
}

Result<JointPath> Planning::joints_of(ToolPath& path, const JointPathOptions& options) {
  if (!show("joints", 0.0)) return fail(Code::kCancelled, "cancelled; nothing was written");
  return to_joints(path, job_->machine.model, job_->setup, options,
                   [&](double f) { return show("joints", f); });
}

Result<void> Planning::find_path_joints(const pathgen::Mesh& held, const JointPathOptions& options) {
  planned_.report.rapid_length += add_end_ways(planned_.path, held, *job_);
  auto joints = joints_of(planned_.path, options);
  if (!joints) return tl::unexpected(joints.error());
  joints_ = std::move(*joints);
  if (joints_.reconfigured) planned_.path = std::move(*joints_.reconfigured);
  return {};
}

/// Each run of one axis by itself, with ways along the tool at its ends.
Result<void> Planning::find_plane_joints(const std::vector<AxisRun>& ways, const pathgen::Mesh& held,
                                         const JointPathOptions& stated) {
  JointPathOptions options = stated;
  options.clear = {};  // no rotary turns within a run
  PlaneJoints joints(job_->machine.model);
  printed_ = {
      planned_.path.name, planned_.path.tool, planned_.path.cut_feed, planned_.path.plunge_feed, {}, {}};
  for (const AxisRun& run : ways) {
    ToolPath part = part_of(planned_.path, run);
    add_end_ways(part, held, *job_);
    auto found = joints_of(part, options);
    if (!found) return tl::unexpected(found.error());
    joints.add(*found, printed_.moves.size());
    printed_.moves.insert(printed_.moves.end(), part.moves.begin(), part.moves.end());
  }
  joints_ = std::move(joints.path);
  runs_ = std::move(joints.runs);
  // The CL file has the path as one, for other machines.
  planned_.report.rapid_length += add_end_ways(planned_.path, held, *job_);
  return {};
}

void Planning::time_joints(const JointPathOptions& options) {
  timing_ = clock_.time("timing", [&] {
    const config::ProgramFormat& format = job_->machine.format;
    std::vector<JointMove> started = start_moves(job_->machine, job_->setup, joints_.moves);
    const std::size_t before = started.empty() ? 0 : started.size() - 1;
    if (before > 0) started.insert(started.end(), joints_.moves.begin() + 1, joints_.moves.end());
    Timing timing =
        time_blocks(before > 0 ? started : joints_.moves, job_->machine.model,
                    rounded_off_by(format, options.tolerance), options.axis_tolerance, corners_of(format));
    // Of the blocks of the path alone.
    timing.durations.erase(timing.durations.begin(),
                           timing.durations.begin() + static_cast<std::ptrdiff_t>(before));
    return timing;
  });
}

Result<void> Planning::write() {
  config::OutputFile& out = outputs_.front();
  if (!show("write", 0.0)) return fail(Code::kCancelled, "cancelled; nothing was written");
  const HeaderFacts header{std::string(files_.prove ? kNotProvenYet : kNoProof), timing_.seconds,
                           turn_ ? start_turn_comment(*turn_, *job_) : ""};
  auto written = clock_.time("write", [&]() -> Result<ProgramReport> {
    posted_ = planned_program(joints_, runs_, *job_, header);
    auto blocks = write_program(posted_->posting, out.stream(), [&](double f) { return show("write", f); });
    if (auto flushed = out.flush(); !flushed) return tl::unexpected(flushed.error());
    return blocks;
  });
  if (!written) return tl::unexpected(written.error());
  program_ = *written;
  if (!prover_) return {};
  auto proven =
      clock_.time("proof", [&] { return prover_->finish([&](double f) { return show("proof", f); }); });
  if (!proven) {
    std::string advice;
    if (turn_)
      advice = start_turn_advice(*turn_, *job_, head_of(out), proven.error().message, files_.program);
    return fail(proven.error().code, proven.error().message + advice);
  }
  proof_ = *proven;
  // The first block states where the axes are.
  if (proof_->moves + 1 < program_.blocks)
    return fail(Code::kInput, "not proven, nothing was written: " + std::to_string(program_.blocks) +
                                  " blocks were printed and " + std::to_string(proof_->moves) +
                                  " moves read");
  return state_figures(out, *proof_);
}

Result<void> Planning::add(const std::string& path, const std::function<void(std::ostream&)>& write) {
  if (path.empty()) return {};
  auto file = config::OutputFile::open(path);
  if (!file) return tl::unexpected(file.error());
  write(file->stream());
  outputs_.push_back(std::move(*file));
  return outputs_.back().flush();
}

Result<void> Planning::write_others() {
  auto cl = clock_.time(
      "cl file", [&] { return add(files_.cl, [&](std::ostream& out) { write_cl(planned_.path, out); }); });
  if (!cl) return cl;
  if (auto map = add(files_.map,
                     [&](std::ostream& out) {
                       write_block_map(posted_->posting, runs_.empty() ? planned_.path : printed_, out);
                     });
      !map)
    return map;
  return add(files_.drawing, [&](std::ostream& out) {
    write_path_drawing(joints_, timing_.durations, job_->machine.model, job_->setup, out);
  });
}

Result<void> Planning::report() {
  rusage usage{}, proof_usage{};
  getrusage(RUSAGE_SELF, &usage);
  getrusage(RUSAGE_CHILDREN, &proof_usage);
  const auto seconds = [](timeval t) {
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6;
  };
  const PlanOutcome outcome{*job_,
                            part_,
                            planned_.report,
                            *bend_,
                            joints_.report,
                            program_,
                            timing_,
                            starved(timing_, job_->machine, program_),
                            proof_,
                            turn_,
                            clock_.times,
                            seconds(usage.ru_utime) + seconds(usage.ru_stime) +
                                seconds(proof_usage.ru_utime) + seconds(proof_usage.ru_stime),
                            static_cast<double>(usage.ru_maxrss) / 1024.0};
  if (auto added = add(files_.report, [&](std::ostream& out) { out << report_json(outcome); }); !added)
    return added;
  if (auto kept = config::OutputFile::commit_all(outputs_); !kept) return kept;
  show("done", 1.0);
  told_ = files_.as_json ? report_json(outcome) : report_text(outcome);
  return {};
}

Result<std::string> Planning::run() {
  for (const auto stage : {&Planning::load, &Planning::plan_path, &Planning::program, &Planning::write_others,
                           &Planning::report})
    if (auto done = (this->*stage)(); !done) return tl::unexpected(done.error());
  return told_;
}

}  // namespace

std::vector<config::NamedFile> outputs_of(const PlanFiles& files) {
  return {{"--out", files.program}, {"--cl", files.cl},           {"--report", files.report},
          {"--map", files.map},     {"--drawing", files.drawing}, {"--gouge-picture", files.gouge_picture}};
}

Result<void> goes_alone(const config::Job& job) {
  for (const config::Fixture& fixture : job.fixtures)
    if (fixture.shape.kind == config::SolidKind::kStl)
      return fail(Code::kInput, job.path + ": the file of fixture '" + fixture.name +
                                    "' does not go to the service with it: state it as boxes, cylinders or "
                                    "cones, or plan the job where its file is and submit its program");
  return {};
}

Result<std::string> plan_program(const PlanFiles& files, const PlanListener& listener) {
  return Planning(files, listener).run();
}

}  // namespace tiltfeed::daemon
