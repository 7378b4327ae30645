// Whether a program is complete: what the tool reaches, in closed form, and what is left of it.
#include "sim/removal/rest.h"

#include <gtest/gtest.h>

#include "tests/shapes/plate_program.h"

namespace tiltfeed::sim {
using namespace pathgen;
using namespace config;
namespace {

/// A block with a slot along y, `width` wide and `deep` deep, its floor at z = 0, open at both ends.
Mesh slotted(double width, double deep) {
  const double w = width / 2.0;
  return box_mesh({{Vec3{-30, -20, -5}, Vec3{30, 20, 0}},
                   {Vec3{-30, -20, 0}, Vec3{-w, 20, deep}},
                   {Vec3{w, -20, 0}, Vec3{30, 20, deep}}});
}

Job job_with(double diameter) {
  Job job = make_job();
  job.plan.cutter = {diameter, 100.0, 60.0};
  return job;
}

TEST(Reach, EndsWhereTheBallMeetsTheWalls) {
  const Mesh mesh = slotted(10.0, 8.0);
  const PartDistance surface(mesh);
  const Job job = job_with(4.0);
  const Reach reach(job, surface);
  for (const double x : {-2.99, -1.0, 0.0, 2.99}) EXPECT_TRUE(reach.touches({x, 0, 0}, {0, 0, 1})) << x;
  for (const double x : {-4.9, -3.01, 3.01, 4.0}) EXPECT_FALSE(reach.touches({x, 0, 0}, {0, 0, 1})) << x;
  EXPECT_TRUE(reach.touches({-20, 3, 8}, {0, 0, 1}));
  EXPECT_FALSE(reach.touches({-20, 3, -5}, {0, 0, -1})) << "turned away";
  EXPECT_FALSE(reach.touches({5, 3, 4}, {-1, 0, 0})) << "a wall";
  const Mesh narrow = slotted(3.9, 8.0);
  const PartDistance narrow_surface(narrow);
  EXPECT_FALSE(Reach(job, narrow_surface).touches({0, 0, 0}, {0, 0, 1}));
}

TEST(Reach, HoldsShankHolderContainmentAndTiltAgainstTheJob) {
  const Mesh mesh = slotted(10.0, 50.0);
  const PartDistance surface(mesh);
  Job job = job_with(4.0);
  job.plan.cutter = {4.0, 100.0, 30.0};
  const auto floor = [&] { return Reach(job, surface).touches({0, 0, 0}, {0, 0, 1}); };
  EXPECT_TRUE(floor());
  job.plan.cutter.holder = {{16.0, 20.0, 30.0}};
  EXPECT_FALSE(floor()) << "the holder does not fit into the slot";
  job.plan.holder.reaction = Reaction::kReport;
  EXPECT_TRUE(floor());
  job.plan.containment.first = {1.0, 5.0};
  EXPECT_FALSE(floor());
  job.plan.containment.first = {-1.0, 5.0};
  EXPECT_TRUE(floor());
  job.plan.up = {1, 0, 0}, job.plan.tilt_max = Angle::from_degrees(80);
  EXPECT_FALSE(floor());
  job.plan.up = {0, 0, 1}, job.plan.allowance = 3.1;
  EXPECT_FALSE(floor()) << "with stock on both walls a ball of 4 mm needs 10.2 mm";
}

TEST(Reach, AsksThatTheToolComesOffByTheClearance) {
  // 6 mm over the shank, where the tool touches the floor.
  const Mesh mesh = box_mesh({{Vec3{-10, -10, -5}, Vec3{10, 10, 0}}, {Vec3{-10, -10, 66}, Vec3{10, 10, 68}}});
  const PartDistance surface(mesh);
  Job job = job_with(4.0);
  job.plan.axis = {AxisMode::kFixed, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 0.0};
  for (const auto& [clearance, comes_off] : {std::pair{2.0, true}, {8.0, false}}) {
    job.plan.links.clearance = clearance;
    EXPECT_EQ(Reach(job, surface).touches({1, 2, 0}, {0, 0, 1}), comes_off) << clearance;
  }
}

TEST(Reach, FollowsEachAxisField) {
  const Mesh mesh = box_mesh({{Vec3{-10, -10, -10}, Vec3{10, 10, 10}}});
  const PartDistance surface(mesh);
  Job job = job_with(4.0);
  struct Case {
    AxisFrame axis;
    bool top, side, end;
  };
  const Vec3 x{1, 0, 0}, z{0, 0, 1};
  for (const Case& c :
       {Case{{AxisMode::kFixed, Sense::kOutward, {}, x, z, 0.0}, true, false, false},
        Case{{AxisMode::kLine, Sense::kOutward, {}, z, x, 0.0}, false, true, true},
        Case{{AxisMode::kLine, Sense::kOutward, {}, x, z, 0.0}, true, true, false},
        Case{{AxisMode::kPoint, Sense::kOutward, {}, x, z, 0.0}, true, true, true},
        Case{{AxisMode::kPoint, Sense::kInward, {0, 0, 60}, x, {0, 0, -1}, 0.0}, true, false, false},
        Case{{AxisMode::kFree, Sense::kOutward, {}, x, z, 0.0}, true, true, true}}) {
    job.plan.axis = c.axis;
    const Reach reach(job, surface);
    EXPECT_EQ(reach.touches({1, 2, 10}, z), c.top);
    EXPECT_EQ(reach.touches({1, 10, 2}, {0, 1, 0}), c.side);
    EXPECT_EQ(reach.touches({10, 2, 1}, x), c.end);
  }
}

/// Two slopes that rise from a fold along y, by `rise` (rad) each.
Mesh folded(double rise) {
  Mesh mesh;
  const double up = 20.0 * std::tan(rise);
  mesh.vertices = {{-20, -20, up}, {0, -20, 0}, {20, -20, up}, {-20, 20, up}, {0, 20, 0}, {20, 20, up}};
  mesh.facets = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
  mesh.source = {0, 1, 2, 3};
  return mesh;
}

/// A hollow is made of flat facets; next to a fold between them the ball stays off by less than the
/// tolerance.
TEST(Reach, FoldsBetweenTheFacetsOfAHollowAreReached) {
  const Job job = job_with(6.0);
  const auto reached = [&](double rise) {
    const Mesh mesh = folded(rise);
    const PartDistance surface(mesh);
    const Point<Part> place{0.01, 3, 0.01 * std::tan(rise)};
    return Reach(job, surface).touches(place, {-std::sin(rise), 0, std::cos(rise)});
  };
  // R (1 - cos 2 rise): how deep the ball that touches one facet at the fold is in the other.
  const double just = std::acos(1.0 - job.plan.tolerance / 3.0) / 2.0;
  EXPECT_TRUE(reached(0.7 * just));
  EXPECT_FALSE(reached(2.0 * just));
}

/// The verdict on the plate's program without those of its rows.
struct Judged {
  Removal removal;
  RemovalVerdict verdict;
};
Judged run_without(std::size_t first, std::size_t count, std::optional<double> side_step = {}) {
  Shop shop;
  if (side_step) shop.job.plan.pattern.side_step = *side_step;
  shop.job.plan.containment.first = {-6.0, 6.0}, shop.job.plan.containment.second = {-3.0, 3.0};
  constexpr std::size_t kRow = 27;  // lines: down, on the surface, 24 cuts, up
  shop.lines.erase(shop.lines.begin() + 1 + static_cast<std::ptrdiff_t>(first * kRow),
                   shop.lines.begin() + 1 + static_cast<std::ptrdiff_t>((first + count) * kRow));
  std::string text;
  for (const std::string& line : shop.lines) text += line + "\n";
  std::istringstream in(text);
  const auto path =
      execute_program(*read_program(in, "p.nc", 'A', 'C'), "p.nc", shop.job.machine.model, shop.job.setup);
  const auto shape = parse_stock("offset:0.5");
  auto stock = make_stock(*shape, shop.part, shop.job, 0.5, 2);
  RemovalOptions options;
  options.rest_limit = rest_limit(shop.job.plan);
  Probes probes(shop.part.mesh, 0.05, probe_reach(shop.job, options.rest_limit));
  auto cut = remove_material(shop.job, *path, *stock, probes, options, {});
  EXPECT_TRUE(cut);
  const RemovalContext context{shop.job, shop.part, *shape, "p.nc", {}};
  const RemovalVerdict verdict = judge(*cut, context);
  return {std::move(*cut), verdict};
}

// (verdict.h, property 5)
TEST(Rest, AWholeProgramPassesAndOneWithoutRowsIsIncomplete) {
  const Judged whole = run_without(0, 0);
  EXPECT_TRUE(whole.verdict.passed()) << whole.verdict.rest;
  EXPECT_STREQ(whole.verdict.word(), "passed");
  EXPECT_LT(whole.removal.rest.area, 0.1);

  // Rows at y = -0.6, -0.2, 0.2 are missing: between -1 and 0.6 the ball leaves r - sqrt(r^2 - e^2) at the
  // distance e from the nearer row.
  const Judged less = run_without(6, 3);
  EXPECT_TRUE(less.verdict.incomplete());
  EXPECT_STREQ(less.verdict.word(), "incomplete");
  EXPECT_TRUE(less.verdict.failures.empty());
  const double limit = less.removal.rest.limit, half = 0.8;
  EXPECT_NEAR(limit, 0.01 + 4.0 * (kRadius - std::sqrt(kRadius * kRadius - 0.04)), 1e-12);
  const double near = std::sqrt(2.0 * kRadius * limit - limit * limit);
  EXPECT_NEAR(less.removal.rest.area, 12.0 * 2.0 * (half - near), 0.1 * 12.0);
  // The rows on both sides are the cause, (W10).
  EXPECT_NEAR(less.removal.rest.apart, 2.0 * half, 1e-3);
  EXPECT_NEAR(less.removal.rest.between_passes, less.removal.rest.area, 0.05 * less.removal.rest.area);
  EXPECT_NE(less.verdict.rest.find("passes lie too far apart on the part, up to 1.6 mm: use a smaller"),
            std::string::npos)
      << less.verdict.rest;
  EXPECT_NEAR(less.removal.rest.left, kRadius - std::sqrt(kRadius * kRadius - half * half), 0.02);
  EXPECT_NEAR(less.removal.rest.place.y, -0.2, 0.3);
  EXPECT_NE(less.verdict.rest.find("facet"), std::string::npos) << less.verdict.rest;
}

/// Of an indexed job the direction counts in which its program cuts; others are told besides.
TEST(Rest, AnIndexedProgramIsHeldAgainstItsOwnDirections) {
  for (const AxisMode mode : {AxisMode::kFixed, AxisMode::kIndexed}) {
    // One row along x on the plate, the axis upright; the underside is there for other directions.
    Shop shop;
    shop.job.plan.axis.mode = mode;
    shop.lines.clear();
    for (const double x : {-6.0, 6.0}) shop.move(x < 0.0 ? "G0" : "G1", {{x, 0.0, 0.0}, {0, 0, 1}});
    std::string text;
    for (const std::string& line : shop.lines) text += line + "\n";
    std::istringstream in(text);
    const auto path =
        execute_program(*read_program(in, "p.nc", 'A', 'C'), "p.nc", shop.job.machine.model, shop.job.setup);
    ASSERT_TRUE(path) << path.error().message;
    Probes probes(shop.part.mesh, 0.1, 1.0);
    auto stock = make_stock(*parse_stock("offset:0.5"), shop.part, shop.job, 0.5, 2);
    RemovalOptions options;
    options.rest_limit = rest_limit(shop.job.plan);
    const auto cut = remove_material(shop.job, *path, *stock, probes, options, {});
    ASSERT_TRUE(cut);
    const Vec3 size = shop.part.bounds.max - shop.part.bounds.min;
    EXPECT_GT(cut->rest.area, 0.5 * size.x * size.y) << "the rest of the upper side";
    EXPECT_LT(cut->rest.area, size.x * size.y);
    if (mode == AxisMode::kFixed)
      EXPECT_EQ(cut->rest.elsewhere, 0.0);
    else
      EXPECT_GT(cut->rest.elsewhere, 0.9 * size.x * size.y) << "the underside";
  }

  // A wall of a wide slot is reached from the side, by a direction that leans from it by less than 75
  // degrees.
  const Mesh mesh = slotted(40.0, 8.0);
  const PartDistance surface(mesh);
  Job job = job_with(4.0);
  job.plan.axis.mode = AxisMode::kIndexed;
  const Point<Part> wall{20, 3, 5};
  const Vec3 out{-1, 0, 0}, up{0, 0, 1};
  const auto leaning = [](double degrees) {
    const double turn = degrees * kPi / 180.0;
    return Vec3{-std::cos(turn), 0, std::sin(turn)};
  };
  EXPECT_TRUE(Reach(job, surface).touches(wall, out));
  EXPECT_FALSE(Reach(job, surface, {up}).touches(wall, out));
  EXPECT_TRUE(Reach(job, surface, {up, leaning(60)}).touches(wall, out));
  EXPECT_TRUE(Reach(job, surface, {leaning(74)}).touches(wall, out));
  EXPECT_FALSE(Reach(job, surface, {leaning(75.5)}).touches(wall, out)) << "beyond axis.steepest_deg";
  job.plan.indexed.steepest = Angle::from_degrees(50);
  EXPECT_FALSE(Reach(job, surface, {up, leaning(60)}).touches(wall, out));
}

/// Rows that are 3.6 apart, as asked: ridges of 1.13, more than the stock that nobody gave.
TEST(Rest, HighRidgesThatWereAskedForAreComplete) {
  const Judged wide = run_without(4, 8, 3.6);
  EXPECT_TRUE(wide.verdict.passed()) << wide.verdict.rest;
  EXPECT_GT(wide.removal.rest.limit, 2.0);
  EXPECT_LT(wide.removal.rest.area, 0.1);
}

TEST(Rest, WhatTouchesAStockThatNobodyGaveIsNoTrouble) {
  Shop shop;
  const auto at = [](double x, double up) { return Pose{{x, 4.0, up}, {0, 0, 1}}; };
  for (const Pose& pose : {at(-6, 10), at(-6, 0.1), at(6, 0.1), at(6, 10)}) shop.move("G0", pose);
  std::string text;
  for (const std::string& line : shop.lines) text += line + "\n";
  for (const bool known : {true, false}) {
    std::istringstream in(text);
    const auto path =
        execute_program(*read_program(in, "p.nc", 'A', 'C'), "p.nc", shop.job.machine.model, shop.job.setup);
    auto stock = make_stock(*parse_stock("box:0.5"), shop.part, shop.job, 0.25, 2);
    Probes probes(shop.part.mesh, 0.5, 0.5);
    RemovalOptions options;
    options.stock_known = known;
    const auto cut = remove_material(shop.job, *path, *stock, probes, options, {});
    ASSERT_TRUE(cut);
    EXPECT_EQ(first_of(*cut, TroubleKind::kRapidStock) != nullptr, known);
  }
}

// (verdict.h, property 5)
TEST(Rest, WhatTheJobLeavesOutIsNotMissing) {
  const Judged half = run_without(8, 8);
  EXPECT_TRUE(half.verdict.incomplete());
  EXPECT_TRUE(half.removal.rest.never_cut);
  EXPECT_LT(half.removal.rest.between_passes, 0.05 * half.removal.rest.area)
      << "there is no row on that side";
  EXPECT_GT(half.removal.rest.out_of_reach, 100.0) << "sides, bottom, and the top outside of the containment";
}

}  // namespace
}  // namespace tiltfeed::sim
