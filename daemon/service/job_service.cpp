#include "daemon/service/job_service.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/machine/advice.h"
#include "daemon/machine/order_mark.h"
#include "daemon/service/job_origin.h"
#include "daemon/service/run_place.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

std::string reply(const ordered_json& json) {
  return json.dump(-1, ' ', true, ordered_json::error_handler_t::replace) + "\n";
}

ordered_json good() { return {{"v", kApiVersion}, {"ok", true}}; }

std::string text_of(const ordered_json& json) {
  return json.dump(-1, ' ', true, ordered_json::error_handler_t::replace);
}

/// The controller may still have blocks of it.
bool may_be_held(const SpooledJob& job) {
  return job.state == JobState::kInterrupted || job.state == JobState::kUncertain;
}

double tenth(double seconds) { return std::round(seconds * 10.0) / 10.0; }

/// With what holds only until the table has it.
std::string shown_note(const SpooledJob& job) {
  if (job.unsaved.empty()) return job.note;
  return job.note + (job.note.empty() ? "" : "; ") + "not in the spool yet: " + job.unsaved;
}

}  // namespace

JobService::JobService(const config::ServiceConfig& config, const LinkSpec& link, MachineClaim claim,
                       Spool spool, std::function<void()> alive)
    : config_(config),
      link_(link),
      claim_(std::move(claim)),
      spool_(std::move(spool)),
      help_(config.spool),
      runner_(std::make_unique<StreamThread>(std::move(alive))) {}

Result<JobService> JobService::open(const config::ServiceConfig& config, std::function<void()> alive) {
  const Result<LinkSpec> link = parse_link(config.link, config.machine.wire, &config.machine.model);
  if (!link) return tl::unexpected<Error>(link.error());
  MachineClaim claim;
  if (const Result<void> claimed = claim.follow(*link); !claimed)
    return tl::unexpected<Error>(claimed.error());
  Result<Spool> spool = Spool::open(config.spool);
  if (!spool) return tl::unexpected<Error>(spool.error());
  JobService jobs(config, *link, std::move(claim), std::move(*spool), std::move(alive));
  if (const Result<void> settled = jobs.settle(); !settled) return tl::unexpected<Error>(settled.error());
  if (const Result<void> ended = jobs.spool_.end_lost_runs(); !ended)
    return tl::unexpected<Error>(ended.error());
  jobs.tell_mark();
  return jobs;
}

/// A command that the service before this one did not see to its end.
void JobService::tell_mark() const {
  const auto marked = marked_order(config_.spool);
  if (!marked) return;
  log(Severity::kWarning, 0,
      "the service before this one ended while a machine command was in work (" + marked->text +
          "): look at the machine; " + still_advice(link_.kind));
  clear_order_mark(config_.spool);
}

Result<void> JobService::reload(const config::ServiceConfig& config) {
  const Result<LinkSpec> link = parse_link(config.link, config.machine.wire, &config.machine.model);
  if (!link) return tl::unexpected<Error>(link.error());
  if (config.spool != config_.spool || config.socket != config_.socket ||
      config.queue.url != config_.queue.url)
    return fail(Code::kUsage, config.path + ": spool, socket and queue change with a restart only");
  if (busy() && config.link != config_.link)
    return fail(Code::kUsage,
                config.path + ": link changes when nothing is on the machine; nothing is changed");
  if (const Result<void> claimed = claim_.follow(*link); !claimed) return claimed;
  config_ = config;
  link_ = *link;
  outdated_.clear();
  tidy_due_ = {};  // by the new limits
  return {};
}

void JobService::log(Severity severity, std::uint64_t job, const std::string& text,
                     std::uint64_t block) const {
  LogFields fields;
  fields.machine = config_.machine.model.name;
  fields.job = job;
  fields.block = block;
  write_log(severity, text, fields);
}

Result<void> JobService::keep(SpooledJob job, JobState state, const std::string& note) {
  job.state = state;
  job.note = note;
  if (const Result<void> updated = spool_.update(job); !updated) return updated;
  const bool bad =
      state == JobState::kFailed || state == JobState::kUncertain || state == JobState::kInterrupted;
  end_run(job, note);
  note_settled(job);
  log(bad ? Severity::kWarning : Severity::kInfo, job.id,
      std::string(state_name(state)) + (note.empty() ? "" : ": " + note), job.executed);
  return {};
}

