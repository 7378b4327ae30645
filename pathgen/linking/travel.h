#pragma once
// Ways over the clearance surface: constant z', and the axis never tilted further than the machine can.
// (L2), (L4) in pathgen/linking/README.md.

#include <functional>
#include <vector>

#include "pathgen/linking/link_options.h"
#include "pathgen/linking/opposite_wall.h"
#include "pathgen/tool/move_collision.h"

namespace tiltfeed::pathgen {

class Travel {
 public:
  /// Is a move at constant z' clear of the tool's own columns?
  using IsOver = std::function<bool(Point<Flat> from, Point<Flat> to)>;

  /// `is_over`: asked of each move where the clearance surface may lie under part of the surface. Empty: it
  /// is above all.
  Travel(const Deformation& deformation, const Linking& options, OppositeWall& opposite_wall,
         IsOver is_over = {});

  enum class Way {
    kFound,
    kBlocked,  ///< every way within the tilt limit hits the part
    kTilted,   ///< every way tilts too far
  };
  /// Sets `poses` to those of the moves from `from` to `to`; z' of both is not looked at. The short way round
  /// first, then the others in rising length.
  Way find(Point<Flat> from, Point<Flat> to, std::vector<Pose>& poses);

  /// Does the axis stay within the tilt limit while it turns from a to b?
  bool within_tilt(Vec3 a, Vec3 b) const {
    return unlimited_ || least_cosine(a, b, options_.up) >= least_allowed_;
  }
  /// The pose over the flat point.
  Pose pose(Point<Flat> f) const;

 private:
  using Corners = std::vector<Point<Flat>>;
  Corners detour(Point<Flat> from, Point<Flat> to, double share) const;
  std::vector<Corners> detours(Point<Flat> from, Point<Flat> to) const;
  double least_tilt_y(double x, double near_y) const;
  double steps(Point<Flat> from, Point<Flat> to) const;
  std::vector<Pose> poses_of(const Corners& corners, bool detour) const;
  Way check(const Pose& start, const std::vector<Pose>& poses, const Corners& corners);

  const Deformation& map_;
  const Linking& options_;
  OppositeWall& opposite_wall_;
  IsOver is_over_;
  bool unlimited_;
  double least_allowed_;  ///< cosine of the tilt
};

}  // namespace tiltfeed::pathgen
