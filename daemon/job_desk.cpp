#include "daemon/job_desk.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "daemon/block_map.h"

namespace tiltfeed {

namespace {

using nlohmann::ordered_json;

std::string reply(const ordered_json& json) {
  return json.dump(-1, ' ', true, ordered_json::error_handler_t::replace) + "\n";
}

ordered_json good() { return {{"v", kApiVersion}, {"ok", true}}; }

std::string text_of(const ordered_json& json) {
  return json.dump(-1, ' ', true, ordered_json::error_handler_t::replace);
}

double tenth(double seconds) { return std::round(seconds * 10.0) / 10.0; }

std::string said(const std::string& text) {
  ordered_json json = good();
  json["text"] = text;
  return reply(json);
}

}  // namespace

JobDesk::JobDesk(const ServiceConfig& config, const LinkSpec& link, MachineClaim claim, Spool spool,
                 std::function<void()> alive)
    : config_(config),
      link_(link),
      claim_(std::move(claim)),
      spool_(std::move(spool)),
      alive_(alive),
      runner_(std::make_unique<JobRunner>(std::move(alive))) {}

Result<JobDesk> JobDesk::open(const ServiceConfig& config, std::function<void()> alive) {
  const Result<LinkSpec> link = parse_link(config.link, config.machine.wire, &config.machine.model);
  if (!link) return tl::unexpected<Error>(link.error());
  MachineClaim claim;
  if (const Result<void> claimed = claim.follow(*link); !claimed)
    return tl::unexpected<Error>(claimed.error());
  Result<Spool> spool = Spool::open(config.spool);
  if (!spool) return tl::unexpected<Error>(spool.error());
  JobDesk desk(config, *link, std::move(claim), std::move(*spool), std::move(alive));
  if (const Result<void> settled = desk.settle(); !settled) return tl::unexpected<Error>(settled.error());
  return desk;
}

Result<void> JobDesk::reload(const ServiceConfig& config) {
  const Result<LinkSpec> link = parse_link(config.link, config.machine.wire, &config.machine.model);
  if (!link) return tl::unexpected<Error>(link.error());
  if (config.spool != config_.spool || config.socket != config_.socket)
    return fail(Code::kUsage, config.path + ": spool and socket change with a restart only");
  if (const Result<void> claimed = claim_.follow(*link); !claimed) return claimed;
  config_ = config;
  link_ = *link;
  return {};
}

void JobDesk::log(Severity severity, std::uint64_t job, const std::string& text, std::uint64_t block) const {
  LogFields fields;
  fields.machine = config_.machine.model.name;
  fields.job = job;
  fields.block = block;
  write_log(severity, text, fields);
}

Result<void> JobDesk::keep(SpooledJob job, JobState state, const std::string& note) {
  job.state = state;
  job.note = note;
  if (const Result<void> updated = spool_.update(job); !updated) return updated;
  const bool bad =
      state == JobState::kFailed || state == JobState::kUncertain || state == JobState::kInterrupted;
  log(bad ? Severity::kWarning : Severity::kInfo, job.id,
      std::string(state_name(state)) + (note.empty() ? "" : ": " + note), job.executed);
  return {};
}

/// It is so already: where it cannot be written it is remembered, and told all the same.
void JobDesk::set(const SpooledJob& job, JobState state, const std::string& note) {
  const Result<void> kept = keep(job, state, note);
  if (kept) return;
  SpooledJob now = job;
  now.state = state;
  now.note = note + (note.empty() ? "" : "; ") + "not in the spool yet: " + kept.error().message;
  spool_.remember(now);
  log(Severity::kError, job.id, std::string(state_name(state)) + ": " + now.note);
}

std::string JobDesk::answer(const ApiRequest& request, std::uint32_t user, const std::vector<int>& files) {
  if (request.op != ApiOp::kList && request.op != ApiOp::kShow) {
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
  const Result<std::string> done = act(request, user, files);
  if (done) return *done;
  log(Severity::kWarning, request.job, done.error().message);
  return write_refusal(done.error());
}

Result<std::string> JobDesk::act(const ApiRequest& request, std::uint32_t user,
                                 const std::vector<int>& files) {
  if (request.op == ApiOp::kSubmit) {
    SpooledJob job;
    job.name = request.name;
    job.program = request.program;
    job.user = user;
    const Result<std::uint64_t> id = spool_.add(job, files);
    if (!id) return tl::unexpected<Error>(id.error());
    ordered_json json = good();
    json["job"] = *id;
    return reply(json);
  }
  if (request.op == ApiOp::kList) {
    const auto jobs = spool_.list();
    if (!jobs) return tl::unexpected<Error>(jobs.error());
    ordered_json json = good();
    json["machine"] = config_.machine.model.name;
    json["link"] = describe(link_);
    json["jobs"] = ordered_json::array();
    const std::vector<std::uint64_t> waiting = queue();
    for (const SpooledJob& job : *jobs) json["jobs"].push_back(ordered_json::parse(job_json(job, waiting)));
    if (reset_.valid() || !reset_text_.empty())
      json["reset"] = reset_.valid() ? std::string("in work") : reset_text_;
    return reply(json);
  }
  if (request.op == ApiOp::kReset) return reset(request);
  Result<SpooledJob> job = spool_.find(request.job);
  if (!job) return tl::unexpected<Error>(job.error());
  switch (request.op) {
    case ApiOp::kShow:
      return show(*job, request);
    case ApiOp::kStart:
      return start(*job, request.queue);
    case ApiOp::kHold:
      return command(*job, {Order::kHold});
    case ApiOp::kStop:
      return job->place > 0 ? leave_queue(std::move(*job)) : command(*job, {Order::kStop});
    case ApiOp::kOverride:
      return command(*job, {Order::kFeedOverride, request.percent});
    case ApiOp::kResume:
      return resume(std::move(*job), request, user);
    case ApiOp::kRemove:
      return remove(*job);
    case ApiOp::kSubmit:
    case ApiOp::kList:
    case ApiOp::kReset:
      break;
  }
  return fail(Code::kUsage, "this cannot be asked of a job");
}

std::string JobDesk::job_json(const SpooledJob& job, const std::vector<std::uint64_t>& queue) const {
  ordered_json json = {{"job", job.id},    {"name", job.name},         {"state", shown_state(job)},
                       {"note", job.note}, {"blocks", job.total},      {"executed", job.executed},
                       {"user", job.user}, {"submitted", job.created}, {"sha256", job.hash}};
  if (const auto at = std::find(queue.begin(), queue.end(), job.id); at != queue.end()) {
    json["queue"] = at - queue.begin() + 1;
    json["queue_moves"] = queue_moves_;
  }
  if (job.state != JobState::kRunning || !runner_->busy()) return text_of(json);
  const RunView view = runner_->view();
  if (view.job != job.id) return text_of(json);
  json["phase"] = phase_name(view.state.phase);
  json["machine"] = view.state.machine;
  json["sent"] = view.state.sent;
  json["acknowledged"] = view.state.acknowledged;
  json["executed"] = view.state.executed;
  json["resends"] = view.state.resends;
  json["seconds"] = tenth(view.seconds);
  json["machine_seconds"] = tenth(view.machine_seconds);
  json["remaining_seconds"] = tenth(view.remaining_seconds);
  json["uncertain_lines"] = {view.state.uncertain.first, view.state.uncertain.last};
  if (!view.state.held.empty()) json["held"] = view.state.held;
  if (!view.state.refused.empty()) json["refused"] = view.state.refused;
  return text_of(json);
}

/// Which line, which move of the tool path, which facet of the part.
std::string JobDesk::origin_json(const SpooledJob& job, std::uint64_t number) const {
  ordered_json json = {{"block", number}};
  const auto block = find_block(spool_.file(job.id, "program.nc"), link_.kind, config_.machine.model, number);
  if (!block) {
    json["error"] = block.error().message;
    return text_of(json);
  }
  json["line"] = block->line;
  json["text"] = block->text;
  json["machine_seconds"] = tenth(block->seconds);
  const NumericBlock& at = block->state;
  json["at"] = {{"x", at.x}, {"y", at.y}, {"z", at.z}, {"tilt", at.tilt}, {"rotary", at.rotary}};
  if (!block->is_move) return text_of(json);
  const std::string map = spool_.file(job.id, "block.map");
  if (const auto origin = read_block_origin(map, block->moves); origin && *origin) {
    json["move"] = (*origin)->move;
    if ((*origin)->facet != kNoFacet) json["facet"] = (*origin)->facet;
  }
  return text_of(json);
}

Result<std::string> JobDesk::show(const SpooledJob& job, const ApiRequest& request) const {
  ordered_json json = ordered_json::parse(job_json(job, queue()));
  json.update(good());
  json["folder"] = spool_.folder_of(job.id);
  if (request.block) json["origin"] = ordered_json::parse(origin_json(job, *request.block));
  return reply(json);
}

Result<std::string> JobDesk::command(const SpooledJob& job, const OperatorCommand& command) {
  const bool left = job.state == JobState::kInterrupted || job.state == JobState::kUncertain;
  if (job.state != JobState::kRunning || !runner_->busy() || runner_->view().job != job.id)
    return fail(Code::kUsage, "job " + std::to_string(job.id) + " is " + shown_state(job) +
                                  ", not on the machine" +
                                  (left ? "; `tiltfeed reset` ends what the controller may still have of it, "
                                          "`tiltfeed remove " +
                                              std::to_string(job.id) + "` forgets it"
                                        : ""));
  runner_->command(command);
  return said("told the machine");
}

Result<std::string> JobDesk::remove(const SpooledJob& job) {
  if (job.state == JobState::kRunning)
    return fail(Code::kUsage, "job " + std::to_string(job.id) + " is on the machine; stop it first");
  if (job.place > 0)
    if (const Result<std::string> left = leave_queue(job); !left) return left;
  if (plan_.job == job.id) stop_plan(plan_);
  if (const Result<void> removed = spool_.remove(job.id); !removed)
    return tl::unexpected<Error>(removed.error());
  return said("removed");
}

// ---- ends of planning and of runs ------------------------------------------------------------------------

void JobDesk::tick() {
  claim_.turn_away();
  take_run_end();
  take_reset_end();
  spool_.save_remembered();
  take_plan_end();
  take_check_end();
  start_next();
  plan_next();
  if (!config_.watch.empty()) look_into_watch_folder();
}

void JobDesk::look_into_watch_folder() {
  std::error_code failed;
  for (const auto& entry : std::filesystem::directory_iterator(config_.watch, failed)) {
    const std::string path = entry.path().string();
    // Only what was moved in whole: a file that is being written has another name until it is done.
    if (entry.path().extension() != ".nc" || !entry.is_regular_file(failed) || entry.is_symlink(failed))
      continue;
    const int fd = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0) continue;
    SpooledJob job;
    job.name = entry.path().stem().string();
    job.program = true;
    job.user = ::getuid();
    const Result<std::uint64_t> id = spool_.add(job, {fd});
    ::close(fd);
    if (id)
      log(Severity::kInfo, *id, "taken from the watch folder");
    else
      log(Severity::kWarning, 0, id.error().message);
    std::filesystem::remove(path, failed);
    if (failed) {  // it would be taken again for ever
      log(Severity::kError, 0, config_.watch + ": what was taken cannot be removed; not watched any more");
      config_.watch.clear();
      return;
    }
  }
}

std::string JobDesk::status() const {
  if (!runner_->busy()) return plan_.pid >= 0 ? "planning job " + std::to_string(plan_.job) : "idle";
  const RunView view = runner_->view();
  std::string text = "job " + std::to_string(view.job) + " " + phase_name(view.state.phase) + ": " +
                     std::to_string(view.state.executed) + " of " + std::to_string(view.state.total) +
                     " blocks";
  if (!view.state.held.empty()) text += ", " + view.state.held;
  if (view.machine_seconds > 0.0)
    text += ", " + std::to_string(static_cast<long>(view.remaining_seconds)) + " s left";
  return text;
}

}  // namespace tiltfeed
