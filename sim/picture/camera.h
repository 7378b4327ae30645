#pragma once
// Where a picture is seen from.

#include "kinematics/basics/tool_path.h"
#include "pathgen/mesh/mesh.h"
#include "sim/picture/rasteriser.h"

namespace tiltfeed::sim {

/// A mild perspective. Directions are unit and perpendicular; `eye` points from the scene to the eye.
class Camera {
 public:
  /// Looks from the side that the tool comes from; everything of the part and of the cutting moves is in the
  /// picture. Requires: the part has vertices.
  Camera(const pathgen::Mesh& part, const ToolPath& path, int width, int height);

  /// Depth is in mm near the scene's centre.
  ScreenPoint project(Point<Part> p) const;
  Vec3 right() const { return right_; }
  Vec3 up() const { return up_; }
  Vec3 eye() const { return eye_; }
  Vec3 view_from(Point<Part> p) const;  ///< unit, from p to the eye
  double scene_radius() const { return radius_; }
  double pixels_per_mm() const { return scale_ / far_; }

 private:
  void aim(const pathgen::Mesh& part, const ToolPath& path);
  void fit(const pathgen::Mesh& part, const ToolPath& path, int width, int height);

  Point<Part> centre_;
  Vec3 right_, up_, eye_;
  double radius_ = 1.0, far_ = 1.0, scale_ = 1.0, shift_x_ = 0.0, shift_y_ = 0.0;
};

}  // namespace tiltfeed::sim
