// Vectors, great circles, rotations, and numbers as decimal text.

#include "kinematics/basics/geometry.h"

#include <gtest/gtest.h>

#include <charconv>
#include <random>

#include "kinematics/basics/decimal.h"
#include "kinematics/basics/units.h"

namespace tiltfeed {
namespace {

Vec3 random_unit(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return normalized(Vec3{normal(random), normal(random), normal(random)});
}

TEST(Geometry, CrossIsRightHandedAndPerpendicular) {
  EXPECT_EQ(cross(Vec3{1, 0, 0}, Vec3{0, 1, 0}), (Vec3{0, 0, 1}));
  EXPECT_EQ(cross(Vec3{0, 1, 0}, Vec3{0, 0, 1}), (Vec3{1, 0, 0}));
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 a = random_unit(random), b = random_unit(random);
    EXPECT_NEAR(dot(cross(a, b), a), 0.0, 1e-15);
    EXPECT_NEAR(squared_length(cross(a, b)) + dot(a, b) * dot(a, b), 1.0, 1e-14);
  }
}

TEST(Geometry, AngleBetweenIsExactNearZeroAndPi) {
  for (const double angle : {0.0, 1e-12, 1e-9, 1e-6, 0.5, 1.5, 3.0, kPi - 1e-6, kPi - 1e-9}) {
    const Vec3 a{3, 0, 0}, b{2 * std::cos(angle), 2 * std::sin(angle), 0};
    EXPECT_NEAR(angle_between(a, b), angle, 1e-15 + 1e-15 * angle);
  }
}

TEST(Geometry, SlerpKeepsTheGreatCircleAndItsSpeed) {
  std::mt19937 random(2);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 a = random_unit(random), b = random_unit(random);
    const double whole = angle_between(a, b);
    for (const double f : {0.0, 0.25, 0.5, 0.9, 1.0}) {
      const Vec3 u = slerp(a, b, f);
      EXPECT_NEAR(length(u), 1.0, 1e-14);
      EXPECT_NEAR(angle_between(a, u), f * whole, 1e-12);
      EXPECT_NEAR(dot(u, cross(a, b)), 0.0, 1e-14);
    }
  }
  EXPECT_EQ(slerp({0, 0, 1}, {0, 0, 1}, 0.3), (Vec3{0, 0, 1}));
}

TEST(Geometry, RotationTurnsCounterClockwiseAndIsOrthogonal) {
  const Vec3 turned = rotation_about({0, 0, 1}, kPi / 2) * Vec3{1, 0, 0};
  EXPECT_NEAR(length(turned - Vec3{0, 1, 0}), 0.0, 1e-15);
  std::mt19937 random(3);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 n = random_unit(random), v = random_unit(random);
    const double angle = 3.0 * n.x + v.y;
    const Rotation r = rotation_about(n, angle);
    EXPECT_NEAR(length(r * n - n), 0.0, 1e-14);
    EXPECT_NEAR(length(transposed(r) * (r * v) - v), 0.0, 1e-14);
    EXPECT_NEAR(length((rotation_about(n, 0.4) * r) * v - rotation_about(n, angle + 0.4) * v), 0.0, 1e-14);
    // The triple product gives the sense of the turn.
    EXPECT_NEAR(dot(cross(v, r * v), n), std::sin(angle) * (1.0 - dot(n, v) * dot(n, v)), 1e-14);
  }
}

TEST(Geometry, PointsAndDisplacements) {
  const Point<Part> p{1, 2, 3}, q{5, 2, 0};
  EXPECT_EQ(distance(p, q), 5.0);
  EXPECT_EQ(lerp(p, q, 0.5), (Point<Part>{3, 2, 1.5}));
  EXPECT_EQ(p + (q - p), q);
  EXPECT_FALSE(is_finite(Point<Part>{0, std::nan(""), 0}));
}

TEST(Units, DegreesAndFeeds) {
  EXPECT_DOUBLE_EQ(Angle::from_degrees(180).radians(), kPi);
  EXPECT_DOUBLE_EQ(Angle::from_radians(kPi / 6).degrees(), 30.0);
  EXPECT_DOUBLE_EQ(Feed::from_mm_per_min(600).mm_per_s(), 10.0);
}

TEST(Decimal, Text) {
  const struct {
    double value;
    int decimals;
    const char* text;
  } table[]{{0, 4, "0"},
            {-0.0, 4, "0"},
            {-0.00004, 4, "0"},
            {0.00006, 4, "0.0001"},
            {1, 4, "1"},
            {-1.5, 4, "-1.5"},
            {100, 0, "100"},
            {12.34567, 4, "12.3457"},
            {-0.05, 2, "-0.05"},
            {1e20, 2, "100000000000000000000"},
            {999.99996, 4, "1000"},
            {0.000000001, 9, "0.000000001"}};
  for (const auto& row : table) EXPECT_EQ(decimal(row.value, row.decimals), row.text);
}

TEST(Decimal, RoundedValueIsWhatItsTextReadsBackAs) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> any(-2000, 2000);
  for (int decimals = 0; decimals <= kMaxDecimals; ++decimals) {
    for (int i = 0; i < 20000; ++i) {
      const double value = any(random), rounded = round_decimal(value, decimals);
      const std::string text = decimal(value, decimals);
      double back = 0.0;
      std::from_chars(text.data(), text.data() + text.size(), back);
      ASSERT_EQ(back, rounded) << text;
      ASSERT_LE(std::abs(rounded - value), 0.5000001 * std::pow(10.0, -decimals));
      ASSERT_EQ(text, decimal(rounded, decimals));
    }
  }
}

}  // namespace
}  // namespace tiltfeed
