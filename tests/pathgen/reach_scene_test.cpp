// What a tool reaches: parts of which that is known in closed form, the plan's own report, moved parts.
#include "pathgen/reach/reach_scene.h"

#include <gtest/gtest.h>

#include <map>

#include "pathgen/plan/exact_reach.h"
#include "pathgen/plan/plan.h"
#include "sim/parts/parts.h"
#include "tests/shapes/box_mesh.h"
#include "tests/shapes/cut_passes.h"
#include "tests/shapes/turned_parts.h"
#include "tests/shapes/wide_machine.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

const Vec3 kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1};

CheckedMesh boxes(const std::vector<std::array<Vec3, 2>>& of) {
  const Mesh mesh = box_mesh(of);
  Stl stl;
  for (const auto& f : mesh.facets)
    stl.facets.push_back({mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]});
  auto part = check_mesh(stl);
  EXPECT_TRUE(part);
  return *part;
}

ReachQuestion towards(Vec3 axis) {
  ReachQuestion q;
  q.axis = {AxisMode::kFixed, Sense::kOutward, {}, std::abs(axis.x) > 0.9 ? kY : kX, axis, 0.0};
  q.axis.t = normalized(q.axis.t - axis * dot(axis, q.axis.t));
  return q;
}

/// By the direction of the normals of the facets at a height, with a ball of 4 mm.
std::map<Reach, double> areas(const ReachMap& map) {
  std::map<Reach, double> of;
  for (std::size_t i = 0; i < kReaches; ++i)
    if (map.area[i] > 0.0) of[static_cast<Reach>(i)] = map.area[i];
  return of;
}

