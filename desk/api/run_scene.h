#pragma once
// What stands in the view of a run: the path that its program really makes, and the part that it is made
// from. Both are read by processes of their own.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/job.h"
#include "desk/http/http_message.h"
#include "desk/service/run_watch.h"
#include "desk/view/tool_outline.h"
#include "desk/work/child_process.h"

namespace tiltfeed::desk {

/// Files of this computer; empty: there is none, or it is not known.
struct SceneInput {
  std::uint64_t job = 0;  ///< of the service
  std::string program, machine, part;
  std::string unit = "mm";               ///< of the part
  std::vector<std::string> bodies = {};  ///< of the part; empty: all
  std::vector<ToolOutline> tool;         ///< of the first operation
  /// Of each operation that has a name, in the order of the program.
  std::vector<std::pair<std::string, std::vector<ToolOutline>>> operations = {};
};

/// What is drawn of a job but for its number and program. `part`, `machine`: the files that it was read with.
/// Requires: at least one operation.
SceneInput scene_of(const std::vector<config::Job>& jobs, const std::string& part,
                    const std::string& machine);

/// Where its tools are on the part. Requires: at least one.
Placing placing_of_operations(const std::vector<config::Job>& jobs);

/// Properties: stays until the next run begins, so that what a run ended in can still be seen; what cannot
/// be drawn is told as a refusal with its reason.
class RunScene {
 public:
  /// `tiltfeed` reads programs, `self` reads parts; `folder`: where the files are kept; `told`: it has
  /// changed.
  RunScene(std::string tiltfeed, std::string self, std::string folder, std::function<void()> told);

  /// In place of the scene before.
  void begin(SceneInput input);
  /// JSON: null, or `job`, `path` and `part`, each none, working, ready or refused, `error` where one is
  /// refused, `tool`.
  std::string describe() const;
  /// Points of the path, as `tiltfeed unpost --drawing` writes them.
  Reply path() const;
  /// Nine numbers for each facet of the part.
  Reply mesh() const;

  int descriptor() const { return child_ ? child_->descriptor() : -1; }
  void hear();

 private:
  enum class State { kNone, kWaiting, kReady, kRefused };
  /// What a process reads.
  struct Piece {
    const char* name;
    State state = State::kNone;
    std::vector<std::string> words = {};
  };
  void start_next();
  void refuse(Piece& piece, std::string why);
  Reply file(const Piece& piece, const char* name) const;

  std::string tiltfeed_, self_, folder_;
  std::function<void()> told_;
  SceneInput input_;
  Piece path_{"path"}, part_{"part"};
  Piece* in_work_ = nullptr;
  std::string error_;
  std::optional<ChildProcess> child_;
};

}  // namespace tiltfeed::desk
