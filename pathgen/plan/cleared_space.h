#pragma once
// The space that an operation before has cleared. (U6) in pathgen/plan/README.md.

#include <cstdint>
#include <limits>
#include <unordered_map>
#include <vector>

#include "pathgen/axis/deformation.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/tool/tool_pieces.h"

namespace tiltfeed::pathgen {

/// All that the cutting part swept on the cutting moves of an operation, with what is above it along its
/// axis: there the tool itself has been, or stock that it would have run into.
class ClearedSpace {
 public:
  /// `cut` must outlive it. Where the operation has no axis field (free, indexed) nothing counts as cleared.
  explicit ClearedSpace(const EarlierCut& cut);

  /// Has the tool been there, or within `slack` (mm) of it? Properties: 1 Never true of a place that no move
  /// comes within `slack` of. 2 True of all that a straight move with one axis comes to, as far as that is
  /// told by the place of the move nearest to it. Any thread may ask.
  bool holds(Point<Part> place, double slack) const;

  /// A piece of a move, straight.
  struct Way {
    Point<Part> from, to;  ///< of the tip
    Vec3 from_axis, to_axis, middle_axis{};
    double half = 0.0;  ///< of its length, mm
    double turn = 0.0;  ///< of the axis, rad; a little more

    Vec3 axis_at(double share) const {
      return share == 0.0   ? from_axis
             : share == 1.0 ? to_axis
                            : normalized(from_axis * (1.0 - share) + to_axis * share);
    }
  };
  /// The same. `hint`: what held a place nearby, null for none; set to what holds this one.
  bool holds(Point<Part> place, double slack, const Way*& hint) const;

 private:
  struct Column {
    std::int64_t x = 0, y = 0;
    bool operator==(const Column&) const = default;
  };
  struct ColumnHash {
    std::size_t operator()(const Column& c) const {
      return static_cast<std::size_t>(c.x) * 0x9E3779B97F4A7C15u ^ static_cast<std::size_t>(c.y);
    }
  };
  struct Ways {
    double lowest = std::numeric_limits<double>::infinity();  ///< z' that no tool of theirs comes under, mm
    std::vector<Way> all;
  };
  void take(std::uint32_t move);
  bool passes(const Way& way, Point<Part> place, double slack) const;
  bool touches(const Way& way, double share, Point<Part> place, double slack) const;
  Column column(double x, double y) const;

  const EarlierCut& cut_;
  ToolPiece piece_;
  double height_ = 0.0;
  Deformation map_;
  bool known_ = false;
  double size_x_ = 1.0, size_y_ = 1.0, length_ = 1.0;  ///< of a column, mm of flat space; of a way, mm
  double half_x_ = 0.0, half_y_ = 0.0;                 ///< of a way in flat space, at most, mm
  std::int64_t count_x_ = 0, count_y_ = 0;             ///< columns in a turn; 0: it does not wrap
  std::unordered_map<Column, Ways, ColumnHash> ways_;
};

}  // namespace tiltfeed::pathgen
