#pragma once
// Where shank and holder enter stock that is left, on feed moves. (LE4), (LE5) in pathgen/stock/README.md.

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/options/cutter.h"
#include "pathgen/progress/watch.h"
#include "pathgen/stock/stock_lines.h"

namespace tiltfeed::pathgen {

/// Of one part of the tool, on all feed moves of an operation.
struct StockContact {
  double depth = 0.0;        ///< the deepest, mm; 0: none
  std::uint64_t places = 0;  ///< stretches of the way, a cutter's diameter or more from each other
  double length = 0.0;       ///< of the tip's way in contact, mm
  Pose at;                   ///< of the tool, where it is the deepest
};
struct StockOnCuts {
  double apart = 0.0;  ///< of the stock's lines, mm
  double touch = 0.0;  ///< so deep is no contact yet, mm
  StockContact shank, holder;
};

/// How an operation moves which tool.
struct ToolMoves {
  const Cutter* cutter = nullptr;
  const std::vector<Move>* moves = nullptr;
  double tolerance = 0.0;  ///< mm: so much of a touch is none
};

/// What is left of a blank, operation by operation.
class StockLeft {
 public:
  /// `operations`: all that are to cut it, in their order; they say where its lines run and how near to each
  /// other they are. `blank`: closed.
  StockLeft(const Mesh& blank, const std::vector<ToolMoves>& operations);

  /// The next of them cuts. Properties: 1 What is not within the cutter on a feed move stays. 2 Shank and
  /// holder take nothing before the operation is over, so that the depth is that in what cutters have left;
  /// then what they went through is gone. 3 A contact is told where one of the lines meets it, deeper than
  /// StockOnCuts::touch. Nothing: it was cancelled.
  std::optional<StockOnCuts> cut(const ToolMoves& operation, const ReportShare& report);
  /// The next of them cuts, and all of its tool takes what it meets on feed moves; nobody is told.
  void clear(const ToolMoves& operation);
  const StockLines& lines() const { return lines_; }

 private:
  void take_met();
  StockLines lines_;
  std::vector<RoundSolid> met_solids_;             ///< of the operation before
  std::vector<std::pair<std::size_t, Pose>> met_;  ///< which of them stood in stock, where
};

}  // namespace tiltfeed::pathgen
