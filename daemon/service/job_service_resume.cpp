// How a job gets onto the machine: started, gone on with where the controller can prove it, or entered again
// where an operator says so.

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "config/job.h"
#include "config/output_file.h"
#include "daemon/files/sha256.h"
#include "daemon/journal/reentry.h"
#include "daemon/machine/advice.h"
#include "daemon/program/operation_span.h"
#include "daemon/service/entry_hold.h"
#include "daemon/service/entry_mark.h"
#include "daemon/service/job_origin.h"
#include "daemon/service/job_service.h"

namespace tiltfeed::daemon {

namespace {

/// All that a re-entry is made from, and the files that it goes to.
struct EntryOrder {
  SpooledJob job;
  std::string program, yaml, stl;  ///< of the job that is entered
  std::string to;                  ///< program of the job that enters it; empty: it is shown only
  std::string mark;                ///< of that job: it is made for where the machine stands now
  std::uint64_t number = 0;        ///< of that job
  LinkSpec link;
  config::MachineProfile machine;
  std::uint64_t from = 0;
};

Result<Reentry> plan_entry(const EntryOrder& order) {
  const Result<ProgramRun> prepared = prepare_spooled(order.job, order.program, order.link);
  if (!prepared) return tl::unexpected<Error>(prepared.error());
  ReentryOptions options;
  options.from = order.from;
  config::JobFiles files{.stl = order.stl, .machine = order.machine.path, .closed = true};
  if (const auto operations = read_operations(order.program, order.link.kind, order.machine.model))
    if (const OperationSpan* at = operation_at(*operations, order.from)) files.operation = at->name;
  EntrySetup setup;
  if (const Result<config::Job> planned = config::load_job_with(order.yaml, files); planned) {
    options.plunge_feed = planned->plan.plunge_feed.mm_per_min();
    options.setup = planned->setup;
    setup = {order.yaml, order.stl, order.machine.path, files.operation};
  }
  const auto stands = where_it_stands(order.link, order.machine.model);
  if (!stands) return tl::unexpected<Error>(stands.error());
  options.stands = *stands;
  Result<Reentry> entry = plan_reentry(order.program, order.link.kind, order.machine, options);
  if (!entry) return entry;
  const Result<std::string> held = hold_entry(*entry, setup);
  if (!held) return tl::unexpected<Error>(held.error());
  entry->preview += *held;
  return entry;
}

/// What is known of the way from where the machine stands to the first place of a planned program; empty: the
/// program was handed in by itself. Errors: those of hold_start.
Result<std::string> hold_way_in(const std::string& program, const std::string& yaml, const std::string& stl,
                                const LinkSpec& link, const config::MachineProfile& machine) {
  const std::string unknown =
      "the way to the program's first place is not held against part, fixtures and "
      "machine: ";
  std::error_code none;
  if (!std::filesystem::exists(yaml, none))
    return unknown + "the program was handed in by itself, without a job that states them";
  // Whatever is wrong with the wire is the run's to say.
  const auto stands = where_it_stands(link, machine.model);
  if (!stands) return unknown + stands.error().message;
  if (!*stands) return unknown + "the machine does not report where it stands";
  EntrySetup setup{yaml, stl, machine.path, ""};
  if (const auto operations = read_operations(program, link.kind, machine.model);
      operations && !operations->empty())
    setup.operation = operations->front().name;
  auto held = hold_start(program, machine, **stands, setup, link.kind);
  if (held && !held->empty()) held->pop_back();  // its line's end
  return held;
}

Result<ProgramRun> write_entry(const EntryOrder& order) {
  const Result<Reentry> entry = plan_entry(order);
  if (!entry) return tl::unexpected<Error>(entry.error());
  auto file = config::OutputFile::open(order.to);
  if (!file) return tl::unexpected<Error>(file.error());
  if (const auto written = write_reentry(order.program, *entry, file->stream()); !written)
    return tl::unexpected<Error>(written.error());
  if (const auto kept = write_entry_mark(order.mark, {order.job.id, order.from, order.job.total}); !kept)
    return tl::unexpected<Error>(kept.error());
  if (const Result<void> kept = file->commit(); !kept) return tl::unexpected<Error>(kept.error());
  return prepare_run(order.to, order.link, order.number);
}

}  // namespace

Result<ProgramRun> prepare_spooled(const SpooledJob& job, const std::string& program, const LinkSpec& link) {
  Result<ProgramRun> run = prepare_run(program, link, job.id);
  if (run && hex(run->subject.program) != job.hash)
    return fail(
        Code::kInput,
        "job " + std::to_string(job.id) +
            ": its program was changed in the spool; submit it again, `tiltfeed resume` of that job with "
            "--from BLOCK enters it");
  return run;
}

Result<std::string> JobService::run(SpooledJob job, const ProgramRun& prepared,
                                    const ResumeDecision& decision, const std::string& way_back,
                                    const std::string& held) {
  if (const Result<void> free = machine_free(job.id); !free) return tl::unexpected<Error>(free.error());
  // An adapter may have got another device's name since the service began.
  if (const Result<void> claimed = claim_.follow(link_); !claimed)
    return tl::unexpected<Error>(claimed.error());
  // The spool says "running" only of what has a journal, so that a journal that is not there is a lost one.
  if (decision.way != ResumeWay::kContinue)
    if (const Result<void> begun = begin_journal(spool_.file(job.id, "journal"), prepared.subject); !begun)
      return tl::unexpected<Error>(begun.error());
  job.executed = decision.executed;
  job.place = 0;
  if (const Result<void> kept = keep(job, JobState::kRunning, ""); !kept)
    return tl::unexpected<Error>(kept.error());
  begin_run(job, decision.executed + 1);
  runner_->start({prepared, decision, spool_.file(job.id, "journal"), spool_.file(job.id, "blackbox.txt"),
                  way_back, config_.machine.model, parking(job.id),
                  cut_way_advice(link_.kind, config_.machine.format)});
  changing_ = {};
  if (!held.empty()) log(Severity::kInfo, job.id, held);
  return write_begun(job.id, "starting", held);
}

/// The whole program, for a new workpiece. Requires: job.state is kReady or kDone.
void JobService::begin(const SpooledJob& job, Done done) {
  const auto read = [this, job, program = spool_.file(job.id, "program.nc"),
                     yaml = spool_.file(job.id, "job.yaml"), stl = spool_.file(job.id, "part.stl"),
                     link = link_, machine = config_.machine]() -> Errands::Then {
    const auto prepared = prepare_spooled(job, program, link);
    Result<std::string> held = std::string();
    if (prepared) held = hold_way_in(program, yaml, stl, link, machine);
    return [this, job, prepared, held]() -> Result<std::string> {
      if (!prepared) return tl::unexpected<Error>(prepared.error());
      if (!held) return tl::unexpected<Error>(held.error());
      // Another workpiece: its run has a journal of its own.
      std::error_code gone;
      std::filesystem::remove(spool_.file(job.id, "journal"), gone);
      if (gone) return fail(Code::kIo, spool_.file(job.id, "journal") + ": " + gone.message());
      ResumeDecision fresh;
      fresh.way = ResumeWay::kFresh;
      return run(job, *prepared, fresh, "", *held);
    };
  };
  errands_.begin({job.id, true, true}, read, std::move(done));
}

void JobService::resume(const SpooledJob& job, const ApiRequest& request, std::uint32_t user, Done done) {
  if (job.state == JobState::kRunning && request.from)
    return done(fail(Code::kUsage, name_of(job.id) + " is on the machine: `tiltfeed stop " +
                                       std::to_string(job.id) +
                                       "` ends it first, `tiltfeed resume` without a block ends a hold"));
  if (job.state == JobState::kRunning) return done(command(job, {Order::kResume}));
  if (request.from) return enter_again(job, request, user, std::move(done));
  if (job.state == JobState::kToolChange) return go_back(job, request.confirmed, std::move(done));
  if (job.state == JobState::kUncertain || job.state == JobState::kStopped)
    return done(fail(Code::kUsage, name_of(job.id) + " cannot go on by itself: " + job.note));
  if (job.state != JobState::kInterrupted)
    return done(fail(Code::kUsage,
                     name_of(job.id) + " is " + state_name(job.state) + "; there is nothing to resume"));
  if (const Result<void> free = machine_free(job.id); !free) return done(tl::unexpected<Error>(free.error()));
  go_on(job, std::move(done));
}

void JobService::go_on(const SpooledJob& job, Done done) {
  const auto read = [this, job, program = spool_.file(job.id, "program.nc"),
                     link = link_]() -> Errands::Then {
    return [this, job, prepared = prepare_spooled(job, program, link)]() -> Result<std::string> {
      if (!prepared) return tl::unexpected<Error>(prepared.error());
      const Result<JournalContent> journal = read_journal_file(spool_.file(job.id, "journal"));
      if (!journal) return tl::unexpected<Error>(journal.error());
      const ResumeDecision decision = decide_resume(*journal, prepared->subject);
      ProgramRun run_of = *prepared;
      run_of.stand_at(decision.executed);
      if (decision.way == ResumeWay::kToolChange && run_of.next_change())
        return stand_before(job, *run_of.next_change(), cut_way_advice(link_.kind, config_.machine.format),
                            decision.text),
               write_text(decision.text);
      if (decision.way == ResumeWay::kFinished)
        return set(job, JobState::kDone, decision.text), write_text(decision.text);
      if (decision.way == ResumeWay::kUncertain)
        return set(job, JobState::kUncertain, decision.text), fail(Code::kUsage, decision.text);
      return run(job, run_of, decision);
    };
  };
  errands_.begin({job.id, true, true}, read, std::move(done));
}

/// First the operator sees what would move; said again with the confirmation it becomes a job of its own, and
/// starts.
void JobService::enter_again(const SpooledJob& job, const ApiRequest& request, std::uint32_t user,
                             Done done) {
  if (job.state == JobState::kReceived || job.state == JobState::kPlanning || job.state == JobState::kFailed)
    return done(
        fail(Code::kUsage, name_of(job.id) + " is " + state_name(job.state) + ": it has no program yet"));
  const bool changes = job.state == JobState::kToolChange;
  if (const Result<void> free = machine_free(changes ? job.id : 0); !free)
    return done(tl::unexpected<Error>(free.error()));
  // An entry is made of the job that it enters, and that perhaps of another.
  std::uint64_t origin = job.id;
  for (auto mark = read_entry_mark(spool_.file(origin, "entry")); mark && mark->job < origin;
       mark = read_entry_mark(spool_.file(origin, "entry")))
    origin = mark->job;
  EntryOrder order{job,
                   spool_.file(job.id, "program.nc"),
                   spool_.file(origin, "job.yaml"),
                   spool_.file(origin, "part.stl"),
                   "",
                   "",
                   0,
                   link_,
                   config_.machine,
                   *request.from};
  if (!request.confirmed) {
    const auto look = [order]() -> Errands::Then {
      return [entry = plan_entry(order)]() -> Result<std::string> {
        if (!entry) return tl::unexpected<Error>(entry.error());
        return write_text(entry->preview, "confirm");
      };
    };
    return errands_.begin({job.id, false, true}, look, std::move(done));
  }
  SpooledJob again;
  again.name = plain_name(job.name, 20) + " from " + std::to_string(order.from);
  again.program = true;
  again.user = user;
  const Result<std::uint64_t> id = spool_.begin(again);
  if (!id) return done(tl::unexpected<Error>(id.error()));
  order.number = *id;
  order.to = spool_.file(*id, "program.nc"), order.mark = spool_.file(*id, "entry");
  const auto write = [this, order]() -> Errands::Then {
    return [this, order, rest = write_entry(order)]() -> Result<std::string> {
      if (!rest) return tl::unexpected<Error>(rest.error());
      return run_entry(order.number, *rest, order.job, order.from);
    };
  };
  errands_.begin({*id, true, true}, write,
                 [this, id = *id, done = std::move(done)](Result<std::string> ended) {
                   // What did not come to a program of its own is not kept.
                   const Result<SpooledJob> left = spool_.find(id);
                   if (!ended && left && left->state == JobState::kFailed)
                     static_cast<void>(spool_.remove(id));
                   done(std::move(ended));
                 });
}

/// A tool change that `entered` waits for is over with the start, and not before.
Result<std::string> JobService::run_entry(std::uint64_t id, const ProgramRun& rest, const SpooledJob& entered,
                                          std::uint64_t from) {
  Result<SpooledJob> job = spool_.find(id);
  if (!job) return tl::unexpected<Error>(job.error());
  job->total = rest.subject.total;
  job->hash = hex(rest.subject.program);
  job->state = JobState::kReady;
  job->note = "enters " + name_of(entered.id) + " again before block " + std::to_string(from);
  if (const Result<void> kept = spool_.finish(*job); !kept) return tl::unexpected<Error>(kept.error());
  asked_by_[id] = job->user;
  ResumeDecision fresh;
  fresh.way = ResumeWay::kFresh;
  const Changing changing = changing_;
  const bool changes = entered.state == JobState::kToolChange;
  if (changes && changing.job != entered.id)
    return fail(Code::kCancelled, name_of(entered.id) + " was stopped before that began; nothing moved");
  if (changes) {
    set(entered, JobState::kStopped,
        "entered again at the tool change, as " + name_of(id) + ": " + entered.note);
    changing_ = {};
  }
  const Result<std::string> started = run(*job, rest, fresh);
  if (started) return write_begun(id, "starting " + name_of(id));
  if (changes) {
    set(entered, JobState::kToolChange, entered.note);
    changing_ = changing;
  }
  return started;
}

// ---- ends ------------------------------------------------------------------------------------------------

void JobService::take_run_end() {
  ended_ = runner_->take_end();
  if (!ended_) return;
  judge_run_end(*ended_);
  ended_.reset();
}

void JobService::judge_run_end(const RunView& view) {
  const RunView* const end = &view;
  if (!*end->ended) stand_still(end->job, "the run before it did not come to its end");
  Result<SpooledJob> job = spool_.find(end->job);
  if (!job) return;
  // What was proved before this run stays proved, whether or not the controller has answered.
  job->executed = std::max(job->executed, end->state.executed);
  if (*end->ended && (*end->ended)->change)
    return stand_before(*job, *(*end->ended)->change, end->parked, "");
  if (*end->ended)
    return set(*job, JobState::kDone,
               (*end->ended)->executed ? "every block is executed"
                                       : "every block was sent; this link proves no more");
  std::string why = end->ended->error().message;
  log(Severity::kError, job->id, why, end->state.executed);
  // Where it stood, and what that was on the part: for the black box.
  if (end->state.executed > 0) add_origin(*job, end->state.executed);
  const Result<JournalContent> journal = read_journal_file(spool_.file(job->id, "journal"));
  if (!journal) return set(*job, JobState::kUncertain, why);
  const ResumeDecision decision = decide_resume(*journal, end->subject);
  if (decision.way == ResumeWay::kFresh) return set(*job, JobState::kReady, why);
  // A controller that was asked in vain says nothing about what it was given before.
  if (!end->opened) why += "; " + range_text(decision, job->total);
  if (const auto entry = read_entry_mark(spool_.file(job->id, "entry")))
    why += "; " + (end->opened ? entered_range(*entry, end->state.executed, end->state.sent, job->total)
                               : entered_range(*entry, decision.executed, decision.may_have, job->total));
  if (decision.way == ResumeWay::kToolChange && end->change)
    return stand_before(*job, *end->change, cut_way_advice(link_.kind, config_.machine.format), why);
  if (end->state.phase == Phase::kStopped) return set(*job, JobState::kStopped, why);
  // A controller that restarted or forgot the run has said so: asking it again will not help.
  const bool lost = end->state.loss == Loss::kRestarted || end->state.loss == Loss::kForgotten;
  const bool provable = decision.way == ResumeWay::kContinue && !lost;
  set(*job, provable ? JobState::kInterrupted : JobState::kUncertain, why);
}

void JobService::add_origin(const SpooledJob& job, std::uint64_t block) {
  const auto look = [box = spool_.file(job.id, "blackbox.txt"), program = spool_.file(job.id, "program.nc"),
                     map = spool_.file(job.id, "block.map"), kind = link_.kind, machine = config_.machine,
                     block]() -> Errands::Then {
    std::ofstream out(box, std::ios::app);
    out << "last executed: " << origin_json(program, map, kind, machine, block) << "\n";
    return [] { return std::string(); };
  };
  errands_.begin({job.id, false, false}, look, [](const Result<std::string>&) {});
}

Result<void> JobService::settle() {
  const auto jobs = spool_.list();
  if (!jobs) return tl::unexpected<Error>(jobs.error());
  for (SpooledJob job : *jobs) {
    if (job.state == JobState::kPlanning) set(job, JobState::kReceived, "");
    if (job.state != JobState::kRunning && job.state != JobState::kToolChange) continue;
    const Result<ProgramRun> prepared = prepare_spooled(job, spool_.file(job.id, "program.nc"), link_);
    const Result<JournalContent> journal = read_journal_file(spool_.file(job.id, "journal"));
    if (!prepared || !journal) {
      set(job, JobState::kUncertain, !prepared ? prepared.error().message : journal.error().message);
      continue;
    }
    const ResumeDecision decision = decide_resume(*journal, prepared->subject);
    job.executed = decision.executed;
    ProgramRun at = *prepared;
    at.stand_at(decision.executed);
    std::string text = "the service ended while it ran; " + decision.text;
    if (const auto entry = read_entry_mark(spool_.file(job.id, "entry")))
      text += "; " + entered_range(*entry, decision.executed, decision.may_have, job.total);
    switch (decision.way) {
      case ResumeWay::kFresh:
        set(job, JobState::kReady, text);
        break;
      case ResumeWay::kContinue:
        set(job, JobState::kInterrupted, text + kResumeAsks);
        break;
      case ResumeWay::kFinished:
        set(job, JobState::kDone, text);
        break;
      case ResumeWay::kToolChange:
        if (at.next_change())
          stand_before(job, *at.next_change(), cut_way_advice(link_.kind, config_.machine.format), text);
        else
          set(job, JobState::kUncertain,
              text +
                  "; by its profile the control changes tools now, so it does not go on from there: "
                  "re-enter with --from BLOCK");
        break;
      case ResumeWay::kUncertain:
        set(job, JobState::kUncertain, text);
        break;
    }
  }
  return {};
}

void JobService::leave() {
  stop_plan(plan_);
  help_.give_back();
  proofs_.clear();
  leaving_ = true;
  errands_.withdraw(0);
  queue_moves_ = false;  // also where the run still comes to its end
  worker_->stop();
  if (!runner_->busy()) return;
  if (is_provable(link_.kind)) {
    runner_->command({Order::kHold});
    runner_->detach();
  } else {
    runner_->command({Order::kStop});
  }
}

}  // namespace tiltfeed::daemon
