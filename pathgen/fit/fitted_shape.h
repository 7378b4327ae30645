#pragma once
// What is fitted: the kinds of shapes, points to fit them through, and a shape found.

#include <cstddef>

#include "kinematics/basics/geometry.h"

namespace tiltfeed::pathgen {

enum class FitKind { kPlane, kCircle, kSphere, kCylinder, kTorus };

/// "plane", "circle", ...
const char* word_of(FitKind kind);

struct FitPoint {
  Point<Part> place;
  Vec3 normal{};  ///< of the surface there, unit, to be right to some degrees; a cylinder's and a torus's
                  ///< start need it, the others do not look at it
  double weight = 1.0;  ///< say the area that it stands for; > 0
};

/// Standard deviations, from the residuals: what another measurement of the same points would scatter by.
/// Of a short arc they are large, radius and centre together.
struct FitDoubt {
  double centre = 0.0;              ///< mm, in its worst direction
  double axis = 0.0;                ///< rad
  double radius = 0.0, tube = 0.0;  ///< mm
};

struct Fit {
  FitKind kind = FitKind::kPlane;
  Point<Part> centre;  ///< of a plane: the points' middle on it; of a cylinder: the axis next to their middle
  Vec3 axis{0, 0,
            1};  ///< unit: the plane's normal, to the side of the points' normals; the axis of a circle,
                 ///< cylinder or torus, its largest coordinate positive. Of a sphere: no meaning
  double radius = 0.0;       ///< mm; of a torus: of the circle of its tube's centres
  double tube = 0.0;         ///< mm, of a torus
  double rms = 0.0;          ///< of the distances of the points taken, weighted, mm
  double worst = 0.0;        ///< of them, mm
  std::size_t points = 0;    ///< taken
  std::size_t left_out = 0;  ///< outliers
  FitDoubt doubt;
};

/// Of a place from the shape, with a sign but for a circle, mm.
double distance_to(const Fit& shape, Point<Part> place);

}  // namespace tiltfeed::pathgen
