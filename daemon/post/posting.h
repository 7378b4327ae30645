#pragma once
// A whole program before it is text.

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "config/job.h"
#include "daemon/post/printed_arc.h"
#include "daemon/post/tilted_plane.h"
#include "kinematics/basics/path_event.h"
#include "kinematics/basics/tool_path.h"
#include "kinematics/joints/joint_moves.h"

namespace tiltfeed::daemon {

/// The work offset of a tilted plane, and where the rotaries stand in it.
struct PlaneOffset {
  int offset = 1;                   ///< as ProgramData::work_offset
  double tilt = 0.0, rotary = 0.0;  ///< their words, degrees
};

struct ProgramReport {
  std::uint64_t blocks = 0;         ///< motion blocks written
  std::uint64_t clamped_feeds = 0;  ///< F limited to the control's range
  std::uint64_t bytes = 0;
  std::uint64_t planes = 0;                  ///< tilted planes that it is in; 0: none
  std::vector<PlaneOffset> plane_offsets{};  ///< of its planes; empty: they have the program's
  std::uint64_t arcs = 0;                    ///< of the blocks
  std::uint64_t arcs_stand_for = 0;          ///< straight blocks that the arcs are instead of
};

/// Largest relative error of a printed F, where the dialect's decimals of F allow it.
inline constexpr double kFeedError = 1e-4;

/// P of G64 as a share of what corners may be rounded off by: LinuxCNC 2.9 was up to 1.05 P off
/// (tests/linuxcnc).
inline constexpr double kBlendWord = 0.8;

/// One tool at work, or one of its stretches between retracts, as each of its planes is.
struct Operation {
  /// The words: joints rounded to the printed decimals; under TCP those of `words_under_tcp`.
  const JointPath* words = nullptr;
  Setup setup;
  ToolData tool;
  int tool_number = 0;  ///< 0: no tool change
  Feed cut_feed, plunge_feed;
  std::vector<FeedChange> feeds;  ///< as in ToolPath
  std::vector<PathEvent> events;  ///< by rising move; `move` counts as JointMove::move
  int length_register = 0;        ///< 0: that of the tool's number
  /// Its words are in this plane; the rotaries stand. The machine's format is config::in_tilted_planes().
  std::optional<TiltedPlane> plane{};
  std::vector<PrintedArc> arcs{};  ///< by rising block
  bool goes_on = false;            ///< with the tool of the operation before, from the retract
  SwingWay way{};                  ///< to it from there
  config::OperationName name{};    ///< of a job's operations; empty: it is no such
  bool keeps_tool = false;         ///< the tool of the operation before stays in the spindle
  config::Smoothing smoothing = config::Smoothing::kNone;
  double smoothing_tolerance = 0.0;  ///< as in config::ProgramData, mm

  /// The arc that ends with this block of the words; none: it is straight.
  const PrintedArc* arc(std::size_t block) const {
    const auto at =
        std::lower_bound(arcs.begin(), arcs.end(), block,
                         [](const PrintedArc& one, std::size_t wanted) { return one.block < wanted; });
    return at != arcs.end() && at->block == block ? &*at : nullptr;
  }
};

/// A whole program.
struct Posting {
  std::string name;  ///< of the part
  config::MachineProfile machine;
  config::ProgramData data;
  std::vector<Operation> operations;
  std::string proof{};  ///< a word on the program's proof for its header; empty: none
  /// Machining time for the header, accelerations and stops included, s; nothing: the sum of the blocks' own.
  std::optional<double> seconds{};
  std::string start{};  ///< a word on the height at which TCP begins, for the header; empty: none
};

/// What the header of a program says beyond the job's own words: as in Posting.
struct HeaderFacts {
  std::string proof;
  std::optional<double> seconds;
  std::string start{};
};

}  // namespace tiltfeed::daemon