/// It is so already: where it cannot be written it is remembered, and told all the same.
void JobService::set(const SpooledJob& job, JobState state, const std::string& note) {
  const Result<void> kept = keep(job, state, note);
  if (kept) return;
  SpooledJob now = job;
  now.state = state;
  now.note = note;
  now.unsaved = kept.error().message;
  spool_.remember(now);
  end_run(now, note);
  note_settled(now);
  log(Severity::kError, job.id, std::string(state_name(state)) + ": " + shown_note(now));
}

void JobService::note_request(const ApiRequest& request, std::uint32_t user) const {
  const bool follows = request.op == ApiOp::kMachine && request.order != 0 && !request.stop;
  if (request.op == ApiOp::kList || request.op == ApiOp::kShow || request.op == ApiOp::kHistory || follows)
    return;
  LogFields fields;
  fields.machine = config_.machine.model.name;
  fields.job = request.job;
  fields.block = request.from.value_or(0);
  fields.user = user;
  fields.by_user = true;
  std::string asked = write_request(request);
  asked.pop_back();
  write_log(Severity::kInfo, "asks " + asked, fields);
}

std::optional<std::string> JobService::order(const ApiRequest& request) {
  OperatorCommand command{Order::kHold};
  switch (request.op) {
    case ApiOp::kHold:
      break;
    case ApiOp::kStop:
      command = {Order::kStop};
      break;
    case ApiOp::kOverride: {
      command = {Order::kFeedOverride, request.percent};
      const RunView view = runner_->view();
      const Result<void> can = can_override(command, view);
      if (!can && view.job == request.job && !view.ended) return write_refusal(can.error());
      break;
    }
    case ApiOp::kResume:
      command = {Order::kResume};
      if (!request.from) break;
      return std::nullopt;
    default:
      return std::nullopt;
  }
  if (!runner_->command(request.job, command)) return std::nullopt;
  return write_text(told());
}

void JobService::ask(const ApiRequest& request, std::uint32_t user, HandedFiles files,
                     std::function<void(std::string)> reply) {
  note_request(request, user);
  const Done done = [this, number = request.job, reply = std::move(reply)](Result<std::string> answer) {
    if (!answer) log(Severity::kWarning, number, answer.error().message);
    reply(answer ? *answer : write_refusal(answer.error()));
  };
  if (request.op == ApiOp::kSubmit) {
    SpooledJob job;
    job.name = request.name;
    job.program = request.program;
    job.user = user;
    return arrivals_.add(std::move(job), std::move(files), done);
  }
  if (request.op == ApiOp::kList) return done(list(request.job));
  if (request.op == ApiOp::kHistory) return done(history(request.job, request.from.value_or(0)));
  if (request.op == ApiOp::kReset) return done(reset(request));
  if (request.op == ApiOp::kMachine) return done(machine(request));
  const bool ends = request.op == ApiOp::kHold || request.op == ApiOp::kStop;
  if (ends && request.job == 0 && worker_->busy())
    return worker_->stop(), done(write_text(worker_->name() + " is told to end"));
  const Result<SpooledJob> job = request.job == 0 ? job_on_machine() : spool_.find(request.job);
  if (!job) return done(tl::unexpected<Error>(job.error()));
  if (request.op == ApiOp::kShow) return show(*job, request, done);
  if (request.op == ApiOp::kStart || request.op == ApiOp::kResume || request.op == ApiOp::kTool)
    asked_by_[job->id] = user;
  if (request.op == ApiOp::kStart) return start(*job, request.queue, done);
  if (request.op == ApiOp::kResume) return resume(*job, request, user, done);
  if (request.op == ApiOp::kTool) return tool(*job, request, done);
  done(act(*job, request));
}

Result<std::string> JobService::list(std::uint64_t after) const {
  constexpr std::size_t kPage = 1000;
  const auto jobs = spool_.page(after, kPage);
  if (!jobs) return tl::unexpected<Error>(jobs.error());
  ordered_json json = good();
  json["machine"] = config_.machine.model.name;
  json["link"] = describe(link_);
  if (!config_.queue.url.empty()) json["shop"] = shop_text_;
  json["at_work"] = is_at_work() || plan_.runs();
  json["counts"] = ordered_json::parse(counts_json());
  json["jobs"] = ordered_json::array();
  const std::vector<std::uint64_t> waiting = queue();
  for (const SpooledJob& job : *jobs) json["jobs"].push_back(ordered_json::parse(job_json(job, waiting)));
  if (jobs->size() == kPage) json["more"] = true;
  if (reset_.valid() || !reset_text_.empty())
    json["reset"] = reset_.valid() ? std::string("in work") : reset_text_;
  return reply(json);
}

