#pragma once
// What the service does with jobs: receives, plans, starts, holds, resumes, removes; answers requests.

#include <chrono>
#include <cstdint>
#include <functional>
#include <future>
#include <map>
#include <string>
#include <vector>

#include "config/service_config.h"
#include "daemon/machine/machine_worker.h"
#include "daemon/service/api.h"
#include "daemon/service/digest_check.h"
#include "daemon/service/job_errands.h"
#include "daemon/service/notify.h"
#include "daemon/service/plan_help.h"
#include "daemon/service/plan_orders.h"
#include "daemon/service/planner.h"
#include "daemon/service/service_counts.h"
#include "daemon/service/spool.h"
#include "daemon/service/spool_shop.h"
#include "daemon/service/spool_states.h"
#include "daemon/service/spooled_run.h"
#include "daemon/service/stream_thread.h"
#include "daemon/service/watched_folder.h"
#include "daemon/shop/shop_live.h"

namespace tiltfeed::daemon {

/// Ends the note of an interrupted job, as long as its controller can be asked.
inline constexpr const char* kResumeAsks =
    "; resume asks the controller, which counts what it executed, and goes on after that";

/// One machine's jobs. One at a time is planned here.
/// Properties: 1 One at a time is on the wire. 2 Every change is in the spool before it is told, or it is
/// told with "not in the spool yet". 3 Nothing resumes by itself. 4 Nothing starts by itself but the next in
/// the queue, when the run before it was executed to its end and no restart, fault or stop lies between.
class JobService {
 public:
  /// Settles what an earlier process left: plans again what was being planned, says of what was running
  /// whether it can be resumed. Errors: kIo, kUsage (link; another service has the machine or the spool).
  static Result<JobService> open(const config::ServiceConfig& config, std::function<void()> alive);

  /// `reply` gets one JSON line, at once or out of a later tick: what takes long is done beside the loop.
  /// `files` were handed over with the request.
  void ask(const ApiRequest& request, std::uint32_t user, HandedFiles files,
           std::function<void(std::string)> reply);
  /// An order to this job, if it is the one on the machine; the reply. From any thread, without a lock or a
  /// disk in its way.
  std::optional<std::string> order(const ApiRequest& request);
  /// What was asked, into the log.
  void note_request(const ApiRequest& request, std::uint32_t user) const;
  /// Ends of planning and of runs, the next to plan, the watch folder; call a few times a second.
  void tick();
  /// Ends of what was asked for and takes a while; somebody waits for one while `in_work`.
  void take_ends();
  bool in_work() const { return !errands_.empty() || !arrivals_.empty(); }
  /// A new configuration; the machine's wire and profile take effect with the next job. Errors: kUsage.
  Result<void> reload(const config::ServiceConfig& config);

  /// What the shop's thread asks, each as ShopLedger says. `done` gets no text.
  Result<LocalShop> read_shop();
  SpoolShop shop_record() const { return spool_.shop(); }
  SpoolStates shop_states() const { return spool_.shop_states(); }
  void take_from_shop(const ShopJob& job, HandedFiles files, Done done);
  Result<void> overrule(const std::string& shop_job, const std::string& why);
  void show_shop(const std::string& text) { shop_text_ = text; }
  /// What the shop's thread asks of orders of planning, each as PlanLedger says; without a version.
  Result<LocalPlans> read_plans();
  Result<void> plan_told(const std::string& id, const PlanStanding& standing);
  Result<void> plan_helpers(bool idle);
  Result<void> plan_returned(const std::string& id, const std::string& helper, const std::string& from,
                             const std::vector<int>& files);
  Result<bool> plan_take(const PlanTaken& order, const std::vector<int>& files);
  void plan_settled(const std::string& id);
  /// `wake` is called while something is not told to the shop yet.
  void on_shop_news(std::function<void()> wake);
  /// The service is about to end: with a machine that is let go of in order, that is on record.
  void leave_shop();

  bool busy() const { return runner_->busy() || worker_->busy(); }
  /// The run on the machine has come to its end; the next tick takes it.
  bool run_ended() const { return runner_->busy() && runner_->view().ended.has_value(); }
  /// The streaming loop turns, and says so itself.
  bool streaming() const { return runner_->busy() && runner_->streaming(); }
  /// Hold, and let go of the wire when the machine stands (a link that can prove it), else stop.
  void leave();
  /// For systemd's STATUS.
  std::string status() const;

 private:
  JobService(const config::ServiceConfig& config, const LinkSpec& link, MachineClaim claim, Spool spool,
             std::function<void()> alive);

