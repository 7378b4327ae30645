// Proposals for the parts by formula, of which the set-ups are known; features of turned, moved parts; and
// random placements.
#include "pathgen/suggest/suggest.h"

#include <gtest/gtest.h>

#include <random>

#include "kinematics/machine/machine.h"
#include "pathgen/suggest/features.h"
#include "pathgen/suggest/mounting.h"
#include "pathgen/suggest/placements.h"
#include "pathgen/suggest/plain_faces.h"
#include "sim/parts/parts.h"
#include "tests/shapes/turned_parts.h"
#include "tests/shapes/wide_machine.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kNear = 0.1;  // mm
const double kTurned = Angle::from_degrees(0.1).radians();

/// A head that tilts by 110 degrees over a turning table.
MachineModel table_head() {
  MachineModel machine = wide_machine();
  machine.tilt.min = -110.0, machine.tilt.max = 110.0;
  for (LinearAxis* axis : {&machine.x, &machine.y, &machine.z}) axis->min = -600.0, axis->max = 800.0;
  return machine;
}

CheckedMesh formula(const char* name) {
  Stl stl;
  stl.facets = *sim::part_by_name(name);
  return checked(stl);
}

/// Turned and moved: nothing about it is along an axis.
const Rotation kTurn = rotation_about(normalized(Vec3{1, 2, 3}), 0.7);
const Vec3 kShift{120, -340, 560};
CheckedMesh moved(CheckedMesh part) {
  bool first = true;
  for (Point<Part>& v : part.mesh.vertices) {
    v = Point<Part>{} + kTurn * from_origin(v) + kShift;
    part.bounds = first ? Box{v, v} : grown(part.bounds, v);
    first = false;
  }
  return part;
}

SuggestOptions asked(double diameter, const MachineModel* machine) {
  SuggestOptions o;
  o.tool.cutter = {diameter, 120.0, 40.0};
  o.machine = machine;
  return o;
}

bool is_field(const Proposal& p) {
  return p.axis.mode != AxisMode::kFree && p.axis.mode != AxisMode::kIndexed;
}

TEST(Suggest, FindsThePapersSetUps) {
  const MachineModel machine = table_head();
  const auto tyre = suggest(formula("tyre"), asked(2.0, &machine));
  ASSERT_TRUE(tyre) << tyre.error().message;
  const AxisFrame& circle = tyre->proposals[0].axis;
  EXPECT_EQ(circle.mode, AxisMode::kCircle);
  EXPECT_EQ(circle.sense, Sense::kInward);
  EXPECT_LT(length(from_origin(circle.origin)), kNear);
  EXPECT_NEAR(circle.circle_radius, 280.0, kNear);
  EXPECT_LT(length(cross(axis_of(circle), Vec3{0, 1, 0})), kTurned);

  const auto pin = suggest(formula("pin"), asked(2.0, &machine));
  ASSERT_TRUE(pin) << pin.error().message;
  const AxisFrame& line = pin->proposals[0].axis;
  EXPECT_EQ(line.mode, AxisMode::kLine);
  EXPECT_EQ(line.sense, Sense::kOutward);
  EXPECT_LT(std::hypot(line.origin.x, line.origin.z), kNear);
  EXPECT_LT(length(cross(line.t, Vec3{0, 1, 0})), kTurned);

  // The paper machines these two with the axis free; the sphere's centre is among the proposals.
  for (const char* name : {"sphere", "handle"}) {
    const auto found = suggest(formula(name), asked(6.0, &machine));
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(found->proposals[0].axis.mode, AxisMode::kFree) << name;
    if (name != std::string("sphere")) continue;
    const auto centre = std::find_if(found->proposals.begin(), found->proposals.end(), [](const Proposal& p) {
      return p.axis.mode == AxisMode::kPoint && p.source == "fitted";
    });
    ASSERT_NE(centre, found->proposals.end());
    EXPECT_LT(length(from_origin(centre->axis.origin)), kNear);
  }
}

TEST(Suggest, FindsFeaturesOfTurnedAndMovedParts) {
  for (const char* name : {"tyre", "pin", "sphere"}) {
    SCOPED_TRACE(name);
    const CheckedMesh part = moved(formula(name));
    PlanOptions tool;
    tool.cutter = {2.0, 120.0, 40.0};
    const ReachScene scene(part, tool);
    const auto features = find_features(part.mesh, part.bounds, scene.sample(3000));
    const Point<Part> zero = Point<Part>{} + kShift;
    const Vec3 axis = kTurn * Vec3{0, 1, 0};
    const AxisMode wanted = name == std::string("tyre")  ? AxisMode::kCircle
                            : name == std::string("pin") ? AxisMode::kLine
                                                         : AxisMode::kPoint;
    const auto found =
        std::find_if(features.begin(), features.end(), [&](const Feature& f) { return f.mode == wanted; });
    ASSERT_NE(found, features.end());
    const Vec3 off = found->centre - zero;
    // Corners are of single precision about 700 mm from zero.
    EXPECT_LT(wanted == AxisMode::kLine ? length(cross(off, axis)) : length(off), 1e-3);
    if (wanted != AxisMode::kPoint) {
      EXPECT_LT(length(cross(found->axis, axis)), 1e-5);
    }
    if (wanted == AxisMode::kCircle) {
      EXPECT_NEAR(found->radius, 280.0, 1e-3);
    }
  }
}

