#pragma once
// What the service does with jobs: receives, plans, starts, holds, resumes, removes; answers requests.

#include <cstdint>
#include <future>
#include <string>
#include <vector>

#include "config/service_config.h"
#include "daemon/api.h"
#include "daemon/job_check.h"
#include "daemon/job_runner.h"
#include "daemon/notify.h"
#include "daemon/planner.h"
#include "daemon/spool.h"

namespace tiltfeed {

/// One machine's jobs. Properties: one job at a time is on the wire, one is planned; every change is in the
/// spool before it is answered; nothing resumes by itself; nothing starts by itself but the next in the
/// queue, when the run before it was executed to its end and no restart, fault or stop lies between.
class JobDesk {
 public:
  /// Settles what an earlier process left: plans again what was being planned, says of what was running
  /// whether it can be resumed. Errors: kIo, kUsage (link; another service has the machine or the spool).
  static Result<JobDesk> open(const ServiceConfig& config, std::function<void()> alive);

  /// One JSON line. `files` were handed over with the request; they stay the caller's.
  std::string answer(const ApiRequest& request, std::uint32_t user, const std::vector<int>& files);
  /// Ends of planning and of runs, the next to plan, the watch folder; call a few times a second.
  void tick();
  /// A new configuration; the machine's wire and profile take effect with the next job. Errors: kUsage.
  Result<void> reload(const ServiceConfig& config);

  bool busy() const { return runner_->busy(); }
  /// The run on the machine has come to its end; the next tick takes it.
  bool run_ended() const { return runner_->busy() && runner_->view().ended.has_value(); }
  /// The streaming loop turns, and says so itself.
  bool streaming() const { return runner_->busy() && runner_->streaming(); }
  /// Hold, and let go of the wire when the machine stands (a link that can prove it), else stop.
  void leave();
  /// For systemd's STATUS.
  std::string status() const;

 private:
  JobDesk(const ServiceConfig& config, const LinkSpec& link, MachineClaim claim, Spool spool,
          std::function<void()> alive);

  Result<std::string> act(const ApiRequest& request, std::uint32_t user, const std::vector<int>& files);
  Result<std::string> show(const SpooledJob& job, const ApiRequest& request) const;
  Result<std::string> start(const SpooledJob& job, bool queue);
  Result<std::string> begin(SpooledJob job);
  Result<std::string> command(const SpooledJob& job, const OperatorCommand& command);
  Result<std::string> resume(SpooledJob job, const ApiRequest& request, std::uint32_t user);
  Result<std::string> enter_again(const SpooledJob& job, const ApiRequest& request, std::uint32_t user);
  Result<std::string> remove(const SpooledJob& job);
  Result<std::string> reset(const ApiRequest& request);
  void take_reset_end();
  Result<std::string> run(SpooledJob job, const JobRun& prepared, const ResumeDecision& decision);
  Result<JobRun> prepare(const SpooledJob& job) const;
  Result<std::string> enqueue(SpooledJob job);
  Result<std::string> leave_queue(SpooledJob job);
  std::string place_text(std::uint64_t job) const;
  Result<void> machine_free(std::uint64_t job) const;
  std::vector<std::uint64_t> queue() const;
  std::string job_json(const SpooledJob& job, const std::vector<std::uint64_t>& queue) const;
  std::string origin_json(const SpooledJob& job, std::uint64_t block) const;

  Result<void> settle();
  void take_run_end();
  void take_plan_end();
  void take_check_end();
  void start_next();
  void stand_still(std::uint64_t job, const std::string& why);
  void plan_failed(SpooledJob job, const std::string& why);
  void plan_next();
  void look_into_watch_folder();
  Result<void> keep(SpooledJob job, JobState state, const std::string& note);
  void set(const SpooledJob& job, JobState state, const std::string& note);
  void log(Severity severity, std::uint64_t job, const std::string& text, std::uint64_t block = 0) const;

  ServiceConfig config_;
  LinkSpec link_;
  MachineClaim claim_;
  Spool spool_;
  PlanProcess plan_;
  ProgramCheck check_;
  std::function<void()> alive_;
  std::future<Result<std::string>> reset_;  ///< of the machine, beside the loop
  std::string reset_text_;                  ///< how the last one ended
  std::unique_ptr<JobRunner> runner_;
  /// The next in the queue starts at the end of the run. Never kept over a restart.
  bool queue_moves_ = false;
};

}  // namespace tiltfeed
