#include "daemon/plan/plan_program.h"

#include <sys/resource.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "config/job_inputs.h"
#include "config/part_reading.h"
#include "daemon/plan/avoidance.h"
#include "daemon/plan/engaged_feeds.h"
#include "daemon/plan/header_figures.h"
#include "daemon/plan/operation_plan.h"
#include "daemon/plan/operations_before.h"
#include "daemon/plan/part_size.h"
#include "daemon/plan/path_drawing.h"
#include "daemon/plan/plan_report.h"
#include "daemon/plan/plan_text.h"
#include "daemon/plan/proof_process.h"
#include "daemon/plan/shortest_time.h"
#include "daemon/plan/stock_contacts.h"
#include "daemon/post/block_map.h"
#include "kinematics/basics/decimal.h"
#include "kinematics/basics/tolerance_budget.h"
#include "kinematics/cl_text/cl_file.h"
#include "pathgen/part_file/part_model.h"

namespace tiltfeed::daemon {
namespace {

/// `name`: of the operation; empty: the job is one.
Error in_operation(Error error, const std::string& name) {
  if (!name.empty()) error.message = "operation " + name + ": " + error.message;
  return error;
}

/// What the CL file says of an operation.
ClOperation cl_operation(const OperationPlan& plan) {
  const config::Job& job = plan.job();
  const config::Coolant coolant = job.program.coolant;
  return {&plan.cl_path(), std::max(job.program.tool, 1), job.program.length_register, job.spindle_rpm,
          coolant == config::Coolant::kOff ? 0.0 : coolant_value(coolant)};
}

/// The whole way, stage by stage.
class Planning {
 public:
  Planning(const PlanFiles& files, const PlanListener& told) : files_(files), told_(told) {}
  /// What to tell the user.
  Result<std::string> run();

 private:
  Result<void> load();
  Result<std::shared_ptr<const pathgen::CheckedMesh>> part_of(const config::Job& job);
  const pathgen::PartModel& model_of(const config::Job& job) const {
    return models_.at(ToleranceBudget(job.plan.tolerance).repair());
  }
  Result<void> plan_paths();
  Result<void> plan_path(OperationPlan& one, bool rest);
  Result<void> keep_rest_quick(std::unique_ptr<OperationPlan>& one, bool rest);
  Result<void> shorten_operations();
  Result<void> program();
  Result<void> open_program();
  Result<void> find_joints();
  Result<void> write();
  Result<void> prove();
  Result<void> follow_engagement();
  Result<MeasuredEngagement> measure();
  Result<void> find_contacts();
  Result<void> write_others();
  Result<void> add(const std::string& path, const std::function<void(std::ostream&)>& write);
  Result<void> report();
  const config::Job& job() const { return operations_.front()->job(); }
  /// Is an operation planned by what those before it leave?
  bool leaves_to_others() const {
    return std::any_of(operations_.begin() + 1, operations_.end(),
                       [](const auto& one) { return knows_others(one->job()); });
  }

