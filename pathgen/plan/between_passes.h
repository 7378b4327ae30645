#pragma once
// What the passes of a path leave between them: how far the tool stays, on all of its cutting moves, from
// places that it could touch. (U2) in pathgen/plan/README.md.

#include <cstdint>
#include <unordered_set>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/tool/tool_pieces.h"

namespace tiltfeed::pathgen {

/// Does the job say what its passes may leave between them? Pencil passes are for the creases alone, rest
/// machining for what is left.
bool leaves_no_more(const PlanOptions& options);

/// What the job lets its passes leave between them, mm: its scallop; or what its step leaves on a plane,
/// twice that where the step is measured on the part and four times where it is flat, for slopes and
/// curvature. The cutter's radius where the job does not say.
double asked_height(const PlanOptions& options);

/// Less than this share of the limit need not be told exactly.
inline constexpr double kEnough = 0.25;

/// An angle of up to a quarter turn is no more than so many times its chord.
inline constexpr double kTurnOfChord = 1.2;

/// The cutting moves of a path, found by where the tool is.
class CuttingMoves {
 public:
  /// Both must outlive it. `piece`: the cutting part; `reference_height`: of the CL reference over the tip.
  CuttingMoves(const std::vector<Move>& moves, const ToolPiece& piece, double reference_height, double step);

  /// How far the tool stays from `place`, mm, on the move on which it comes nearest; negative where it cuts
  /// in. `touching`: the CL reference where it would touch. The least of all moves where that is over
  /// `enough`, else that of one of them. farthest(), where no move comes near enough to tell.
  double left(Point<Part> place, Point<Part> touching, double enough) const;
  double farthest() const { return farthest_; }

 private:
  /// A share of a move that is no longer than a cell.
  struct Way {
    std::uint32_t move = 0;  ///< to moves_[move] from the one before
    float begin = 0.0f, end = 1.0f;
  };
  /// The tool half way along one, and how it moves from there.
  struct Middle {
    Point<Part> ring;
    Vec3 axis;
    double way = 0.0, turn = 0.0;  ///< of the tip, mm, and of the axis, rad, to either end; a little more
  };
  struct Slot {
    std::uint64_t cell = 0;
    std::uint32_t first = 0, count = 0;
  };
  Point<Part> reference(std::size_t move) const;
  std::uint64_t cell_of(Point<Part> p) const;
  const Slot& find(std::uint64_t cell) const;
  void take(std::size_t move);
  Middle middle_of(const Way& way) const;
  double least_gap(Point<Part> place, const Middle& middle) const;
  double moves_by(Point<Part> place, const Middle& middle) const;
  /// The least on that way; where that is no less than `least`, no less than it.
  double gap(Point<Part> place, const Way& way, const Middle& middle, double least) const;
  double unseen(double radius) const;

  const std::vector<Move>& moves_;
  const ToolPiece& piece_;
  double height_, size_, farthest_, widest_search_;
  std::vector<Way> ways_;                     ///< cell by cell
  std::vector<Middle> middles_;               ///< of each of them
  std::vector<Slot> slots_;                   ///< open addressing; count 0: free
  std::unordered_set<std::uint64_t> blocks_;  ///< of four cells along each axis: those with any way
};

}  // namespace tiltfeed::pathgen
