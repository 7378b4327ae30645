// How a job gets onto the machine: started, gone on with where the controller can prove it, or entered again
// where an operator says so.

#include <nlohmann/json.hpp>

#include <fcntl.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "config/job_files.h"
#include "daemon/job_desk.h"
#include "config/output_file.h"
#include "daemon/machine_place.h"
#include "daemon/reentry.h"
#include "daemon/sha256.h"

namespace tiltfeed {

namespace {

using nlohmann::ordered_json;

std::string said(const std::string& text, const char* key = "text") {
  const ordered_json json = {{"v", kApiVersion}, {"ok", true}, {key, text}};
  return json.dump(-1, ' ', true, ordered_json::error_handler_t::replace) + "\n";
}

class RealClock : public Clock {
 public:
  Time now() override { return std::chrono::steady_clock::now().time_since_epoch(); }
};

/// Where the machine says that it stands, and `alive` about ten times a second meanwhile.
Result<std::optional<Joints>> place_alive(const LinkSpec& link, const MachineModel& machine,
                                          const std::function<void()>& alive) {
  const auto look = [&]() -> Result<std::optional<Joints>> {
    if (link.kind != LinkKind::kGrbl && !is_ring(link.kind)) return std::optional<Joints>();
    const Result<std::unique_ptr<Link>> wire = open_link(link);
    if (!wire) return tl::unexpected<Error>(wire.error());
    RealClock clock;
    return read_place(link, machine, **wire, clock);
  };
  auto place = std::async(std::launch::async, look);
  while (place.wait_for(std::chrono::milliseconds(100)) != std::future_status::ready) alive();
  return place.get();
}

std::string name_of(const SpooledJob& job) { return "job " + std::to_string(job.id); }

}  // namespace

/// The program as it lies there now must be the one that became ready.
Result<JobRun> JobDesk::prepare(const SpooledJob& job) const {
  Result<JobRun> run = prepare_alive(spool_.file(job.id, "program.nc"), link_, job.id, alive_);
  if (run && hex(run->subject.program) != job.hash)
    return fail(Code::kInput, name_of(job) + ": its program was changed in the spool; submit it again");
  return run;
}

Result<std::string> JobDesk::run(SpooledJob job, const JobRun& prepared, const ResumeDecision& decision) {
  if (const Result<void> free = machine_free(job.id); !free) return tl::unexpected<Error>(free.error());
  // An adapter may have got another device's name since the service began.
  if (const Result<void> claimed = claim_.follow(link_); !claimed)
    return tl::unexpected<Error>(claimed.error());
  // The spool says "running" only of what has a journal, so that a journal that is not there is a lost one.
  if (decision.way == ResumeWay::kFresh)
    if (const Result<void> begun = begin_journal(spool_.file(job.id, "journal"), prepared.subject); !begun)
      return tl::unexpected<Error>(begun.error());
  job.executed = decision.executed;
  job.place = 0;
  if (const Result<void> kept = keep(job, JobState::kRunning, ""); !kept)
    return tl::unexpected<Error>(kept.error());
  runner_->start({prepared, decision, spool_.file(job.id, "journal"), spool_.file(job.id, "blackbox.txt"),
                  config_.machine.model});
  return said("starting");
}

/// The whole program, for a new workpiece. Requires: job.state is kReady or kDone.
Result<std::string> JobDesk::begin(SpooledJob job) {
  const Result<JobRun> prepared = prepare(job);
  if (!prepared) return tl::unexpected<Error>(prepared.error());
  // Another workpiece: its run has a journal of its own.
  std::error_code gone;
  std::filesystem::remove(spool_.file(job.id, "journal"), gone);
  if (gone) return fail(Code::kIo, spool_.file(job.id, "journal") + ": " + gone.message());
  ResumeDecision fresh;
  fresh.way = ResumeWay::kFresh;
  return run(std::move(job), *prepared, fresh);
}

Result<std::string> JobDesk::resume(SpooledJob job, const ApiRequest& request, std::uint32_t user) {
  if (job.state == JobState::kRunning) return command(job, {Order::kResume});
  if (request.from) return enter_again(job, request, user);
  if (job.state == JobState::kUncertain || job.state == JobState::kStopped)
    return fail(Code::kUsage, name_of(job) + " cannot go on by itself: " + job.note);
  if (job.state != JobState::kInterrupted)
    return fail(Code::kUsage, name_of(job) + " is " + state_name(job.state) + "; there is nothing to resume");
  const Result<JobRun> prepared = prepare(job);
  if (!prepared) return tl::unexpected<Error>(prepared.error());
  const Result<JournalContent> journal = read_journal_file(spool_.file(job.id, "journal"));
  if (!journal) return tl::unexpected<Error>(journal.error());
  const ResumeDecision decision = decide_resume(*journal, prepared->subject);
  if (decision.way == ResumeWay::kFinished)
    return set(job, JobState::kDone, decision.text), said(decision.text);
  if (decision.way == ResumeWay::kUncertain)
    return set(job, JobState::kUncertain, decision.text), fail(Code::kUsage, decision.text);
  return run(std::move(job), *prepared, decision);
}

/// First the operator sees what would move; said again with the confirmation it becomes a job of its own, and
/// starts.
Result<std::string> JobDesk::enter_again(const SpooledJob& job, const ApiRequest& request,
                                         std::uint32_t user) {
  if (job.state == JobState::kReceived || job.state == JobState::kPlanning || job.state == JobState::kFailed)
    return fail(Code::kUsage, name_of(job) + " is " + state_name(job.state) + ": it has no program yet");
  const Result<JobRun> prepared = prepare(job);
  if (!prepared) return tl::unexpected<Error>(prepared.error());
  ReentryOptions options;
  options.from = *request.from;
  if (const Result<Job> planned = load_job_with(spool_.file(job.id, "job.yaml"),
                                                {spool_.file(job.id, "part.stl"), config_.machine.path});
      planned) {
    options.plunge_feed = planned->plan.plunge_feed.mm_per_min();
    options.setup = planned->setup;
  }
  if (const Result<void> free = machine_free(0); !free) return tl::unexpected<Error>(free.error());
  const auto stands = place_alive(link_, config_.machine.model, alive_);
  if (!stands) return tl::unexpected<Error>(stands.error());
  options.stands = *stands;
  const Result<Reentry> entry = write_reentry(prepared->program, link_.kind, config_.machine, options);
  if (!entry) return tl::unexpected<Error>(entry.error());
  if (!request.confirmed) return said(entry->preview, "confirm");

  const std::string path = spool_.file(job.id, "reentry.nc");
  auto file = OutputFile::open(path);
  if (!file) return tl::unexpected<Error>(file.error());
  file->stream() << entry->program;
  if (const Result<void> written = file->commit(); !written) return tl::unexpected<Error>(written.error());
  const int fd = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC);
  if (fd < 0) return fail(Code::kIo, path + ": cannot be opened");
  SpooledJob again;
  again.name = job.name.substr(0, 20) + " from " + std::to_string(*request.from);
  again.program = true;
  again.user = user;
  const Result<std::uint64_t> id = spool_.add(again, {fd});
  ::close(fd);
  if (!id) return tl::unexpected<Error>(id.error());
  Result<JobRun> rest = prepare_alive(spool_.file(*id, "program.nc"), link_, *id, alive_);
  if (!rest) return tl::unexpected<Error>(rest.error());
  Result<SpooledJob> spooled = spool_.find(*id);
  if (!spooled) return tl::unexpected<Error>(spooled.error());
  spooled->total = rest->subject.total;
  spooled->hash = hex(rest->subject.program);
  ResumeDecision fresh;
  fresh.way = ResumeWay::kFresh;
  const Result<std::string> started = run(*spooled, *rest, fresh);
  return started ? Result<std::string>(said("re-entered as job " + std::to_string(*id))) : started;
}

