#pragma once
// The thread that streams: one job at a time on the machine's wire.

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "daemon/journal/program_run.h"
#include "daemon/program/block_cursor.h"
#include "daemon/program/operation_span.h"
#include "daemon/service/run_tally.h"

namespace tiltfeed::daemon {

/// What a run needs beside its program.
struct RunOrder {
  ProgramRun run;
  ResumeDecision decision;
  std::string journal;   ///< file
  std::string wire_log;  ///< file that is written when the run fails
  std::string way_back;  ///< file: the way back to the part after a tool change; empty: none
  MachineModel machine;  ///< for machine time
  /// Makes the file that parks the machine before a tool change. Errors: why it cannot be parked.
  std::function<Result<std::string>(const ToolChange&)> park = {};
  std::string cut_way = {};  ///< what is to be said of a machine whose parking was cut off
};

/// As it stands; the end when `ended`.
struct RunView {
  std::uint64_t job = 0;
  LinkKind link = LinkKind::kGrbl;
  SendState state;
  double seconds = 0.0;            ///< since it started or went on
  double silent_seconds = 0.0;     ///< since the controller was last heard; 0 over a drip feed
  double machine_seconds = 0.0;    ///< of the program; 0: not known, or on a way at a tool change
  double remaining_seconds = 0.0;  ///< by machine time, scaled by how this run keeps to it
  std::optional<Result<SendReport>> ended;
  RunSubject subject;                     ///< what runs
  std::optional<ToolChange> change = {};  ///< that was made before it began
  std::string operation;                  ///< of the job, of the newest executed block; empty: it has none
  std::string parked;                     ///< how the parking before the next one went
  bool opened = false;                    ///< the controller was ready for blocks
  RunTally tally;                         ///< of the job's own blocks, and of the ways at a tool change
};

/// Whether the run's own session would refuse this override, of which nobody is told then. Errors: kUsage.
Result<void> can_override(const OperatorCommand& command, const RunView& run);

/// Remaining time: what is left by machine time, times how much longer than planned this run has taken so
/// far. `run_from`: machine time at which it began. Pure.
double remaining_seconds(const ProgramTime& time, std::uint64_t executed, double run_from, double seconds);

class StreamThread {
 public:
  /// `alive` is called from the streaming loop, about ten times a second.
  explicit StreamThread(std::function<void()> alive) : alive_(std::move(alive)) {}
  ~StreamThread();

  bool busy() const { return thread_.joinable(); }
  /// The loop turns: before that the thread reads the program.
  bool streaming() const { return streaming_; }
  /// Requires: not busy.
  void start(const RunOrder& order);
  void command(const OperatorCommand& command) { commands_.push(command); }
  /// The same from any thread, if it is this job that is on the machine; 0: whichever is.
  bool command(std::uint64_t job, const OperatorCommand& command);
  /// Lets go of the wire once the machine is held, the controller's session left as it is.
  void detach() { detach_ = true; }
  RunView view() const;
  /// The end of the run, once; then it is not busy any more.
  std::optional<RunView> take_end();

 private:
  void stream(const RunOrder& order);
  class OnWay;
  void park(const RunOrder& order, const ToolChange& change, Link& link, Clock& clock, StreamHooks hooks);
  Result<void> go_back(const RunOrder& order, Link& link, Clock& clock, StreamHooks hooks);
  bool note(const SendState& state);

  std::function<void()> alive_;
  CommandQueue commands_;
  std::atomic<bool> detach_{false}, streaming_{false};
  std::thread thread_;
  mutable std::mutex mutex_;  // guards what follows
  RunView view_;
  std::shared_ptr<const ProgramTime> time_;
  std::vector<OperationSpan> operations_;
  bool on_way_ = false;  ///< before a tool change or behind it
  std::optional<double> began_at_machine_time_;
  std::chrono::steady_clock::time_point began_, heard_;
};

}  // namespace tiltfeed::daemon