/// What is done at once.
Result<std::string> JobService::act(const SpooledJob& job, const ApiRequest& request) {
  const bool ends = request.op == ApiOp::kHold || request.op == ApiOp::kStop;
  if (ends && errands_.withdraw(job.id)) {
    stand_still(job.id, "job " + std::to_string(job.id) + " was stopped before it began");
    if (job.place > 0) return leave_queue(job);
    return write_text("not started: nothing has moved");
  }
  if (ends && job.state == JobState::kToolChange) {
    const bool moves = worker_->busy();
    if (moves) worker_->stop();
    if (request.op == ApiOp::kHold)
      return write_text(moves ? worker_->name() + " is told to end"
                              : "it waits for a tool change: nothing of it moves");
    const std::string parked = changing_.job == job.id ? changing_.parked : "";
    if (changing_.job == job.id) changing_ = {};
    if (const Result<void> kept = keep(job, JobState::kStopped, "stopped at the tool change: " + job.note);
        !kept)
      return tl::unexpected<Error>(kept.error());
    return write_text(parked.empty() ? "stopped" : "stopped; machine: " + parked);
  }
  switch (request.op) {
    case ApiOp::kHold:
      return command(job, {Order::kHold});
    case ApiOp::kStop:
      return job.place > 0 ? leave_queue(job) : command(job, {Order::kStop});
    case ApiOp::kOverride:
      return command(job, {Order::kFeedOverride, request.percent});
    case ApiOp::kRemove:
      return remove(job);
    default:
      return fail(Code::kUsage, "this cannot be asked of a job");
  }
}

std::string JobService::job_json(const SpooledJob& job, const std::vector<std::uint64_t>& queue) const {
  ordered_json json = {{"job", job.id},           {"name", job.name},         {"state", shown_state(job)},
                       {"note", shown_note(job)}, {"blocks", job.total},      {"executed", job.executed},
                       {"user", job.user},        {"submitted", job.created}, {"sha256", job.hash}};
  if (!job.shop.empty()) json["shop"] = job.shop;
  if (arrivals_.is_arriving(job.id)) json["state"] = "arriving", json["note"] = "its files are being copied";
  if (const auto at = std::find(queue.begin(), queue.end(), job.id); at != queue.end()) {
    json["queue"] = at - queue.begin() + 1;
    json["queue_moves"] = queue_moves_;
  }
  if (job.state == JobState::kToolChange && changing_.job == job.id) {
    if (changing_.change.tool) json["tool"] = *changing_.change.tool;
    json["tool_name"] = changing_.change.name;
    json["line"] = changing_.change.line;
    if (changing_.change.length) json["program_length"] = *changing_.change.length;
    if (changing_.length) json["length"] = *changing_.length;
    json["parked"] = changing_.parked;
  }
  if (job.state == JobState::kPlanning && plan_.job == job.id && plan_.runs())
    if (const auto at = stage_of(plan_.folder)) json["stage"] = at->stage, json["percent"] = at->percent;
  if (const PlanOrders::Order* order = orders_.of(job.id);
      order != nullptr && order->standing.state == PlanState::kTaken)
    json["planned_by"] = order->standing.helper, json["stage"] = order->standing.stage,
    json["percent"] = order->standing.percent;
  if (job.state != JobState::kRunning || !runner_->busy()) return text_of(json);
  const RunView view = runner_->view();
  if (view.job != job.id) return text_of(json);
  json["phase"] = phase_name(view.state.phase);
  json["machine"] = view.state.machine;
  json["sent"] = view.state.sent;
  json["acknowledged"] = view.state.acknowledged;
  json["executed"] = view.state.executed;
  if (!view.operation.empty()) json["operation"] = view.operation;
  json["resends"] = view.state.resends;
  json["seconds"] = tenth(view.seconds);
  json["machine_seconds"] = tenth(view.machine_seconds);
  json["remaining_seconds"] = tenth(view.remaining_seconds);
  json["silent_seconds"] = tenth(view.silent_seconds);
  if (const auto starved = view.tally.starved_seconds()) json["starved_seconds"] = tenth(*starved);
  if (const auto slowest = view.tally.slowest_hold()) json["slowest_hold_seconds"] = tenth(*slowest);
  json["uncertain_lines"] = {view.state.uncertain.first, view.state.uncertain.last};
  json.update(ordered_json::parse(run_place_json(view.state)));
  if (!view.state.held.empty()) json["held"] = view.state.held;
  if (!view.state.refused.empty()) json["refused"] = view.state.refused;
  return text_of(json);
}