TEST(Suggest, ReachesWhatRandomPlacementsDo) {
  const MachineModel machine = table_head();
  for (const char* name : {"pin"}) {
    SCOPED_TRACE(name);
    const CheckedMesh part = formula(name);
    const SuggestOptions options = asked(2.0, &machine);
    const auto found = suggest(part, options);
    ASSERT_TRUE(found) << found.error().message;
    double best = 0.0, field = 0.0;
    for (const Proposal& p : found->proposals) {
      best = std::max(best, p.share());
      if (is_field(p)) field = std::max(field, p.share());
    }
    const ReachScene scene(part, options.tool);
    const auto places = scene.sample(300);
    const Mounting mounting(&machine, part.bounds, 120.0);
    const double size = distance(part.bounds.min, part.bounds.max);
    std::mt19937 random(3);
    const auto even = [&] { return std::uniform_real_distribution<double>(-1.0, 1.0)(random); };
    double most = 0.0;
    for (int k = 0; k < 60; ++k) {
      constexpr AxisMode kModes[] = {AxisMode::kPoint, AxisMode::kLine, AxisMode::kCircle, AxisMode::kFixed};
      const Point<Part> at =
          lerp(part.bounds.min, part.bounds.max, 0.5) + Vec3{even(), even(), even()} * size;
      const AxisFrame frame =
          frame_about(kModes[k % 4], k % 8 < 4 ? Sense::kOutward : Sense::kInward, at,
                      normalized(Vec3{even(), even(), even() + 1e-3}), size * (0.51 + 0.5 * even()));
      for (const Vec3 way : mounting.quarters()) {
        const MachineReach reach(machine, mounting.setup(way, std::nullopt));
        ReachQuestion q;
        q.axis = frame, q.machine = &reach;
        most = std::max(most, scene.ask(q, places, Rays::kRim).share(Reach::kCut));
      }
    }
    EXPECT_GE(best, 0.95 * most);
    EXPECT_GE(field, 0.95 * most);
    EXPECT_GE(found->proposals[0].share(), 0.95 * most);
  }
}

/// What is proposed is what a job for the machine may ask: within its tilt limit, drawn back within the
/// travels.
TEST(Suggest, ProposesWhatTheMachineGives) {
  const CheckedMesh part = formula("pin");
  MachineModel level = table_head();
  level.tilt.min = -90.0, level.tilt.max = 90.0;
  EXPECT_NEAR(tilt_limit(level).degrees(), 89.5, 1e-9);
  MachineModel low = table_head();
  low.z.max = part.bounds.max.z - part.bounds.min.z;
  MachineModel tilt_alone = table_head(), turn_alone = table_head();
  tilt_alone.rotary.present = false, tilt_alone.tilt.max = 60.0;
  turn_alone.tilt.present = false;
  EXPECT_NEAR(tilt_limit(tilt_alone).degrees(), 59.5, 1e-9);
  EXPECT_EQ(tilt_limit(turn_alone).degrees(), 180.0);
  for (const MachineModel* machine : {&level, &low, &tilt_alone, &turn_alone}) {
    const auto found = suggest(part, asked(2.0, machine));
    ASSERT_TRUE(found) << found.error().message;
    double most = 0.0;
    for (const Proposal& p : found->proposals) most = std::max(most, p.share());
    for (const Proposal& p : found->proposals) {
      EXPECT_GE(p.share(), 0.1 * most);
      const bool every_way = p.axis.mode == AxisMode::kFree || p.axis.mode == AxisMode::kIndexed;
      EXPECT_FALSE(every_way && !(machine->tilt.present && machine->rotary.present));
      if (p.axis.mode != AxisMode::kFixed) continue;
      const Vec3 axis = p.setup.fixture * p.axis.n;
      EXPECT_LE(angle_between(axis, {0, 0, 1}), tilt_limit(*machine).radians() + 1e-5);
      // Over all of the part by the clearance, the tool's tip as it stands there.
      const Point<Part> top{};
      double highest = -1e9;
      for (const Point<Part> v : part.mesh.vertices) highest = std::max(highest, dot(v - top, p.axis.n));
      const auto joints = inverse(*machine, p.setup, {top + p.axis.n * highest, p.axis.n}, 0.0);
      ASSERT_TRUE(joints) << joints.error().message;
      EXPECT_LE(std::min((*joints)[0].z, (*joints)[1].z), machine->z.max);
    }
  }
}

