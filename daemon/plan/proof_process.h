#pragma once
// The proof of a program that is written and has no name yet: `tiltfeed-sim prove` as a process of its own,
// so that what judges a program shares neither planner nor post with what made it.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/child_process.h"
#include "kinematics/basics/geometry.h"
#include "kinematics/basics/result.h"
#include "kinematics/joints/joint_path.h"

namespace tiltfeed::daemon {

struct ProofRequest {
  std::string job, stl, machine, operation;  ///< as `tiltfeed plan` has them
  std::string name;                          ///< of the program, for messages
  std::string picture;                       ///< of a gouge; empty: none
};

struct ProofFigures {
  std::uint64_t moves = 0;
  double gouge = 0.0;      ///< the tool comes nowhere deeper into the part, mm
  std::string collisions;  ///< what was checked for collisions, and what not
};

/// Where two bodies come too near to each other.
struct CollisionFound {
  std::size_t operation = 0;  ///< of the program, from 0
  bool rapid = false;
  unsigned line = 0;   ///< of the program's text
  Joints words;        ///< of slides and rotaries
  std::string bodies;  ///< their names
};

/// The deepest gouge.
struct GougeFound {
  std::size_t operation = 0;
  bool rapid = false;
  Point<Part> tip;
};

class ProofProcess {
 public:
  /// Starts it on what is written to the descriptor, which may still grow: it reads the part meanwhile.
  /// Errors: kIo: it is not there, or does not start.
  static Result<ProofProcess> start(const ProofRequest& request, int program);

  /// The program is whole now; waits for the proof. Errors: kInput: a gouge, or words that are not
  /// understood, with file and line; kIo; kCancelled.
  Result<ProofFigures> finish(const StageProgress& progress);
  /// Where finish() has failed for bodies that come too near to each other, not for a gouge or a word: the
  /// first place in words. Else empty.
  const std::string& collision() const { return collision_; }
  /// All places that are known then; those of one pair of bodies are kMostTold at most.
  const std::vector<CollisionFound>& places() const { return places_; }
  static constexpr std::size_t kMostTold = 20;
  const std::optional<GougeFound>& gouge() const { return gouge_; }

 private:
  explicit ProofProcess(config::HeardProcess process) : process_(std::move(process)) {}
  bool take_place(const std::string& line);
  config::HeardProcess process_;  ///< ends with this
  std::string collision_;
  std::vector<CollisionFound> places_;
  std::optional<GougeFound> gouge_;
};

}  // namespace tiltfeed::daemon