void JobService::show(const SpooledJob& job, const ApiRequest& request, const Done& done) {
  ordered_json json = ordered_json::parse(job_json(job, queue()));
  json.update(good());
  json["folder"] = spool_.folder_of(job.id);
  if (!request.block) return done(reply(json));
  const auto look = [json, program = spool_.file(job.id, "program.nc"),
                     map = spool_.file(job.id, "block.map"), kind = link_.kind, machine = config_.machine,
                     number = *request.block]() -> Errands::Then {
    ordered_json whole = json;
    whole["origin"] = ordered_json::parse(origin_json(program, map, kind, machine, number));
    return [line = reply(whole)] { return line; };
  };
  errands_.begin({job.id, false, false}, look, done);
}

/// An order that a silent controller may never hear is on its way, no more.
std::string JobService::told() const {
  const double silent = runner_->view().silent_seconds;
  if (silent <= kToldSilent) return "told the machine";
  return "sent, but the controller was last heard " + decimal(silent, 0) +
         " s ago: look at the machine, its own controls come first";
}

Result<std::string> JobService::command(const SpooledJob& job, const OperatorCommand& command) {
  if (job.state == JobState::kRunning && runner_->command(job.id, command)) return write_text(told());
  if (job.state == JobState::kInterrupted && command.order == Order::kStop) return forget_run(job);
  const std::string remove = "`tiltfeed remove " + std::to_string(job.id) + "` ";
  std::string advice;
  if (may_be_held(job)) advice = "; " + forget_advice(link_.kind) + ", " + remove + "forgets it";
  if (job.state == JobState::kPlanning) advice = "; " + remove + "ends that and forgets it";
  return fail(Code::kUsage, name_of(job.id) + " is " + shown_state(job) + ", not on the machine" + advice);
}

Result<std::string> JobService::remove(const SpooledJob& job) {
  if (job.state == JobState::kRunning)
    return fail(Code::kUsage, "job " + std::to_string(job.id) + " is on the machine; stop it first");
  if (errands_.machine() == job.id)
    return fail(Code::kUsage, "job " + std::to_string(job.id) + " is about to begin; stop it first");
  if (job.place > 0)
    if (const Result<std::string> left = leave_queue(job); !left) return left;
  arrivals_.drop(job.id);
  if (plan_.job == job.id) stop_plan(plan_);
  forget_plan(job.id);
  if (const Result<void> removed = spool_.remove(job.id); !removed)
    return tl::unexpected<Error>(removed.error());
  if (changing_.job == job.id) changing_ = {};
  asked_by_.erase(job.id);
  unsettled_.erase(job.id);
  return write_text(may_be_held(job) ? "removed; " + forget_advice(link_.kind) : "removed");
}

// ---- ends of planning and of runs ------------------------------------------------------------------------

/// Whoever asked for it or not: an operator who reads the log later learns why the machine stood.
void JobService::tell_hold() {
  const RunView view = runner_->busy() ? runner_->view() : RunView();
  if (view.state.held == told_hold_) return;
  told_hold_ = view.state.held;
  if (!told_hold_.empty()) log(Severity::kWarning, view.job, told_hold_, view.state.executed);
}

void JobService::take_ends() {
  errands_.tick();
  arrivals_.tick(spool_);
}

void JobService::tick() {
  claim_.turn_away();
  // A device may have gone, and another one have its number: that one is not this service's.
  if (!busy() && !reset_.valid() && link_.place.starts_with('/')) static_cast<void>(claim_.follow(link_));
  tell_hold();
  take_run_end();
  take_reset_end();
  take_ends();
  spool_.save_remembered();
  take_plan_end();
  take_check_end();
  take_proof_ends();
  give_up_silent();
  start_next();
  plan_next();
  tend_help();
  tidy();
  tell_shop();
  if (!config_.watch.empty()) look_into_watch_folder();
}

std::string JobService::status() const {
  if (!runner_->busy() && changing_.job != 0)
    return "job " + std::to_string(changing_.job) + " tool change: " + tool_text(changing_.change);
  if (!runner_->busy() && plan_.runs()) return "planning job " + std::to_string(plan_.job);
  if (!runner_->busy()) return "idle" + (help_.text().empty() ? "" : ", " + help_.text());
  const RunView view = runner_->view();
  std::string text = "job " + std::to_string(view.job) + " " + phase_name(view.state.phase) + ": " +
                     std::to_string(view.state.executed) + " of " + std::to_string(view.state.total) +
                     " blocks";
  if (!view.state.held.empty()) text += ", " + view.state.held;
  if (view.machine_seconds > 0.0)
    text += ", " + std::to_string(static_cast<long>(view.remaining_seconds)) + " s left";
  return text;
}

}  // namespace tiltfeed::daemon