TEST(Reach, OfBoxesIsWhatOneSees) {
  // A plate, and a second one above the half of it: a gap of 30 mm between them.
  const CheckedMesh part = boxes({{Vec3{0, 0, 0}, Vec3{40, 40, 10}}, {Vec3{0, 0, 40}, Vec3{20, 40, 50}}});
  PlanOptions tool = options_with({});
  const ReachScene scene(part, tool);
  const auto facets = scene.facets();
  ASSERT_EQ(facets.size(), part.mesh.facets.size());
  for (const Rays rays : {Rays::kAxis, Rays::kRim}) {
    const ReachMap map = scene.ask(towards(kZ), facets, rays);
    EXPECT_NEAR(map.whole(), 2 * 1600 + 4 * 400 + 2 * 800 + 2 * 400 + 2 * 200, 1e-9);
    EXPECT_NEAR(map.area[static_cast<int>(Reach::kAway)], 1600 + 800, 1e-9);
    for (std::size_t i = 0; i < facets.size(); ++i) {
      if (facets[i].place.z == 50.0) {
        EXPECT_EQ(map.places[i], Reach::kCut);
      }
    }
  }
  // Of the lower plate's top half is under the upper one; places in the free half near its edge are blocked
  // by the tool's width only.
  const auto fine = scene.sample(20'000);
  const auto top = [&](Rays rays) {
    const ReachMap map = scene.ask(towards(kZ), fine, rays);
    std::map<Reach, double> of;
    for (std::size_t i = 0; i < fine.size(); ++i)
      if (fine[i].place.z == 10.0 && fine[i].normal.z == 1.0) of[map.places[i]] += fine[i].area;
    return of;
  };
  EXPECT_NEAR(top(Rays::kAxis)[Reach::kCut], 800.0, 15.0);
  EXPECT_NEAR(top(Rays::kAxis)[Reach::kBlocked], 800.0, 15.0);
  EXPECT_NEAR(top(Rays::kRim)[Reach::kCut], 800.0 - 2.0 * 40.0, 25.0);
}

TEST(Reach, IsNarrowWhereTheCutterDoesNotFit) {
  const CheckedMesh part = boxes({{Vec3{0, 0, 0}, Vec3{20, 40, 20}},
                                  {Vec3{20, 0, 0}, Vec3{23, 40, 5}},
                                  {Vec3{23, 0, 0}, Vec3{40, 40, 20}}});
  for (const double diameter : {2.0, 4.0}) {
    PlanOptions tool = options_with({});
    tool.cutter.diameter = diameter;
    const ReachScene scene(part, tool);
    const auto places = scene.sample(50'000);
    const ReachMap map = scene.ask(towards(kZ), places, Rays::kRim);
    double narrow = 0.0, cut = 0.0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (places[i].place.z != 5.0) continue;
      (map.places[i] == Reach::kNarrow ? narrow : cut) += places[i].area;
    }
    // The floor of the slot, 3 mm wide: a ball of 2 mm reaches its middle third.
    EXPECT_NEAR(cut, diameter == 2.0 ? 40.0 : 0.0, 3.0);
    EXPECT_NEAR(cut + narrow, 120.0, 2.0);
  }
}

TEST(Reach, HeedsTiltAndTravels) {
  const CheckedMesh part = boxes({{Vec3{-20, -20, -20}, Vec3{20, 20, 20}}});
  PlanOptions tool = options_with({});
  const ReachScene scene(part, tool);
  const auto facets = scene.facets();
  ReachQuestion q = towards(kX);
  EXPECT_EQ(areas(scene.ask(q, facets, Rays::kAxis)).count(Reach::kTilt), 0u);
  q.tilt_max = Angle::from_degrees(89.0);
  const ReachMap leant = scene.ask(q, facets, Rays::kAxis);
  EXPECT_EQ(leant.area[static_cast<int>(Reach::kCut)], 0.0);
  EXPECT_NEAR(leant.area[static_cast<int>(Reach::kTilt)], 5 * 1600.0, 1e-9);
  q.tilt_max = Angle::from_degrees(90.0);
  EXPECT_EQ(areas(scene.ask(q, facets, Rays::kAxis)).count(Reach::kTilt), 0u);

  MachineModel machine = wide_machine();
  tiltfeed::Setup setup;
  setup.tool_length = 100.0;
  machine.tilt.min = -80.0, machine.tilt.max = 80.0;
  const MachineReach short_tilt(machine, setup);
  q.tilt_max = Angle::from_degrees(180.0), q.machine = &short_tilt;
  EXPECT_EQ(areas(scene.ask(q, facets, Rays::kAxis)).count(Reach::kTilt), 1u);
  machine = wide_machine();
  machine.z.min = -15.0;
  const MachineReach shallow(machine, setup);
  q = towards(kZ), q.machine = &shallow;
  const ReachMap low = scene.ask(q, facets, Rays::kAxis);
  // Tips are at the facets' middles less what the ball rolls: sides at their thirds.
  for (std::size_t i = 0; i < facets.size(); ++i) {
    if (facets[i].normal.z != 0.0) continue;
    EXPECT_EQ(low.places[i], facets[i].place.z - 2.0 < -15.0 ? Reach::kTravel : Reach::kCut)
        << facets[i].place.z;
  }
}

TEST(Reach, OfTheMachineIsThatOfItsForward) {
  MachineModel machine = wide_machine();
  machine.x = {-80, 90, 1000, 100}, machine.y = {-200, 150, 1000, 100}, machine.z = {-120, 60, 1000, 100};
  machine.tilt.min = -70, machine.tilt.max = 95, machine.rotary.min = -500, machine.rotary.max = 700;
  tiltfeed::Setup setup;
  setup.part_zero = {10, -20, 30}, setup.tool_length = 90.0;
  const MachineReach reach(machine, setup);
  // Every pose that joints within the limits make is reached; the box of joints around finds none of the
  // rest.
  unsigned state = 1;
  const auto even = [&](double low, double high) {
    state = state * 1664525u + 1013904223u;
    return low + (high - low) * (state >> 8) / 16777216.0;
  };
  for (int k = 0; k < 2000; ++k) {
    const Joints q{even(-80, 90), even(-200, 150), even(-120, 60), even(-70, 95), even(-500, 700)};
    EXPECT_FALSE(reach.refusal(forward(machine, setup, q)));
    const Joints off{even(-300, 300), even(-300, 300), even(-300, 300), even(-110, 110), even(-180, 180)};
    const Pose pose = forward(machine, setup, off);
    const auto both = inverse(machine, setup, pose, 0.0);
    ASSERT_TRUE(both);
    bool any = false;
    for (Joints joints : *both)
      for (const double turns : {-720.0, -360.0, 0.0, 360.0, 720.0}) {
        Joints turned = joints;
        turned.c += turns;
        any |= within_limits(machine, turned);
      }
    EXPECT_EQ(!reach.refusal(pose), any);
  }
}

TEST(Reach, OfAMovedPartIsTheSame) {
  const CheckedMesh part = solid_ball(20.0, 12);
  CheckedMesh moved = part;
  const Vec3 by{1000, -2000, 500};
  for (Point<Part>& v : moved.mesh.vertices) v = v + by;
  moved.bounds = {part.bounds.min + by, part.bounds.max + by};
  const PlanOptions tool = options_with({});
  const ReachScene here(part, tool), there(moved, tool);
  ReachQuestion q;
  q.axis = {AxisMode::kLine, Sense::kOutward, {1, 2, 0}, kX, kZ, 0.0};
  q.tilt_max = Angle::from_degrees(70.0);
  const ReachMap a = here.ask(q, here.facets(), Rays::kRim);
  q.axis.origin = q.axis.origin + by;
  const ReachMap b = there.ask(q, there.facets(), Rays::kRim);
  EXPECT_EQ(a.places, b.places);
}

struct Compared {
  ReachMap exact, coarse;
  RestReport report;
  CheckedMesh part;
  std::vector<ReachPlace> facets;
};

Compared compared(CheckedMesh mesh, const PlanOptions& o) {
  Compared c;
  c.part = std::move(mesh);
  const ReachScene scene(c.part, o);
  c.facets = scene.facets();
  ReachQuestion q;
  q.axis = o.axis, q.up = o.up, q.tilt_max = o.tilt_max;
  const auto exact = exact_reach(c.part, o, scene, c.facets, q);
  EXPECT_TRUE(exact) << exact.error().message;
  PlanOptions with_report = o;
  with_report.find_rest_material = true;
  const auto planned = plan(c.part, with_report, nullptr);
  EXPECT_TRUE(planned);
  c.exact = *exact, c.report = *planned->report.uncut;
  c.coarse = scene.ask(q, c.facets, Rays::kAxis);
  return c;
}

/// Facet by facet what the plan's report says, in the classifier's words.
void expect_agreement(const Compared& c) {
  std::map<std::uint32_t, RestFacet> uncut;
  for (const RestFacet& f : c.report.facets) uncut[f.facet] = f;
  std::uint64_t away = 0;
  for (std::size_t i = 0; i < c.facets.size(); ++i) {
    const Reach said = c.exact.places[i];
    if (said == Reach::kAway) {
      ++away;
      EXPECT_EQ(uncut.count(c.part.mesh.source[i]), 0u);
      continue;
    }
    const auto found = uncut.find(c.part.mesh.source[i]);
    const bool mostly = found != uncut.end() && found->second.share >= 0.5;
    EXPECT_EQ(said != Reach::kCut, mostly) << i;
    if (!mostly) continue;
    switch (found->second.why) {
      case RestReason::kCutter:
        EXPECT_TRUE(said == Reach::kNarrow || said == Reach::kBlocked) << i;
        break;
      case RestReason::kTilt:
        EXPECT_EQ(said, Reach::kTilt) << i;
        break;
      case RestReason::kWall:
        EXPECT_EQ(said, Reach::kWall) << i;
        break;
      default:
        EXPECT_EQ(said, Reach::kBlocked) << i;
    }
  }
  EXPECT_EQ(away, c.report.away);
  // In sum it is the report's area, though a large facet may face the tool in part.
  const double uncut_area = c.report.area + c.report.wall_area, whole = c.exact.whole();
  EXPECT_NEAR(whole * (1.0 - c.exact.share(Reach::kAway)), c.report.facing_area, 1e-6 * whole);
  EXPECT_NEAR(whole * c.exact.share(Reach::kCut), c.report.facing_area - uncut_area, 1e-6 * whole);
}

/// Share of the area of which the coarse answer says the same: cut or not.
double agreement(const Compared& c) {
  double same = 0.0, whole = 0.0;
  for (std::size_t i = 0; i < c.facets.size(); ++i) {
    const double area = c.facets[i].area;
    whole += area;
    same += (c.exact.places[i] == Reach::kCut) == (c.coarse.places[i] == Reach::kCut) ? area : 0.0;
  }
  return same / whole;
}

CheckedMesh formula(const char* name) {
  Stl stl;
  stl.facets = *sim::part_by_name(name);
  return checked(stl);
}

TEST(Reach, ExactIsThePlansReportAndCoarseIsNearIt) {
  PlanOptions sphere =
      options_with({AxisMode::kPoint, Sense::kOutward, {}, kX, normalized(Vec3{0, -0.57735, 0.8165}), 0.0});
  sphere.cutter = {10.0, 120.0, 60.0};
  sphere.pattern.side_step = 5.0, sphere.tilt_max = Angle::from_degrees(108.0);
  const Compared ball = compared(formula("sphere"), sphere);
  expect_agreement(ball);
  EXPECT_GT(agreement(ball), 0.99);
  EXPECT_GT(ball.exact.area[static_cast<int>(Reach::kTilt)], 0.0);

  PlanOptions handle = options_with({AxisMode::kLine, Sense::kOutward, {0, 0, 36}, kX, kZ, 0.0});
  handle.cutter = {6.0, 120.0, 50.0};
  handle.pattern.side_step = 4.0, handle.tilt_max = Angle::from_degrees(105.0);
  const Compared bow = compared(formula("handle"), handle);
  expect_agreement(bow);
  EXPECT_GT(agreement(bow), 0.99);
}

TEST(Reach, AnEndThatFacesTheToolInPartCountsInPart) {
  // The line leans: of each flat end, over which the ball's centre goes 12 mm from the line's origin, a
  // segment faces away.
  PlanOptions o = options_with({AxisMode::kLine,
                                Sense::kOutward,
                                {0, 0, 10},
                                normalized(Vec3{0.3, 0, 1}),
                                normalized(Vec3{1, 0, -0.3}),
                                0.0});
  const Compared rod = compared(turned({{0, 20}, {10, 20}, {10, 0}, {0, 0}}, 12), o);
  expect_agreement(rod);
  const double r = 10.0, h = 12.0 * 0.3, segment = r * r * std::acos(h / r) - h * std::sqrt(r * r - h * h);
  EXPECT_NEAR(rod.exact.whole() * rod.exact.share(Reach::kAway), 2.0 * segment, 0.1 * segment);
}

TEST(Reach, OfTheFreeAxisIsAllThatAnyDirectionSees) {
  // From outside a hollow ball's inside is seen through its hole only.
  const CheckedMesh part = hollow_ball(20.0, 25.0, 8.0, 24);
  PlanOptions tool = options_with({});
  const ReachScene scene(part, tool);
  const auto places = scene.sample(4000);
  ReachQuestion q;
  q.axis.mode = AxisMode::kFree;
  const ReachMap map = scene.ask(q, places, Rays::kAxis);
  double inside = 0.0, seen = 0.0, outside = 0.0, cut = 0.0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const bool in = length(from_origin(places[i].place)) < 21.0;
    (in ? inside : outside) += places[i].area;
    if (map.places[i] == Reach::kCut) (in ? seen : cut) += places[i].area;
  }
  EXPECT_GT(cut, 0.99 * outside);
  EXPECT_GT(seen, 0.05 * inside);
  EXPECT_LT(seen, 0.9 * inside);
  q.tilt_max = Angle::from_degrees(40.0);
  const ReachMap leant = scene.ask(q, places, Rays::kAxis);
  EXPECT_LT(leant.area[static_cast<int>(Reach::kCut)], map.area[static_cast<int>(Reach::kCut)]);
  EXPECT_GT(leant.area[static_cast<int>(Reach::kTilt)], 0.0);
}

}  // namespace
}  // namespace tiltfeed