  Result<std::string> act(const SpooledJob& job, const ApiRequest& request);
  Result<std::string> list(std::uint64_t after) const;
  Result<std::string> history(std::uint64_t job, std::uint64_t after) const;
  void tidy();
  void find_outdated();
  void begin_run(const SpooledJob& job, std::uint64_t first);
  void end_run(const SpooledJob& job, const std::string& note);
  void show(const SpooledJob& job, const ApiRequest& request, const Done& done);
  void start(const SpooledJob& job, bool queue, Done done);
  void begin(const SpooledJob& job, Done done);
  Result<std::string> command(const SpooledJob& job, const OperatorCommand& command);
  std::string told() const;
  void resume(const SpooledJob& job, const ApiRequest& request, std::uint32_t user, Done done);
  void go_on(const SpooledJob& job, Done done);
  void enter_again(const SpooledJob& job, const ApiRequest& request, std::uint32_t user, Done done);
  Result<std::string> run_entry(std::uint64_t id, const ProgramRun& rest, const SpooledJob& entered,
                                std::uint64_t from);
  Result<std::string> remove(const SpooledJob& job);
  Result<std::string> reset(const ApiRequest& request);
  Result<void> may_reset() const;
  void begin_reset(std::uint64_t stopped);
  Result<std::string> forget_run(const SpooledJob& job);
  void take_reset_end();
  void tool(const SpooledJob& job, const ApiRequest& request, Done done);
  void stand_before(SpooledJob job, const ToolChange& change, const std::string& parked,
                    const std::string& why);
  WayOrder way_order(std::uint64_t job) const;
  std::function<Result<std::string>(const ToolChange&)> parking(std::uint64_t job) const;
  Result<std::string> take_length(const SpooledJob& job, const std::string& text);
  void go_back(const SpooledJob& job, bool confirmed, Done done);
  std::string change_text() const;
  Result<std::string> machine(const ApiRequest& request);
  Result<std::string> follow_order(const ApiRequest& request);
  void note_moved(const MachineOrder& order, const std::vector<std::string>& words);
  Result<std::string> while_running(const MachineOrder& order, const std::vector<std::string>& words);
  Result<SpooledJob> job_on_machine();
  Result<std::string> run(SpooledJob job, const ProgramRun& prepared, const ResumeDecision& decision,
                          const std::string& way_back = "", const std::string& held = "");
  Result<std::string> enqueue(SpooledJob job);
  Result<std::string> leave_queue(SpooledJob job);
  Result<void> not_an_entry(const SpooledJob& job) const;
  std::string place_text(std::uint64_t job) const;
  Result<void> machine_free(std::uint64_t job) const;
  std::vector<std::uint64_t> queue() const;
  std::string job_json(const SpooledJob& job, const std::vector<std::uint64_t>& queue) const;

  Result<void> settle();
  void tell_mark() const;
  void take_run_end();
  void tell_hold();
  void judge_run_end(const RunView& end);
  void add_origin(const SpooledJob& job, std::uint64_t block);
  void take_plan_end();
  void take_check_end();
  void start_next();
  void stand_still(std::uint64_t job, const std::string& why);
  void plan_failed(SpooledJob job, const std::string& why);
  void plan_next();
  bool is_at_work() const;
  bool may_help() const;
  bool is_planned_elsewhere(const SpooledJob& job, bool free);
  void plan_here(std::uint64_t id, const std::string& why);
  void take_proof_ends();
  void give_up_silent();
  void forget_plan(std::uint64_t job);
  std::string counts_json() const;
  void tend_help();
  void look_into_watch_folder();
  void take_watched(const WatchedFolder& found);
  void forget_watched(const std::string& path, const FileStamp& stamp);
  const char* shop_word() const;
  ShopLive shop_live() const;
  bool note_shop_state(const std::string& word);
  void tell_shop();
  void note_settled(const SpooledJob& job);
  Result<void> keep(SpooledJob job, JobState state, const std::string& note);
  void set(const SpooledJob& job, JobState state, const std::string& note);
  void log(Severity severity, std::uint64_t job, const std::string& text, std::uint64_t block = 0) const;

  config::ServiceConfig config_;
  /// The tool change that a job stands before.
  struct Changing {
    std::uint64_t job = 0;  ///< 0: none does
    ToolChange change = {};
    std::string parked = {};
    std::optional<double> length = {};  ///< of the tool that was mounted
  };

  LinkSpec link_;
  MachineClaim claim_;
  Spool spool_;
  PlanProcess plan_;
  PlanOrders orders_;                                      ///< plans that other services are asked for
  std::vector<PlanProcess> proofs_;                        ///< of what came back
  PlanHelper help_;                                        ///< for others
  std::chrono::steady_clock::time_point shop_asked_ = {};  ///< when the shop's thread asked last
  ServiceCounts counts_;
  DigestCheck check_;
  Errands errands_;
  Arrivals arrivals_;
  bool leaving_ = false;
  Changing changing_;
  std::future<Result<std::string>> reset_;  ///< of the machine, beside the loop
  std::string told_hold_;                   ///< in the log already
  std::string reset_text_;                  ///< how the last one ended
  std::uint64_t stopped_ = 0;               ///< the interrupted job that an operator ends by it
  std::unique_ptr<StreamThread> runner_;
  std::unique_ptr<MachineWorker> worker_ = std::make_unique<MachineWorker>();
  std::map<std::uint64_t, std::uint32_t> asked_by_;  ///< by job: who gave the word to run
  std::optional<RunView> ended_;                     ///< the run whose end is being taken
  std::vector<Outdated> outdated_;                   ///< jobs to remove, the first at the end
  std::chrono::steady_clock::time_point tidy_due_;   ///< when they are looked for again
  bool watching_ = false;                            ///< somebody looks into the watch folder, or takes of it
  SeenFiles seen_;                                   ///< in it
  std::string watch_trouble_;                        ///< with it, as it was said last
  std::chrono::steady_clock::time_point watch_due_;  ///< when it is looked into again
  std::function<void()> shop_wake_;                  ///< empty: no shop
  std::string shop_text_ = "not connected yet";      ///< how it stands with the shop's database
  std::string shop_state_;                           ///< of the machine, as it is on record
  std::uint64_t shop_noted_ = 0, shop_alive_ = 0;    ///< when that, and a sign of life, were written; ms
  std::map<std::uint64_t, std::string> unsettled_;   ///< jobs that were cut off, and why
  /// The next in the queue starts at the end of the run. Never kept over a restart.
  bool queue_moves_ = false;
};

}  // namespace tiltfeed::daemon
