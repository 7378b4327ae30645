#pragma once
// The stock that an operation finds: the blank, or the part's box where nobody says what that is, without
// what the operations before have cleared. (U6) in pathgen/plan/README.md.

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "pathgen/axis/deformation.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/plan/cleared_space.h"
#include "pathgen/stock/stock_on_cuts.h"

namespace tiltfeed::pathgen {

class StockBefore {
 public:
  /// Both must outlive it.
  StockBefore(const CheckedMesh& part, const PlanOptions& options);

  /// Does the job say what it is cut from, or was a roughing pattern the first? Else what stands is not
  /// known.
  bool known() const;
  /// Asks all over the stock, a quarter of the cutter's radius apart, so that meets() knows.
  void lay_grid();
  /// Is the cutter in stock anywhere from its end up to `height` (mm) over it, its CL reference and unit axis
  /// as given? By the places of the grid nearest to some on its lower side. Requires: lay_grid(). Any thread
  /// may ask.
  bool meets(Point<Part> reference, Vec3 axis, double height) const;
  /// The z' of `field` over (x', y') down from `from` to which the cutter comes free of stock by half of the
  /// approach, at least `to`. Any thread may ask.
  double free_from(const Deformation& field, Point<Flat> place, double from, double to) const;
  /// The same of the whole tool, for heights over a CL reference along its unit axis.
  double clear_down_to(Point<Part> reference, Vec3 axis, double from, double to) const;
  /// Does the whole tool meet stock on a straight move between two poses, which turns evenly? By places on
  /// it, half of the cutter's radius apart. Any thread may ask.
  bool moves_in(const Pose& from, const Pose& to) const;

 private:
  /// Of each operation before, what cleared a place nearby.
  using Hints = std::vector<const ClearedSpace::Way*>;
  const ToolPiece& cutter() const { return pieces_.front(); }
  bool is_whole() const { return cleared_.empty() && !left_; }
  bool is_stock(Point<Part> place, Hints& hints) const;
  bool is_stock_about(Point<Part> place) const;
  template <class IsStock>
  bool in_stock(Point<Part> reference, Vec3 axis, double height, IsStock is_stock) const;
  template <class IsStock>
  bool over_edges(Point<Part> reference, Vec3 axis, IsStock is_stock) const;
  bool sides_in_stock(Point<Part> reference, Vec3 axis, Hints& hints) const;
  template <class Stands>
  double down_to(double from, double to, Stands stands_at) const;

  const PlanOptions& options_;
  Box box_;                        ///< of the stock
  std::vector<ToolPiece> pieces_;  ///< of this operation, as they are; the first cuts
  std::vector<ClearedSpace> cleared_;
  /// What those operations before that have no field of axes (free, indexed) leave of the box; nothing: none.
  std::optional<StockLeft> left_;
  std::vector<std::uint8_t> grid_;  ///< is that place of the box stock? x, y, then z
  std::array<std::size_t, 3> grid_size_{};
  double grid_step_ = 0.0;
};

}  // namespace tiltfeed::pathgen
