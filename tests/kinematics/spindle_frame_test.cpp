// The spindle's frame and the angles that state it: a worked vector, the tool axis of every structure, angles
// back to their rotation.

#include "kinematics/machine/spindle_frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "kinematics/machine/machine.h"

namespace tiltfeed {
namespace {

Rotation about(Vec3 axis, double degrees) {
  return rotation_about(axis, Angle::from_degrees(degrees).radians());
}

double apart(const Rotation& a, const Rotation& b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < 3; ++i) worst = std::max(worst, length(a.rows[i] - b.rows[i]));
  return worst;
}

// (K14)
TEST(SpindleFrame, WorkedVectorInBothConventions) {
  const Rotation frame = about({0, 0, 1}, 40) * about({1, 0, 0}, 35) * about({0, 0, 1}, -20);
  const PlaneAngles zxz = zxz_angles(frame), zyx = zyx_angles(frame);
  EXPECT_NEAR(zxz[0], 40, 1e-9);
  EXPECT_NEAR(zxz[1], 35, 1e-9);
  EXPECT_NEAR(zxz[2], -20, 1e-9);
  EXPECT_NEAR(zyx[0], 23.39821, 5e-6);
  EXPECT_NEAR(zyx[1], 11.31335, 5e-6);
  EXPECT_NEAR(zyx[2], 33.34411, 5e-6);
  // The same as turns about fixed x, y, z in that order.
  const Rotation fixed = about({0, 0, 1}, zyx[0]) * about({0, 1, 0}, zyx[1]) * about({1, 0, 0}, zyx[2]);
  EXPECT_LT(apart(fixed, frame), 1e-12);
  EXPECT_NEAR(frame.rows[0].z, 0.368688, 5e-7);
  EXPECT_NEAR(frame.rows[1].z, -0.439385, 5e-7);
  EXPECT_NEAR(frame.rows[2].z, 0.819152, 5e-7);
}

TEST(SpindleFrame, AnglesGiveTheirRotationBack) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> angle(-180, 180);
  const auto expect_back = [](const Rotation& frame) {
    const PlaneAngles zxz = zxz_angles(frame), zyx = zyx_angles(frame);
    EXPECT_LT(apart(from_zxz(zxz), frame), 1e-9);
    EXPECT_LT(apart(from_zyx(zyx), frame), 1e-9);
    EXPECT_GE(zxz[1], 0.0);
    EXPECT_LE(std::abs(zyx[1]), 90.0);
  };
  for (int i = 0; i < 1000; ++i)
    expect_back(about({0, 0, 1}, angle(random)) * about({1, 0, 0}, angle(random)) *
                about({0, 0, 1}, angle(random)));
  // Where two of the turns are about one line.
  for (const double level : {0.0, 180.0}) expect_back(about({0, 0, 1}, 33) * about({1, 0, 0}, level));
  for (const double steep : {-90.0, 90.0}) expect_back(about({0, 0, 1}, -70) * about({0, 1, 0}, steep));
}

// (K14)
TEST(SpindleFrame, ItsZIsTheToolAndWithoutAHeadItsAxesAreTheSlides) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> angle(-90, 90), part(-1, 1);
  for (int i = 0; i < 300; ++i) {
    MachineModel m;
    m.structure = i % 3 == 0   ? Structure::kTableHead
                  : i % 3 == 1 ? Structure::kTableTable
                               : Structure::kHeadHead;
    m.tilt = {'A',
              normalized(Vec3{1, 0.2 * part(random), 0.7 * part(random)}),
              i % 2 == 0 ? 1 : -1,
              3.0,
              -180,
              180,
              3600,
              100};
    m.rotary = {'C',
                normalized(Vec3{0.1 * part(random), 0.1 * part(random), 1}),
                i % 4 < 2 ? 1 : -1,
                -7.0,
                -360,
                360,
                3600,
                100};
    m.pivot_to_gauge = {0, 1, -150};
    m.rotary_to_tilt = {5, 6, 40};
    if (i % 5 == 0) m.spindle = normalized(Vec3{0.1, 0.3, 1});
    tiltfeed::Setup setup;
    setup.part_zero = {20, 30, 40};
    setup.fixture = about({0, 0, 1}, 30) * about({1, 0, 0}, 90);
    setup.tool_length = 80;
    const Joints at{1, 2, 3, angle(random), angle(random)};
    const Rotation frame = spindle_frame(m, at.a, at.c);
    EXPECT_LT(apart(frame * transposed(frame), Rotation{}), 1e-14);
    const Pose pose = forward(m, setup, at);
    const Vec3 z{frame.rows[0].z, frame.rows[1].z, frame.rows[2].z};
    EXPECT_LT(length(z - setup.fixture * pose.axis), 1e-12);
    if (m.structure != Structure::kTableTable || m.spindle != Vec3{0, 0, 1}) continue;
    Joints along = at;
    along.x += 1.0;
    const Vec3 x = setup.fixture * (forward(m, setup, along).tip - pose.tip);
    EXPECT_LT(length(x - Vec3{frame.rows[0].x, frame.rows[1].x, frame.rows[2].x}), 1e-12);
  }
}

TEST(SpindleFrame, OfACTableAndAnAHeadIsTheWordsThemselves) {
  MachineModel m;
  m.tilt = {'A', {1, 0, 0}, +1, 0.0, -120, 120, 3600, 100};
  m.rotary = {'C', {0, 0, 1}, -1, 0.0, -360, 360, 3600, 100};
  const PlaneAngles angles = zxz_angles(spindle_frame(m, 35, 40));
  EXPECT_NEAR(angles[0], 40, 1e-12);
  EXPECT_NEAR(angles[1], 35, 1e-12);
  EXPECT_NEAR(angles[2], 0, 1e-12);
}

}  // namespace
}  // namespace tiltfeed
