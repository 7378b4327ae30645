// How often a surface winds round a point: nested boxes by counting, any facets by their angles one by one.

#include "pathgen/mesh/winding_number.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "kinematics/basics/units.h"
#include "tests/shapes/box_mesh.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

/// [Van Oosterom, Strackee 1983], (8).
double of_angles(const Mesh& mesh, Point<Part> p) {
  double sum = 0.0;
  for (const std::array<std::uint32_t, 3>& f : mesh.facets) {
    const Vec3 a = mesh.vertices[f[0]] - p, b = mesh.vertices[f[1]] - p, c = mesh.vertices[f[2]] - p;
    sum += std::atan2(dot(a, cross(b, c)), length(a) * length(b) * length(c) + dot(a, b) * length(c) +
                                               dot(b, c) * length(a) + dot(c, a) * length(b));
  }
  return sum / (2.0 * kPi);
}

TEST(WindingNumber, CountsNestedBoxes) {
  std::vector<std::array<Vec3, 2>> boxes;
  for (const double half : {1.0, 2.0, 3.0, 4.0, 5.0})
    boxes.push_back({Vec3{-half, -half, -half}, {half, half, half}});
  Mesh mesh = box_mesh(boxes);
  for (int inside = 0; inside <= 5; ++inside)
    EXPECT_NEAR(winding_number(mesh, {5.5 - inside, 0.2, 0.3}), inside, 1e-12);
  for (std::array<std::uint32_t, 3>& f : mesh.facets) std::swap(f[1], f[2]);
  for (int inside = 0; inside <= 5; ++inside)
    EXPECT_NEAR(winding_number(mesh, {5.5 - inside, 0.2, 0.3}), -inside, 1e-12);
}

TEST(WindingNumber, IsTheSumOfTheAnglesOfAnyFacets) {
  std::mt19937_64 random(71);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  for (const double size : {1e-6, 1.0, 1e6})
    for (int k = 0; k < 200; ++k) {
      Mesh mesh;
      const auto any = [&] {
        return Point<Part>{size * place(random), size * place(random), size * place(random)};
      };
      for (int i = 0; i < 60; ++i) mesh.vertices.push_back(any());
      const auto corner = [&] { return static_cast<std::uint32_t>(random() % mesh.vertices.size()); };
      for (int i = 0; i < 500; ++i) mesh.facets.push_back({corner(), corner(), corner()});
      const Point<Part> p = any();
      EXPECT_NEAR(winding_number(mesh, p), of_angles(mesh, p), 1e-9);
    }
}

}  // namespace
}  // namespace tiltfeed
