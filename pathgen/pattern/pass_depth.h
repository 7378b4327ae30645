#pragma once
// How low passes come, place by place: what of shank and holder lies under them need not be looked at. (G2)
// in pathgen/pattern/README.md.

#include <cstdint>
#include <vector>

#include "pathgen/pattern/passes.h"
#include "pathgen/surface/cl_field.h"

namespace tiltfeed::pathgen {

/// z' that is the lowest of the passes in each square of flat space, less a little.
class PassDepth {
 public:
  /// `field`: that of the passes.
  PassDepth(const Passes& passes, const ClField& field, const PlanOptions& options);

  /// Over all places.
  double of_all() const { return of_all_; }
  /// Over all places of the passes in the rectangle.
  double in(double low_x, double high_x, double low_y, double high_y) const;

  /// Does the place lie no lower than the passes about it? Its x' and y' may be a turn on.
  bool knows(Point<Flat> place) const;

 private:
  /// Squares of a block in one direction.
  static constexpr std::int64_t kBlock = 8;

  void sum_up();
  std::int64_t column(double x) const;
  std::int64_t row(double y) const;
  void add(Point<Flat> a, Point<Flat> b);

  FlatBounds bounds_;
  double slack_;  ///< mm
  double size_ = 1.0;
  std::int64_t columns_ = 1, rows_ = 1, blocks_ = 1;
  double period_x_, period_y_;
  std::vector<double> lowest_, of_block_;
  double of_all_;
};

}  // namespace tiltfeed::pathgen