TEST(Suggest, SaysWhatBecomesOfAllTheSurface) {
  const MachineModel machine = table_head();
  const CheckedMesh part = solid_ball(20.0, 12);
  const auto found = suggest(part, asked(4.0, &machine));
  ASSERT_TRUE(found) << found.error().message;
  for (const Proposal& p : found->proposals) {
    double sum = 0.0;
    for (std::size_t i = 0; i < kReaches; ++i) sum += p.reach.share(static_cast<Reach>(i));
    EXPECT_NEAR(sum, 1.0, 1e-12);
    EXPECT_EQ(p.reach.places.size(), found->places);
    EXPECT_NEAR(dot(p.axis.t, p.axis.n), 0.0, 1e-12);
    EXPECT_NEAR(length(p.axis.t), 1.0, 1e-12);
    EXPECT_NEAR(length(p.axis.n), 1.0, 1e-12);
  }
  // The machine tilts by 110 degrees: of a ball at its centre nearly 1 - (1 + cos 110) / 2 of the surface.
  const auto fitted = std::find_if(found->proposals.begin(), found->proposals.end(), [](const Proposal& p) {
    return p.axis.mode == AxisMode::kPoint && p.source == "fitted";
  });
  ASSERT_NE(fitted, found->proposals.end());
  EXPECT_NEAR(fitted->share(), (1.0 - std::cos(Angle::from_degrees(110.0).radians())) / 2.0, 0.02);
  EXPECT_NEAR(fitted->share() + fitted->reach.share(Reach::kTilt), 1.0, 1e-9);
}

TEST(Suggest, PutsThePartUprightWhereTheMachineNeedsIt) {
  // A tool that tilts by 95 degrees goes all round a line only if that stands upright.
  MachineModel machine = table_head();
  machine.tilt.min = -95.0, machine.tilt.max = 95.0;
  Outline outline{{0, 0}, {15, 0}, {15, 60}, {0, 60}};
  Stl stl;
  revolve(outline, 40, stl);
  const CheckedMesh upright = checked(stl), leaning = moved(upright);
  const Mounting mounting(&machine, leaning.bounds, 100.0);
  std::vector<CutPose> poses;
  for (int k = 0; k < 100; ++k) {
    const double turn = 2.0 * kPi * k / 100.0;
    const Vec3 axis = kTurn * Vec3{std::cos(turn), std::sin(turn), 0.0};
    poses.push_back({{Point<Part>{} + kTurn * Vec3{0, 0, 30} + kShift + axis * 15.0, axis}, 1.0});
  }
  const Mounted without = mounting.best(poses, std::nullopt, std::nullopt);
  const Mounted with = mounting.best(poses, kTurn * Vec3{0, 0, 1}, std::nullopt);
  EXPECT_LT(without.area, 95.0);
  EXPECT_NEAR(with.area, 100.0, 1e-9);
  EXPECT_NEAR(std::abs((with.setup.fixture * (kTurn * Vec3{0, 0, 1})).z), 1.0, 1e-12);
  // The head stays above the table.
  const auto raised = mounting.raised(with.setup, poses);
  for (const CutPose& p : poses) {
    const double tip = (raised.fixture * from_origin(p.pose.tip)).z + raised.part_zero.z;
    EXPECT_GE(tip, 100.0 - 1e-9);
  }
}

TEST(Suggest, CountsLargePlanesAndCylindersLittle) {
  Outline outline{{0, 0}, {15, 0}};
  arc(outline, 15.0, kPi / 2.0, 0.0, 20);
  outline.erase(outline.begin() + 2);
  for (auto& p : outline) p[1] += p[1] > 0.0 ? 40.0 : 0.0;
  outline.insert(outline.begin() + 2, {15, 40});
  Stl stl;
  revolve(outline, 60, stl);
  const CheckedMesh part = checked(stl);
  PlanOptions tool;
  tool.cutter = {2.0, 120.0, 40.0};
  const ReachScene scene(part, tool);
  const auto places = scene.sample(4000);
  const double size = distance(part.bounds.min, part.bounds.max);
  const auto weights = weights_of(part.mesh, places, find_features(part.mesh, part.bounds, places), size);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const bool dome = places[i].place.z > 41.0, plain = places[i].place.z < 39.0;
    if (dome) {
      EXPECT_EQ(weights[i], places[i].area) << places[i].place.z;
    }
    if (plain) {
      EXPECT_EQ(weights[i], kPlainShare * places[i].area) << places[i].place.z;
    }
  }
}

}  // namespace
}  // namespace tiltfeed
