// Jobs that wait for the machine: who is next, what lets it start by itself, and what does not.

#include "daemon/service/entry_mark.h"
#include "daemon/service/job_service.h"

namespace tiltfeed::daemon {

namespace {

bool is_planned(const SpooledJob& job) {
  return job.state != JobState::kReceived && job.state != JobState::kPlanning;
}

/// What a job that cannot be started goes on by.
std::string way_on(const SpooledJob& job, LinkKind kind) {
  const std::string id = std::to_string(job.id);
  switch (job.state) {
    case JobState::kInterrupted:
      return "`tiltfeed resume " + id + "` goes on with it";
    case JobState::kUncertain:
    case JobState::kStopped:
      if (is_drive(kind)) return "submit what is left as a job of its own";
      return "`tiltfeed resume " + id + " --from BLOCK` enters it again";
    case JobState::kToolChange:
      return "`tiltfeed tool " + id + "` goes on with it";
    case JobState::kFailed:
      return "submit it again when that is mended";
    default:
      return "only a ready or a done job can be started";
  }
}

Result<void> startable(const SpooledJob& job, LinkKind kind) {
  if (job.state == JobState::kReady || job.state == JobState::kDone) return {};
  return fail(Code::kUsage, name_of(job.id) + " is " + state_name(job.state) +
                                (job.note.empty() ? "" : " (" + job.note + ")") + "; " + way_on(job, kind));
}

}  // namespace

std::vector<std::uint64_t> JobService::queue() const {
  std::vector<std::uint64_t> ids;
  if (const auto jobs = spool_.queue())
    for (const SpooledJob& job : *jobs) ids.push_back(job.id);
  return ids;
}

/// For this job: another may be on the machine, or be the next.
Result<void> JobService::machine_free(std::uint64_t job) const {
  if (runner_->busy()) {
    const RunView view = runner_->view();
    const std::string now = "the machine is busy with " + name_of(view.job);
    if (view.state.phase != Phase::kHold) return fail(Code::kUsage, now);
    return fail(Code::kUsage, now + ", which is held: `tiltfeed resume` goes on, `tiltfeed stop` ends it");
  }
  if (reset_.valid()) return fail(Code::kUsage, "the machine is being reset");
  if (leaving_) return fail(Code::kUsage, "the service is ending");
  if (const std::uint64_t other = errands_.machine(); other != 0)
    return fail(Code::kUsage, "the machine is about to be given to " + name_of(other));
  if (changing_.job != 0 && changing_.job != job)
    return fail(Code::kUsage, name_of(changing_.job) + " waits for a tool change: `tiltfeed tool " +
                                  std::to_string(changing_.job) + "` goes on with it, `tiltfeed stop " +
                                  std::to_string(changing_.job) + "` ends it");
  if (worker_->busy())
    return fail(Code::kUsage, worker_->name() + " is in work on the machine; `tiltfeed stop` ends it");
  const std::vector<std::uint64_t> waiting = queue();
  if (queue_moves_ && !waiting.empty() && waiting.front() != job)
    return fail(Code::kUsage, name_of(waiting.front()) + " is the next and starts when it is planned");
  return {};
}

/// A job that enters another again begins with a way off from where the machine stood then.
Result<void> JobService::not_an_entry(const SpooledJob& job) const {
  const auto entry = read_entry_mark(spool_.file(job.id, "entry"));
  if (!entry) return {};
  return fail(Code::kUsage, name_of(job.id) +
                                " begins with a way off from where the machine stood when it was made; "
                                "`tiltfeed resume " +
                                std::to_string(entry->job) + " --from " + std::to_string(entry->from) +
                                "` makes it anew from where it stands now");
}

void JobService::start(const SpooledJob& job, bool queued, Done done) {
  if (const Result<void> whole = not_an_entry(job); !whole) return done(tl::unexpected<Error>(whole.error()));
  if (queued && job.place > 0) return done(write_text(place_text(job.id)));
  if (is_planned(job) || !queued)
    if (const Result<void> can = startable(job, link_.kind); !can)
      return done(tl::unexpected<Error>(can.error()));
  const Result<void> free = machine_free(job.id);
  // What waits already goes first.
  if (queued && (!free || !is_planned(job) || !queue().empty())) return done(enqueue(job));
  if (!free)
    return done(fail(Code::kUsage, free.error().message + "; `tiltfeed start " + std::to_string(job.id) +
                                       " --queue` lets " + name_of(job.id) + " wait for its turn"));
  begin(job, [this, id = job.id, done = std::move(done)](Result<std::string> started) {
    if (started) queue_moves_ = true;
    if (!started) stand_still(id, name_of(id) + " cannot be started");
    done(std::move(started));
  });
}

std::string JobService::place_text(std::uint64_t job) const {
  std::size_t place = 1;
  for (const std::uint64_t id : queue()) {
    if (id == job) break;
    ++place;
  }
  return name_of(job) + " waits at place " + std::to_string(place) + " of the queue, " +
         (queue_moves_ ? "and starts by itself when all before it are executed to their ends"
                       : "which stands still: `tiltfeed start` of a job moves it");
}

Result<std::string> JobService::enqueue(SpooledJob job) {
  const auto waiting = spool_.queue();
  if (!waiting) return tl::unexpected<Error>(waiting.error());
  job.place = waiting->empty() ? 1 : waiting->back().place + 1;
  if (const Result<void> kept = spool_.update(job); !kept) return tl::unexpected<Error>(kept.error());
  // A start like any other. With nothing on the machine there is no end that it could wait for.
  if (runner_->busy() || errands_.machine() != 0) queue_moves_ = true;
  const std::string text = place_text(job.id);
  log(Severity::kInfo, job.id, text);
  return write_text(text);
}

Result<std::string> JobService::leave_queue(SpooledJob job) {
  // Where the machine waits for its plan, nobody has said what should come in its place.
  if (const auto waiting = queue(); !runner_->busy() && !waiting.empty() && waiting.front() == job.id)
    stand_still(job.id, name_of(job.id) + " was taken out");
  job.place = 0;
  if (const Result<void> kept = spool_.update(job); !kept) return tl::unexpected<Error>(kept.error());
  log(Severity::kInfo, job.id, "taken out of the queue");
  return write_text("taken out of the queue");
}

void JobService::stand_still(std::uint64_t job, const std::string& why) {
  if (queue_moves_ && !queue().empty())
    log(Severity::kWarning, job, "the queue stands still: " + why + "; `tiltfeed start` of a job moves it");
  queue_moves_ = false;
}

void JobService::start_next() {
  if (!queue_moves_ || changing_.job != 0 || runner_->busy() || worker_->busy() || errands_.machine() != 0)
    return;
  const auto waiting = spool_.queue();
  if (!waiting) return stand_still(0, waiting.error().message);
  // Who comes later waits for nothing, and starts by a word of its own.
  if (waiting->empty()) return stand_still(0, "nothing is left");
  const SpooledJob next = waiting->front();
  if (!is_planned(next)) return;
  log(Severity::kInfo, next.id, "its turn in the queue");
  const Done done = [this, id = next.id](const Result<std::string>& started) {
    if (started) return;
    stand_still(id, name_of(id) + " cannot be started");
    Result<SpooledJob> job = spool_.find(id);
    if (!job) return;
    job->place = 0;
    set(*job, job->state, started.error().message);
  };
  const Result<void> can = startable(next, link_.kind);
  if (!can) return done(tl::unexpected<Error>(can.error()));
  begin(next, done);
}

}  // namespace tiltfeed::daemon