  const PlanFiles& files_;
  const PlanListener& told_;
  StageClock clock_;
  std::vector<std::unique_ptr<OperationPlan>> operations_;        ///< in their order
  std::vector<std::unique_ptr<OperationPlan>> before_;            ///< planned for what they leave alone
  std::vector<std::shared_ptr<const pathgen::EarlierCut>> cuts_;  ///< of all that are planned, in order
  std::map<double, std::shared_ptr<const pathgen::CheckedMesh>> parts_;  ///< by the share of repair, mm
  std::map<double, pathgen::PartModel> models_;                          ///< likewise, without facets
  std::optional<PlannedProgram> posted_;
  Timing timing_;                              ///< of all operations, one after the other
  std::vector<ShortenedOperation> shortened_;  ///< by operation; empty: not asked
  std::vector<FollowedFeeds> feeds_;           ///< likewise
  ProgramReport program_;
  std::optional<ProofFigures> proof_;
  std::optional<Avoidance> avoidance_;
  std::vector<config::OutputFile> outputs_;  ///< the program first
  std::optional<ProofProcess> prover_;
  std::string what_was_done_;
};

Result<void> Planning::load() {
  const std::vector<config::NamedFile> outputs = outputs_of(files_);
  if (auto fits = config::check_outputs(
          outputs, {{"JOB", files_.job}, {"--stl", files_.stl}, {"--machine", files_.machine}});
      !fits)
    return fits;
  const config::JobFiles from{.stl = files_.stl,
                              .machine = files_.machine,
                              .operation = files_.operation,
                              .closed = files_.alone || files_.closed};
  auto jobs = config::load_operations(files_.job, from);
  if (!jobs) return tl::unexpected(jobs.error());
  auto before = operations_before(files_.job, from, jobs->front());
  if (!before) return tl::unexpected(before.error());
  for (config::Job& job : *before)
    before_.push_back(std::make_unique<OperationPlan>(std::move(job), clock_, told_));
  // What arcs leave the straight blocks by; who judges the text has it with the rest.
  for (config::Job& job : *jobs) job.plan.tolerance -= job.program.arc_tolerance;
  for (config::Job& job : *jobs)
    operations_.push_back(std::make_unique<OperationPlan>(std::move(job), clock_, told_));
  if (files_.closed)
    for (const config::MachineBody& body : job().machine.solid.bodies)
      if (body.shape.kind == config::SolidKind::kStl)
        return fail(Code::kInput, job().machine.path + ": the file of body '" + body.name +
                                      "' is not here: plan at the machine itself");
  for (const auto& one : operations_)
    if (auto fits = config::check_outputs(outputs, config::files_of(one->job())); !fits) return fits;
  return {};
}

/// The same mesh for all operations of one tolerance.
Result<std::shared_ptr<const pathgen::CheckedMesh>> Planning::part_of(const config::Job& job) {
  const double repair = ToleranceBudget(job.plan.tolerance).repair();
  std::shared_ptr<const pathgen::CheckedMesh>& known = parts_[repair];
  if (known) return known;
  told_.show("read", 0.0);
  auto model = clock_.time(
      "read", [&] { return config::read_part_model(job, [&](double f) { return told_.show("read", f); }); });
  if (!model) return tl::unexpected(model.error());
  told_.show("check", 0.0);
  auto part = clock_.time("check", [&] {
    return config::check_part(job, *model, [&](double f) { return told_.show("check", f); });
  });
  if (!part) return tl::unexpected(part.error());
  for (const std::string& text : pathgen::notes_on(*model)) told_.say(text);
  models_.insert_or_assign(repair, std::move(*model));
  known = std::make_shared<const pathgen::CheckedMesh>(std::move(*part));
  return known;
}

/// The path of the next operation, which knows what those before it cut.
Result<void> Planning::plan_path(OperationPlan& one, bool rest) {
  const std::string& name = one.job().operation.name;
  auto part = part_of(one.job());
  if (!part) return tl::unexpected(part.error());
  one.follow(cuts_);
  if (auto planned = one.plan_path(*part, model_of(one.job()), rest); !planned)
    return tl::unexpected(in_operation(planned.error(), name));
  return {};
}

/// Where ways between what is left take the machine longer than the air would, all of the passes are cut.
Result<void> Planning::keep_rest_quick(std::unique_ptr<OperationPlan>& one, bool rest) {
  const std::optional<pathgen::RestBefore> before = one->report().rest;
  const pathgen::PatternKind kind = one->job().plan.pattern.kind;
  if (!before || before->whole == 0.0 || kind == pathgen::PatternKind::kRough) return {};
  // Limits and collisions are told later, of the plan that is taken.
  if (!one->find_joints()) return {};
  const double seconds = one->timing().seconds;
  if (seconds * one->job().plan.cut_feed.mm_per_min() <= 60.0 * before->whole) return {};
  const auto part = part_of(one->job());
  if (!part) return tl::unexpected(part.error());
  config::Job job = one->job();
  job.plan.rest_everywhere = true;
  auto all = std::make_unique<OperationPlan>(std::move(job), clock_, told_);
  all->follow(cuts_);
  const auto planned = all->plan_path(*part, model_of(one->job()), rest);
  if (!planned && planned.error().code == Code::kCancelled) return planned;
  if (!planned || !all->find_joints() || all->timing().seconds >= seconds) return {};
  all->found_before(*before);
  all->warn("rest.more_than_mm: the passes over what is left would take the machine " +
            decimal(seconds / 60.0, 1) + " min, with all the ways between them; the whole passes take " +
            decimal(all->timing().seconds / 60.0, 1) + " min, and are taken");
  one = std::move(all);
  return {};
}

Result<void> Planning::plan_paths() {
  std::optional<std::string> odd_unit;
  for (const auto& one : before_) {
    told_.say("operation " + one->job().operation.name + ", for what it leaves");
    if (auto planned = plan_path(*one, false); !planned) return planned;
    cuts_.push_back(one->as_earlier_cut());
  }
  for (auto& one : operations_) {
    auto part = part_of(one->job());
    if (!part) return tl::unexpected(part.error());
    if (one == operations_.front()) {
      told_.say(size_text((*part)->bounds));
      if (job().machine.format.path_control == config::PathControl::kBlend)
        told_.say("the control rounds corners off (G64) by " +
                  decimal(job().machine.format.blend_tolerance, 4) +
                  " mm at most, which the plan leaves it of the tolerance");
      odd_unit = unit_warning((*part)->bounds, job());
      if (odd_unit) told_.say("warning: " + *odd_unit);
    }
    const std::string& name = one->job().operation.name;
    if (!name.empty()) told_.say("operation " + name);
    const bool rest = !files_.report.empty() || files_.shortest_time;
    if (auto planned = plan_path(*one, rest); !planned) return planned;
    if (auto kept = keep_rest_quick(one, rest); !kept) return kept;
    if (leaves_to_others()) cuts_.push_back(one->as_earlier_cut());
  }
  if (odd_unit) operations_.front()->warn(*odd_unit);
  return {};
}

/// Of each operation the pattern that takes the machine the least time.
Result<void> Planning::shorten_operations() {
  if (!files_.shortest_time) return {};
  cuts_.resize(before_.size());
  for (auto& one : operations_) {
    const std::string& name = one->job().operation.name;
    // Those before it may have become others.
    if (knows_others(one->job()) && !cuts_.empty()) {
      config::Job job = one->job();
      job.plan.rest_everywhere = false;
      one = std::make_unique<OperationPlan>(std::move(job), clock_, told_);
      if (auto planned = plan_path(*one, true); !planned) return planned;
      if (auto kept = keep_rest_quick(one, true); !kept) return kept;
    }
    if (auto found = one->find_joints(); !found) return tl::unexpected(in_operation(found.error(), name));
    const auto part = part_of(one->job());
    if (!part) return tl::unexpected(part.error());
    std::size_t plans = 0;
    const PlanOnce once = [&](const config::Job& job, bool rest) -> std::unique_ptr<OperationPlan> {
      told_.say("shortest time: plan " + std::to_string(++plans) + " of " + std::to_string(kMostTried) +
                " at most");
      auto plan = std::make_unique<OperationPlan>(job, clock_, told_);
      plan->follow(cuts_);
      if (!plan->plan_path(*part, model_of(job), rest) || !plan->find_joints()) return nullptr;
      return plan;
    };
    Shortened found = shorten(*one, once);
    if (!told_.show("shortest time", 1.0)) return fail(Code::kCancelled, "cancelled; nothing was written");
    shortened_.push_back({one->timing().seconds, found.tried, {}, {}, 0.0, {}, 0, false});
    shortened_.back().own_ridges =
        has_ridges(one->job().plan) && one->job().plan.pattern.optimise_scallop == 0.0;
    if (found.plan) {
      shortened_.back().join_distance = found.plan->job().plan.links.join_distance;
      if (one->job().plan.links.rounds == 0) shortened_.back().rounds = found.plan->job().plan.links.rounds;
      if (one->job().calm.radians() == 0.0) shortened_.back().calm = found.plan->job().calm;
      const pathgen::AxisFrame &before = one->job().plan.axis, &now = found.plan->job().plan.axis;
      if (now.n != before.n || now.t != before.t) shortened_.back().frame = now;
      pathgen::Pattern& pattern = shortened_.back().pattern.emplace(found.plan->job().plan.pattern);
      if (pattern.measure == pathgen::StepMeasure::kRidge) pattern.scallop = found.plan->plan_report().ridge;
      one = std::move(found.plan);
    }
    if (leaves_to_others()) cuts_.push_back(one->as_earlier_cut());
  }
  return {};
}

/// Joints, text and proof. Where bodies come too near to each other it is planned anew.
Result<void> Planning::program() {
  const auto once = [&]() -> Result<void> {
    outputs_.clear();
    prover_.reset();
    for (const auto stage :
         {&Planning::open_program, &Planning::find_joints, &Planning::write, &Planning::prove})
      if (auto done = (this->*stage)(); !done) return done;
    return {};
  };
  const auto done =
      avoid_collisions(operations_, {once, [&] { return prover_ ? &*prover_ : nullptr; }}, told_, avoidance_);
  if (done && avoidance_) operations_.front()->warn(avoidance_text(*avoidance_));
  return done;
}

/// The prover takes in the part while joints are found and blocks are printed.
Result<void> Planning::open_program() {
  auto file = config::OutputFile::open(files_.program);
  if (!file) return tl::unexpected(file.error());
  outputs_.push_back(std::move(*file));
  if (!files_.prove) return {};
  auto started = ProofProcess::start(
      {files_.job, files_.stl, files_.machine, files_.operation, files_.program, files_.gouge_picture},
      outputs_.back().descriptor());
  if (!started) return tl::unexpected(started.error());
  prover_.emplace(std::move(*started));
  return {};
}

Result<void> Planning::find_joints() {
  std::vector<const Timing*> times;
  std::optional<Joints> from;
  for (const auto& one : operations_) {
    one->come_from(from);
    if (auto found = one->find_joints(); !found)
      return tl::unexpected(in_operation(found.error(), one->job().operation.name));
    times.push_back(&one->timing());
    from = one->joints().moves.back().joints;
  }
  timing_ = one_after_the_other(times);
  return {};
}

Result<void> Planning::write() {
  config::OutputFile& out = outputs_.front();
  if (!told_.show("write", 0.0)) return fail(Code::kCancelled, "cancelled; nothing was written");
  const std::optional<StartTurn>& turn = operations_.front()->turn();
  const HeaderFacts header{std::string(files_.prove ? kNotProvenYet : kNoProof), timing_.seconds,
                           turn ? start_turn_comment(*turn, job()) : ""};
  auto written = clock_.time("write", [&]() -> Result<ProgramReport> {
    posted_ = operations_.front()->posted(header);
    for (std::size_t i = 1; i < operations_.size(); ++i) posted_->add(operations_[i]->posted(header));
    auto blocks =
        write_program(posted_->posting, out.stream(), [&](double f) { return told_.show("write", f); });
    if (auto flushed = out.flush(); !flushed) return tl::unexpected(flushed.error());
    return blocks;
  });
  if (!written) return tl::unexpected(written.error());
  program_ = *written;
  return {};
}

Result<void> Planning::prove() {
  if (!prover_) return {};
  config::OutputFile& out = outputs_.front();
  auto proven =
      clock_.time("proof", [&] { return prover_->finish([&](double f) { return told_.show("proof", f); }); });
  if (!proven) {
    std::string advice;
    if (const std::optional<StartTurn>& turn = operations_.front()->turn())
      advice = start_turn_advice(*turn, job(), head_of(out), proven.error().message, files_.program);
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

Result<MeasuredEngagement> Planning::measure() {
  return clock_.time("engagement", [&] {
    return measure_engagement({files_.job, files_.stl, files_.machine, files_.operation, files_.stock},
                              outputs_.front().descriptor(),
                              [&](double f) { return told_.show("engagement", f); });
  });
}

/// Feeds of cuts by what the cutter has to do, until no load is larger than at the job's own feeds.
Result<void> Planning::follow_engagement() {
  if (!files_.engaged_feeds) return {};
  std::vector<OperationPlan*> plans;
  for (const auto& one : operations_) plans.push_back(one.get());
  if (auto can = feeds_can_follow({plans.begin(), plans.end()}); !can) return can;
  const auto before = measure();
  if (!before) return tl::unexpected(before.error());
  EngagedFeeds feeds(plans, *posted_, *before);
  for (bool holds = false; !holds;) {
    feeds.apply(seconds_on_link(job().machine, program_));
    outputs_.clear(), prover_.reset(), posted_.reset();
    for (const auto stage : {&Planning::open_program, &Planning::find_joints, &Planning::write})
      if (auto done = (this->*stage)(); !done) return done;
    const auto now = measure();
    if (!now) return tl::unexpected(now.error());
    holds = feeds.holds(*posted_, *now);
  }
  feeds_ = feeds.found();
  return prove();
}

/// Of the program as it is: what shank and holder meet of the stock.
Result<void> Planning::find_contacts() { return find_stock_contacts(before_, operations_, clock_, told_); }

Result<void> Planning::add(const std::string& path, const std::function<void(std::ostream&)>& write) {
  if (path.empty()) return {};
  auto file = config::OutputFile::open(path);
  if (!file) return tl::unexpected(file.error());
  write(file->stream());
  outputs_.push_back(std::move(*file));
  return outputs_.back().flush();
}

Result<void> Planning::write_others() {
  auto cl = clock_.time("cl file", [&] {
    std::vector<ClOperation> paths;
    for (const auto& one : operations_) paths.push_back(cl_operation(*one));
    return add(files_.cl, [&](std::ostream& out) { write_cl(paths, out); });
  });
  if (!cl) return cl;
  if (auto map = add(files_.map,
                     [&](std::ostream& out) {
                       std::vector<const ToolPath*> paths;
                       for (const auto& one : operations_) paths.push_back(&one->block_path());
                       write_block_map(posted_->posting, paths, out);
                     });
      !map)
    return map;
  return add(files_.drawing, [&](std::ostream& out) {
    double seconds = 0.0;
    for (const auto& one : operations_)
      seconds = write_path_drawing(one->joints(), one->timing().durations, one->job().machine.model,
                                   one->job().setup, seconds, out);
  });
}

Result<void> Planning::report() {
  rusage usage{}, proof_usage{};
  getrusage(RUSAGE_SELF, &usage);
  getrusage(RUSAGE_CHILDREN, &proof_usage);
  const auto seconds = [](timeval t) {
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6;
  };
  PlanOutcome outcome{{},
                      model_of(job()),
                      operations_.front()->part(),
                      program_,
                      timing_,
                      starved(timing_, job().machine, program_),
                      proof_,
                      avoidance_,
                      shortened_,
                      feeds_,
                      clock_.times,
                      seconds(usage.ru_utime) + seconds(usage.ru_stime) + seconds(proof_usage.ru_utime) +
                          seconds(proof_usage.ru_stime),
                      static_cast<double>(usage.ru_maxrss) / 1024.0};
  for (const auto& one : operations_) outcome.operations.push_back(one.get());
  if (auto added = add(files_.report, [&](std::ostream& out) { out << report_json(outcome); }); !added)
    return added;
  if (auto kept = config::OutputFile::commit_all(outputs_); !kept) return kept;
  told_.show("done", 1.0);
  what_was_done_ = files_.as_json ? report_json(outcome) : report_text(outcome);
  return {};
}

Result<std::string> Planning::run() {
  for (const auto stage :
       {&Planning::load, &Planning::plan_paths, &Planning::shorten_operations, &Planning::program,
        &Planning::follow_engagement, &Planning::find_contacts, &Planning::write_others, &Planning::report})
    if (auto done = (this->*stage)(); !done) return tl::unexpected(done.error());
  return what_was_done_;
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
  if (job.blank && job.blank->shape == config::BlankShape::kFile)
    return fail(Code::kInput,
                job.path +
                    ": the file of the blank does not go to the service with it: state it as a box "
                    "or cylinder, or plan the job where its file is and submit its program");
  return {};
}

Result<std::string> plan_program(const PlanFiles& files, const PlanListener& listener) {
  return Planning(files, listener).run();
}

}  // namespace tiltfeed::daemon
