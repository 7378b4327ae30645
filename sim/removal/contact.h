#pragma once
// The tool against the part along straight steps: how deep it cuts (exactly, whatever the resolution), and
// the probes that its cutting part passes. What may be left out, and why, is in sim/removal/README.md, (W6).

#include <array>
#include <atomic>
#include <span>
#include <vector>

#include "sim/motion/forward.h"
#include "sim/removal/executed_path.h"
#include "sim/removal/probes.h"
#include "sim/removal/tool_sweep.h"

namespace tiltfeed::sim {

class Sheet;
struct Facet;
struct FacetLanes;

/// A straight step of a move: its share [begin, end] of the move, the poses there, and how far any point of
/// the tool may be from the straight way between them, mm.
struct SweptStep {
  std::uint32_t move = 0;
  double begin = 0.0, end = 1.0, stray = 0.0;
  Pose from, to;
};

/// The tool deeper in the part than what is tolerated.
struct Overlap {
  ToolPart tool = ToolPart::kCutter;
  std::uint32_t move = 0;
  double depth = 0.0;       ///< mm
  std::uint32_t patch = 0;  ///< of the probes
  Point<Part> place;        ///< of the tool tip
};

/// What a run of steps does to the part.
struct Contacts {
  std::vector<Overlap> overlaps;   ///< deeper than the tolerance
  std::array<Overlap, 2> worst{};  ///< deepest of feed moves and of rapids, tolerated ones too; or depth 0
};

class Contact {
 public:
  /// `tolerance`: of what is less deep only the deepest is looked for, mm. Outlived by all references.
  Contact(const ExecutedPath& path, const FrameChain& chain, const ToolSolid& solid, const ToolSweep& sweep,
          Probes& probes, double tolerance);

  /// Steps in order, each starting where the one before ends. Thread-safe.
  Contacts meet(const std::vector<SweptStep>& steps) const;
  /// How deep the tool comes over the point during a move, mm; at poses that are near each other.
  double depth(std::uint32_t move, Point<Part> p) const;

 private:
  struct Stretch;
  struct Group;
  struct Four;
  struct Cluster;
  struct Found;
  struct By;
  struct Candidate;
  struct Seen;
  struct View;
  struct Meeting;
  struct Watch;
  struct Run;
  Cube cube(const SweptStep& step) const;
  std::size_t group_end(const std::vector<SweptStep>& steps, std::size_t begin) const;
  Group group(const SweptStep* begin, const SweptStep* end) const;
  Stretch stretch(const Group& group, double low, double high) const;
  void view(Group& group, std::vector<View>& views) const;
  double apart(const Sheet& sheet, const Stretch& stretch) const;
  bool join(Cluster& cluster, std::size_t group, const Run& run) const;
  void cluster(Run& run) const;
  void gather(const Cluster& cluster, Run& run) const;
  void line_up(const Cluster& cluster, Run& run) const;
  void choose(const Facet& facet, std::uint32_t stretches, Run& run) const;
  void choose(const Four& four, const Facet& facet, const FacetLanes& lanes, std::uint32_t stretches,
              Run& run) const;
  double core_least(const Stretch& stretch, const Facet& facet) const;
  bool reaches(const Stretch& stretch, Point<Part> place, Vec3 normal, double most) const;
  std::size_t pick(const Candidate& candidate, const Facet& facet, Run& run) const;
  Seen see(const Group& group, const Facet& facet, Point<Part> middle, double radius, double most) const;
  Seen see_live(const Group& group, const Facet& facet, double most,
                std::span<const Probes::Live> live) const;
  void pass(const Found& found, Run& run) const;
  bool pass_steps(const Candidate& candidate, const Facet& facet, Run& run) const;
  void touch_steps(const Candidate& candidate, const Facet& facet, Run& run) const;
  void meet_steps(const Candidate& candidate, const Seen& seen, double most, Run& run) const;
  bool nearest_is_ball(const View& view, const Seen& seen, double most, double up, double up_end) const;
  double pass_side(const View& view, const Seen& seen, double most, std::span<Probes::Live> live) const;
  void touch(View& view, std::uint32_t patch, Run& run) const;
  void touch_side(View& view, const Facet& facet, Run& run) const;
  void watch(View& view, Run& run) const;
  Pose pose(const SweptStep& step, double f) const;
  int looks(const SweptStep& step) const;
  double travel(const Pose& from, const Pose& to) const;

  const ExecutedPath& path_;
  const FrameChain& chain_;
  const ToolSweep& sweep_;
  Probes& probes_;
  std::vector<std::pair<ToolPart, Revolved>> watched_;  ///< what the core does not cover
  bool round_;   ///< the cutting part is all within radius_ of its core
  bool closed_;  ///< and nothing else is: what the core touches is cut
  double tolerance_, radius_, low_, high_, top_, widest_, look_;
  /// Depths of the deepest that any run has found, of feed moves and of rapids, mm: what is less deep is not
  /// the deepest of all.
  mutable std::array<std::atomic<double>, 2> deepest_{};
};

}  // namespace tiltfeed::sim
