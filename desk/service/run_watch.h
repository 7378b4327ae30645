#pragma once
// What happens on the machine, as its service tells it: asked for again and again, told where it has changed.

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "desk/service/service_link.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed::desk {

/// How a job's part sits on its machine.
struct Placing {
  MachineModel machine;
  Setup setup;                                   ///< of the first operation
  std::map<std::string, Setup> operations = {};  ///< by name: each has the length of its tool

  const Setup& of(const std::string& operation) const {
    const auto found = operations.find(operation);
    return found == operations.end() ? setup : found->second;
  }
};

struct WatchCalls {
  /// An event's name and its JSON, to every page that listens.
  std::function<void(const std::string&, const std::string&)> tell;
  /// Of a job of the service that has begun to run, whose files are in that folder; nothing where it is not
  /// known.
  std::function<std::optional<Placing>(std::uint64_t job, const std::string& folder)> placing;
};

/// Properties: tells `run` and `jobs` only when they have changed; a service that does not answer within
/// kSilence is lost until it does; what is told of a run is then told no more.
class RunWatch {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::milliseconds kRunPeriod{150}, kIdlePeriod{500}, kSilence{3000};
  /// So many of the newest jobs are followed.
  static constexpr std::uint64_t kJobs = 200;

  RunWatch(ServiceLink& link, WatchCalls calls);
  RunWatch(RunWatch&&) = delete;
  ~RunWatch();

  /// Asks what is due.
  void look(Time now);
  /// Milliseconds until look() is due; -1: never.
  int patience_ms(Time now) const;
  /// What a machine command found out: the answer to `status` and the like, JSON.
  void note_status(const std::string& reply);
  /// What is in work beside the run, JSON or "null"; shown with it.
  void note_order(const std::string& order);
  /// What is drawn of the run, JSON or "null"; shown with it.
  void note_scene(const std::string& scene);

  /// Of the job on the machine; 0: none is, or it is not known.
  std::uint64_t job() const;
  /// The folder with the files of the job on the machine; empty as long as it is not known.
  const std::string& folder() const;
  /// JSON: see desk/API.md.
  std::string describe() const;
  std::string jobs() const;
  /// Told when a run has begun or ended, and when the service is there again.
  std::function<void()> turned;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tiltfeed::desk
