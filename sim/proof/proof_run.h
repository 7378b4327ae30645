#pragma once
// Some moves in a row, held against the part: what Prover::hold is made of.

#include <array>
#include <span>
#include <vector>

#include "sim/proof/convex_gap.h"
#include "sim/proof/proof.h"

namespace tiltfeed::sim {

// Gaps are found to within this, mm.
inline constexpr double kGapError = 1e-7;
// A core that is nearer to the part than this is in it, mm.
inline constexpr double kPierced = 1e-6;

/// Some moves in a row, one core after the other.
class Prover::Run {
 public:
  Run(const Prover& prover, std::span<const ProgramMove> moves, double known);
  Proof hold();

 private:
  /// A move as the tool makes it; its begin is the end of the one before, unless it jumps.
  struct Way {
    Pose from, to;
    Pose middle = {};  ///< where a rotary turns
    double stray = 0.0;
  };
  /// Moves first..last, or a share of one. The tool is within `stray` of the hull of where it is at both
  /// ends.
  struct Node {
    std::size_t first = 0, last = 0;
    double begin = 0.0, end = 1.0;
    Pose from, to;
    double stray = 0.0;
    int halvings = 0;
    std::array<Vec3, 4>
        ends{};  ///< of the core's axis: low and high where it begins, low and high where it ends
  };

  Node with_ends(Node node) const;
  Node node(std::size_t first, std::size_t last) const;
  Node part_of(const Node& whole, double begin, double end) const;
  bool halves(const Node& whole, Node& left, Node& right) const;
  double length_of(const Node& node) const;
  double slack(const Node& node) const;
  double enough(const Node& node) const {
    return std::max(kPierced, core_->rounding - level_) * core_->sharpness + node.stray;
  }
  Vec3 furthest(const Node& node, Vec3 u) const;
  bool far(const Node& node) const;
  void gather(const Node& node);
  void hold(const Node& node);
  void hold(const Node& node, std::size_t begin, std::size_t end);
  bool clear(const Node& node, double nearest, const Triangle& facet, bool divides, double& width);
  Gap gap_to(const Node& node, const Triangle& facet, double need, double hopeless) const;
  double width_at(const Node& node, double share, const Triangle& facet) const;
  double nearest_share(const Node& node, const Triangle& facet, double enough, double fine,
                       double& width) const;
  void tell(const Node& node, double share, double depth, const Triangle& facet);

  const Prover& prover_;
  std::span<const ProgramMove> moves_;
  std::vector<Way> ways_;
  const ToolCore* core_ = nullptr;
  double level_ = 0.0;                   ///< less deep is not looked for, mm
  Vec3 along_;                           ///< the last direction that told tool and part apart
  std::vector<const Triangle*> facets_;  ///< a stack: of each node those that its whole has left
  Pose far_from_;                        ///< there the core has room_ more than it needs
  double room_ = -1.0, ask_room_ = 0.0;
  int clear_looks_ = 0;  ///< in a row
  int told_ = 0;         ///< moves that cut too deep, and the last of them
  std::size_t told_move_ = 0;
  Proof proof_;
};

}  // namespace tiltfeed::sim