// ---- ends ------------------------------------------------------------------------------------------------

void JobDesk::take_run_end() {
  std::optional<RunView> end = runner_->take_end();
  if (!end) return;
  if (!*end->ended) stand_still(end->job, "the run before it did not come to its end");
  Result<SpooledJob> job = spool_.find(end->job);
  if (!job) return;
  job->executed = end->state.executed;
  if (*end->ended) return set(*job, JobState::kDone, "every block is executed");
  const std::string why = end->ended->error().message;
  log(Severity::kError, job->id, why, end->state.executed);
  if (end->state.executed >
      0) {  // the chain for the black box: where it stood, and what that was on the part
    std::ofstream out(spool_.file(job->id, "blackbox.txt"), std::ios::app);
    out << "last executed: " << origin_json(*job, end->state.executed) << "\n";
  }
  const Result<JobRun> prepared = prepare(*job);
  const Result<JournalContent> journal = read_journal_file(spool_.file(job->id, "journal"));
  if (!prepared || !journal) return set(*job, JobState::kUncertain, why);
  const ResumeDecision decision = decide_resume(*journal, prepared->subject);
  if (decision.way == ResumeWay::kFresh) return set(*job, JobState::kReady, why);
  if (end->state.phase == Phase::kStopped) return set(*job, JobState::kStopped, why);
  // A controller that restarted or forgot the run has said so: asking it again will not help.
  const bool lost = end->state.loss == Loss::kRestarted || end->state.loss == Loss::kForgotten;
  const bool provable = decision.way == ResumeWay::kContinue && !lost;
  set(*job, provable ? JobState::kInterrupted : JobState::kUncertain, why);
}

Result<void> JobDesk::settle() {
  const auto jobs = spool_.list();
  if (!jobs) return tl::unexpected<Error>(jobs.error());
  for (SpooledJob job : *jobs) {
    if (job.state == JobState::kPlanning) set(job, JobState::kReceived, "");
    if (job.state != JobState::kRunning) continue;
    const Result<JobRun> prepared = prepare(job);
    const Result<JournalContent> journal = read_journal_file(spool_.file(job.id, "journal"));
    if (!prepared || !journal) {
      set(job, JobState::kUncertain, !prepared ? prepared.error().message : journal.error().message);
      continue;
    }
    const ResumeDecision decision = decide_resume(*journal, prepared->subject);
    job.executed = decision.executed;
    const std::string text = "the service ended while it ran; " + decision.text;
    switch (decision.way) {
      case ResumeWay::kFresh:
        set(job, JobState::kReady, text);
        break;
      case ResumeWay::kContinue:
        set(job, JobState::kInterrupted, text);
        break;
      case ResumeWay::kFinished:
        set(job, JobState::kDone, text);
        break;
      case ResumeWay::kUncertain:
        set(job, JobState::kUncertain, text);
        break;
    }
  }
  return {};
}

void JobDesk::leave() {
  stop_plan(plan_);
  queue_moves_ = false;  // also where the run still comes to its end
  if (!runner_->busy()) return;
  if (is_provable(link_.kind)) {
    runner_->command({Order::kHold});
    runner_->detach();
  } else {
    runner_->command({Order::kStop});
  }
}

}  // namespace tiltfeed
