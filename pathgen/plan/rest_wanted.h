#pragma once
// Rest machining: where the operations before leave too much on the part, and which poses take it. (U6) in
// pathgen/plan/README.md.

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/options/plan_report.h"
#include "pathgen/plan/stock_before.h"
#include "pathgen/progress/watch.h"

namespace tiltfeed::pathgen {

class RestWanted {
 public:
  /// Looks at the part in cells as large as a third of the smallest tool's radius. All must outlive it.
  /// Requires: options.rest_more_than > 0. Errors: kInput: no operation before, or one whose cutter is too
  /// small to tell; kUnreachable: no more than that is left anywhere; kCancelled.
  static Result<RestWanted> find(const CheckedMesh& part, const PlanOptions& options,
                                 const ReportShare& report);

  /// Does the cutter at this pose take of what is left too much? Its reference and axis. True: some cell of
  /// which more than `rest_more_than` is left loses half of that, and the cutter comes within half its radius
  /// of it; or (roughing) the cutter is in stock.
  bool wants(Point<Part> reference, Vec3 axis) const;

  /// What stands there.
  const StockBefore& stock() const { return stock_; }

  /// What was found.
  const RestBefore& before() const { return before_; }
  /// Distance at which a pass is asked, mm.
  double spacing() const { return cell_; }

 private:
  struct Cell {
    Point<Part> place;
    double left = 0.0;  ///< mm
  };
  RestWanted(const CheckedMesh& part, const PlanOptions& options);
  Result<void> look(const ReportShare& report);
  double left_at(Point<Part> place, Vec3 normal, double area);
  std::uint64_t key(std::int64_t x, std::int64_t y, std::int64_t z) const;
  std::int64_t index(double v) const;

  const CheckedMesh& part_;
  const PlanOptions& options_;
  ToolPiece piece_;  ///< of this operation, as it is
  StockBefore stock_;
  double cell_ = 0.0, reach_ = 0.0;
  RestBefore before_;
  std::unordered_map<std::uint64_t, std::vector<Cell>> cells_;  ///< by cubes of the reach
};

}  // namespace tiltfeed::pathgen
